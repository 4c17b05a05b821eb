#include "tools/gap/explain/experiment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "tools/gap/explain/stacked_evidence.hpp"

namespace airside::tools::gap {

namespace {

/// The changes with one parameter moved by a prior standard deviation, and which way.
std::pair<Changes, double> with_parameter_moved(Changes changes, const Parameter& parameter) {
  const sim::Effect& effect = *parameter.at.effect;
  for (sim::EffectChange& change : changes) {
    if (change.at.id() != parameter.at.id()) continue;
    const double sign = change.magnitude + parameter.prior_sd <= effect.high ? 1 : -1;
    change.magnitude += sign * parameter.prior_sd;
    return {std::move(changes), sign};
  }
  changes.push_back({parameter.at, effect.null_value + parameter.prior_sd});
  return {std::move(changes), 1};
}

/// d_ab^2: magnitudes have a sign, so what points the other way explains nothing.
double distance_of(const Eigen::MatrixXd& products, Eigen::Index a, Eigen::Index b) {
  const double aa = products(a, a), ab = products(a, b), bb = products(b, b);
  return std::max(0.0, ab > 0 && bb > 1e-9 ? aa - ab * ab / bb : aa);
}

/// What is left out of a comparison: channels that the window has not, and duties that a test commands.
Eigen::MatrixXd missing_in_test(const Eigen::MatrixXd& measured, Eigen::Index bins, const sim::Channels& channels,
                                bool fan_coils_commanded) {
  Eigen::MatrixXd missing = Eigen::MatrixXd::Zero(bins, measured.cols());
  for (Eigen::Index c = 0; c < measured.cols(); ++c) {
    const bool absent = !measured.col(c).array().isFinite().any();
    if (absent || (fan_coils_commanded && c >= channels.fcu_duty()))
      missing.col(c).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return missing;
}

/// One test with what the model says of it.
struct TriedTest {
  TestPlan plan;
  TestRecording test;
  std::vector<sim::ChannelTable> tables;  ///< of the fitted model, then of each member
  Eigen::MatrixXd missing;
  std::vector<bool> kept;
  ExperimentProposal proposal;
};

class ExperimentSearch {
 public:
  ExperimentSearch(const Engine& engine, const Window& window, const ReferenceFit& fit, const Responses& responses,
                   std::span<const sim::EffectChange> members, const Changes& fitted, int jobs,
                   const ExperimentRules& rules)
      : engine_(engine),
        window_(window),
        fit_(fit),
        responses_(responses),
        members_(members),
        fitted_(fitted),
        jobs_(jobs),
        rules_(rules),
        evidence_(evidence_of_window()) {}

  std::vector<ExperimentProposal> run() {
    try_plans();
    for (TriedTest& tried : tried_) evaluate(tried, false);
    const auto before = [](const TriedTest& a, const TriedTest& b) {
      if (a.proposal.comfortable != b.proposal.comfortable) return a.proposal.comfortable;
      return a.proposal.separation > b.proposal.separation;
    };
    std::sort(tried_.begin(), tried_.end(), before);
    // Parameters only take away: a test whose bound lies below what another is known to do needs no more simulations.
    std::size_t known = 0;
    double best = 0;
    while (known < tried_.size() && known < static_cast<std::size_t>(rules_.finalists) &&
           (known < 2 || tried_[known].proposal.separation > best)) {
      evaluate(tried_[known], true);
      best = std::max(best, tried_[known].proposal.separation);
      ++known;
    }
    std::sort(tried_.begin(), tried_.begin() + static_cast<std::ptrdiff_t>(known), before);
    std::vector<ExperimentProposal> proposals;
    for (const TriedTest& tried : tried_) proposals.push_back(tried.proposal);
    return proposals;
  }

 private:
  Eigen::Index shared() const { return std::ssize(responses_.parameters) + fit_.structural_scale.size(); }

  StackedEvidence evidence_of_window() {
    std::vector<Task> tasks{{fitted_, &window_.recording}};
    for (const sim::EffectChange& m : members_) tasks.push_back({with_member(fitted_, m), &window_.recording});
    const auto tables = simulate_all(engine_, tasks, jobs_);
    const auto kept = counted_bins(window_.measured.rows());
    const Eigen::MatrixXd base = binned(tables[0], engine_.channels());
    std::vector<Eigen::VectorXd> z;
    for (std::size_t i = 1; i < tables.size(); ++i)
      z.push_back(fit_.noise.whiten(binned(tables[i], engine_.channels()) - base, kept, window_.measured));
    const Eigen::MatrixXd j = nuisance_directions(fit_, responses_, kept, window_.measured, rules_.nuisance);
    for (const Parameter& parameter : responses_.parameters)
      parameter_size_.push_back(fit_.noise.whiten(parameter.response, kept, window_.measured).norm());
    Eigen::MatrixXd all(j.rows(), std::ssize(z) + j.cols());
    all << columns_of(z, j.rows()), j;
    return {all, std::ssize(z), shared()};
  }

  void try_plans() {
    for (TestPlan& plan : test_plans(engine_.channels(), members_, rules_)) {
      if (!engine_.plays_commands() && (plan.vav_command || plan.fcu_command)) continue;
      if (!engine_.plays_setpoint() && (plan.setpoint_degc || plan.turns_with_degc)) continue;
      auto test = test_recording(window_.recording, plan, rules_);
      const auto same = [&test](const TriedTest& other) {
        return std::equal(test->recording.rows.begin(), test->recording.rows.end(), other.test.recording.rows.begin(),
                          other.test.recording.rows.end(), [](const auto& a, const auto& b) {
                            return a.setpoint_degc == b.setpoint_degc && a.vav_on == b.vav_on && a.fcu_on == b.fcu_on;
                          });
      };
      if (!test || test->changed == 0 || std::any_of(tried_.begin(), tried_.end(), same)) continue;
      TriedTest tried;
      tried.plan = std::move(plan);
      tried.test = std::move(*test);
      tried_.push_back(std::move(tried));
    }
    std::vector<Task> tasks;
    for (const TriedTest& tried : tried_) {
      tasks.push_back({fitted_, &tried.test.recording});
      for (const sim::EffectChange& m : members_) tasks.push_back({with_member(fitted_, m), &tried.test.recording});
    }
    auto tables = simulate_all(engine_, tasks, jobs_);
    const auto each = static_cast<std::ptrdiff_t>(members_.size() + 1);
    for (std::size_t i = 0; i < tried_.size(); ++i) {
      TriedTest& tried = tried_[i];
      const auto first = tables.begin() + static_cast<std::ptrdiff_t>(i) * each;
      tried.tables.assign(std::make_move_iterator(first), std::make_move_iterator(first + each));
      const Eigen::Index bins = tried.tables[0].rows() / rows_per_bin;
      tried.missing = missing_in_test(window_.measured, bins, engine_.channels(), tried.plan.fcu_command.has_value());
      tried.kept = bins_from(bins, tried.test.first_row);
      describe(tried);
    }
  }

  void describe(TriedTest& tried) const {
    ExperimentProposal& p = tried.proposal;
    p.name = tried.plan.name;
    p.text = tried.plan.text;
    p.lowest_room_degc = std::numeric_limits<double>::infinity();
    p.highest_room_degc = -p.lowest_room_degc;
    const Eigen::Index zones = engine_.channels().mau_temp();
    for (std::size_t i = 1; i < tried.tables.size(); ++i) {
      const auto temps =
          tried.tables[i].bottomRows(tried.tables[i].rows() - static_cast<Eigen::Index>(tried.test.first_row));
      p.lowest_room_degc = std::min(p.lowest_room_degc, temps.leftCols(zones).minCoeff());
      p.highest_room_degc = std::max(p.highest_room_degc, temps.leftCols(zones).maxCoeff());
    }
    p.comfortable = p.lowest_room_degc >= rules_.coldest_degc && p.highest_room_degc <= rules_.warmest_degc;
  }

  /// Parameters that matter most in the window, and those by which days differ.
  std::vector<std::size_t> uncertain_parameters() const {
    std::vector<std::size_t> order(responses_.parameters.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto size = [&](std::size_t i) {
      const auto& name = responses_.parameters[i].at.effect->name;
      if (name == "gain_occupied" || name == "occupancy_shift") return std::numeric_limits<double>::infinity();
      const auto k = static_cast<Eigen::Index>(i);
      const double sd = rules_.nuisance.structural_sd;
      return std::sqrt(rules_.nuisance.inflation * fit_.covariance(k, k) + sd * sd) * parameter_size_[i];
    };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size(a) > size(b); });
    order.resize(std::min(order.size(), static_cast<std::size_t>(rules_.most_parameters)));
    return order;
  }

  /// Responses in a test: zero where nothing was simulated, so that directions keep their order.
  Responses responses_in(const TriedTest& tried, const std::vector<Eigen::MatrixXd>& members, bool parameters) const {
    const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(members[0].rows(), members[0].cols());
    Responses r;
    r.base = none;
    for (const Parameter& p : responses_.parameters) r.parameters.push_back({p.at, p.prior_sd, none});
    for (const Candidate& c : responses_.candidates) r.candidates.push_back({c.at, c.probe, none});
    for (std::size_t m = 0; m < members_.size(); ++m) {
      const double null_value = members_[m].at.effect->null_value;
      const double way = members_[m].magnitude - null_value;
      for (Candidate& c : r.candidates) {
        if (c.at.id() == members_[m].at.id() && way != 0) c.response = (c.probe - null_value) / way * members[m];
      }
    }
    if (!parameters) return r;
    const auto chosen = uncertain_parameters();
    std::vector<Task> tasks;
    std::vector<double> sign;
    for (const std::size_t i : chosen) {
      auto [changes, way] = with_parameter_moved(fitted_, responses_.parameters[i]);
      tasks.push_back({std::move(changes), &tried.test.recording});
      sign.push_back(way);
    }
    const auto tables = simulate_all(engine_, tasks, jobs_);
    const Eigen::MatrixXd base = binned(tried.tables[0], engine_.channels());
    for (std::size_t k = 0; k < chosen.size(); ++k)
      r.parameters[chosen[k]].response = sign[k] * (binned(tables[k], engine_.channels()) - base);
    return r;
  }

  void evaluate(TriedTest& tried, bool parameters) const {
    const Eigen::MatrixXd base = binned(tried.tables[0], engine_.channels());
    std::vector<Eigen::MatrixXd> members;
    std::vector<Eigen::VectorXd> z;
    const auto whiten = [&](const Eigen::MatrixXd& x) { return fit_.noise.whiten(x, tried.kept, tried.missing); };
    for (std::size_t i = 1; i < tried.tables.size(); ++i) {
      members.push_back(binned(tried.tables[i], engine_.channels()) - base);
      z.push_back(whiten(members.back()));
    }
    const Responses r = responses_in(tried, members, parameters);
    const Eigen::MatrixXd j = nuisance_directions(fit_, r, tried.kept, tried.missing, rules_.nuisance);
    std::vector<Eigen::VectorXd> elsewhere;  // what a parameter may be off in this window and no other
    for (const Eigen::MatrixXd& direction : directions_of(r, fit_.structural_scale)) {
      if (direction.cwiseAbs().maxCoeff() > 0) elsewhere.push_back(rules_.nuisance.structural_sd * whiten(direction));
    }
    const Eigen::Index rows = z[0].size(), width = base.cols();
    Eigen::MatrixXd all(rows, std::ssize(z) + j.cols() + std::ssize(elsewhere));
    all << columns_of(z, rows), j, columns_of(elsewhere, rows);

    ExperimentProposal& p = tried.proposal;
    p.upper_bound = !parameters;
    const Eigen::MatrixXd before = evidence_.window_products();
    const double first_h = static_cast<double>(tried.test.first_row) / rows_an_hour;
    const double all_h = static_cast<double>(tried.test.recording.rows.size()) / rows_an_hour - first_h;
    p.hours = all_h;
    p.separates = false;
    const Eigen::Index per_hour = 2 * width;
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(all.cols(), all.cols());
    const auto first_bin = static_cast<Eigen::Index>(tried.test.first_row / rows_per_bin);
    Eigen::Index at = std::max<Eigen::Index>(0, first_bin - NoiseModel::order) * width;
    while (at < rows) {
      // Hours are searched one by one only where they will be shown.
      const Eigen::Index n = parameters ? std::min(per_hour, rows - at) : rows - at;
      const auto block = all.middleRows(at, n);
      gram += block.transpose() * block;
      at += n;
      if (p.separates && at < rows) continue;
      const double separation = worst_pair(before, evidence_.products_with(gram), p.hardest);
      if (separation >= rules_.margin && !p.separates) {
        p.separates = true;
        const double bin = static_cast<double>(at) / static_cast<double>(width) + NoiseModel::order;
        if (parameters) p.hours = std::max(0.5, bin / 2 - first_h);
      }
      if (at >= rows) p.separation = separation;
    }
    p.power = power_of(p.separation);
  }

  double worst_pair(const Eigen::MatrixXd& before, const Eigen::MatrixXd& after, std::string& hardest) const {
    double worst = std::numeric_limits<double>::infinity();
    for (Eigen::Index a = 0; a < before.rows(); ++a) {
      for (Eigen::Index b = 0; b < before.rows(); ++b) {
        if (a == b) continue;
        const double added = std::max(0.0, distance_of(after, a, b) - distance_of(before, a, b));
        if (added >= worst) continue;
        worst = added;
        const auto id = [&](Eigen::Index i) { return members_[static_cast<std::size_t>(i)].at.id(); };
        hardest = id(std::min(a, b)) + " or " + id(std::max(a, b));
      }
    }
    return worst;
  }

  const Engine& engine_;
  const Window& window_;
  const ReferenceFit& fit_;
  const Responses& responses_;
  std::span<const sim::EffectChange> members_;
  const Changes& fitted_;
  int jobs_;
  const ExperimentRules& rules_;
  std::vector<double> parameter_size_;
  StackedEvidence evidence_;
  std::vector<TriedTest> tried_;
};

}  // namespace

double power_of(double separation) {
  constexpr double z_one_sided_95 = 1.6448536;
  return 0.5 * std::erfc((z_one_sided_95 - std::sqrt(std::max(0.0, separation))) / std::sqrt(2.0));
}

std::vector<ExperimentProposal> propose_experiments(const Engine& engine, const Window& window, const ReferenceFit& fit,
                                                    const Responses& responses,
                                                    std::span<const sim::EffectChange> members,
                                                    const Changes& fitted_parameters, int jobs,
                                                    const ExperimentRules& rules) {
  if (members.size() < 2) return {};
  return ExperimentSearch(engine, window, fit, responses, members, fitted_parameters, jobs, rules).run();
}

}  // namespace airside::tools::gap
