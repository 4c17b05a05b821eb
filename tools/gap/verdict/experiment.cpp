#include "tools/gap/verdict/experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace airside::tools::gap {

namespace {

constexpr int rows_an_hour = 3600 / row_s;

bool acts_at(const TestPlan& plan, double hour) {
  return plan.to_h > plan.from_h ? hour >= plan.from_h && hour < plan.to_h : hour >= plan.from_h || hour < plan.to_h;
}

void command(std::vector<double>& list, int place, double value) {
  if (place < 0)
    std::fill(list.begin(), list.end(), value);
  else
    list.at(static_cast<std::size_t>(place)) = value;
}

/// Changes the row; false where it already was so.
bool apply_plan(const TestPlan& plan, double hours_since_first, sim::RecordedRow& row) {
  const sim::RecordedRow before = row;
  if (plan.setpoint_degc) row.setpoint_degc = *plan.setpoint_degc;
  if (plan.turns_with_degc && static_cast<int>(hours_since_first / 3) % 2 == 1)
    row.setpoint_degc = *plan.turns_with_degc;
  if (plan.boxes) command(row.vav_on, plan.box, *plan.boxes);
  if (plan.fan_coils) command(row.fcu_on, plan.fan_coil, *plan.fan_coils);
  return row.setpoint_degc != before.setpoint_degc || row.vav_on != before.vav_on || row.fcu_on != before.fcu_on;
}

/// Boxes and fan coils at which members are.
void places_of_members(const sim::Channels& channels, std::span<const sim::EffectChange> members,
                       std::vector<int>& boxes, std::vector<int>& fan_coils) {
  const auto add = [](std::vector<int>& list, int place) {
    if (std::find(list.begin(), list.end(), place) == list.end()) list.push_back(place);
  };
  for (const sim::EffectChange& member : members) {
    const int place = member.at.place;
    switch (member.at.effect->place) {
      case sim::PlaceKind::vav: add(boxes, place); break;
      case sim::PlaceKind::fcu: add(fan_coils, place); break;
      case sim::PlaceKind::zone:
        if (place < channels.rooms)
          add(boxes, place);
        else
          add(fan_coils, place - channels.rooms);
        break;
      case sim::PlaceKind::vav_pair: {
        const auto [a, b] = sim::vav_pair(place, channels.rooms);
        add(boxes, a);
        add(boxes, b);
        break;
      }
      case sim::PlaceKind::floor:
      case sim::PlaceKind::facade: break;
    }
  }
}

Changes with_member(Changes changes, const sim::EffectChange& member) {
  changes.push_back(member);
  return changes;
}

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

Eigen::MatrixXd columns_of(const std::vector<Eigen::VectorXd>& vectors, Eigen::Index rows) {
  Eigen::MatrixXd out(rows, std::ssize(vectors));
  for (Eigen::Index i = 0; i < out.cols(); ++i) out.col(i) = vectors[static_cast<std::size_t>(i)];
  return out;
}

/// z' M z of the first `count` columns when the others are directions of unit prior.
Eigen::MatrixXd marginal_products(const Eigen::MatrixXd& gram, Eigen::Index count) {
  const Eigen::Index others = gram.rows() - count;
  if (others == 0) return gram;
  const Eigen::MatrixXd inner = gram.bottomRightCorner(others, others) + Eigen::MatrixXd::Identity(others, others);
  const Eigen::MatrixXd across = gram.bottomLeftCorner(others, count);
  return gram.topLeftCorner(count, count) - across.transpose() * inner.ldlt().solve(across);
}

/// d_ab^2: magnitudes have a sign, so what points the other way explains nothing.
double distance_of(const Eigen::MatrixXd& products, Eigen::Index a, Eigen::Index b) {
  const double aa = products(a, a), ab = products(a, b), bb = products(b, b);
  return std::max(0.0, ab > 0 && bb > 1e-9 ? aa - ab * ab / bb : aa);
}

/// The window's and a test's whitened columns, stacked without ever standing in one matrix: only their products do.
class StackedEvidence {
 public:
  /// Columns: `members`, `shared` directions, then directions of the window alone.
  StackedEvidence(const Eigen::MatrixXd& window, Eigen::Index members, Eigen::Index shared)
      : members_(members), common_(members + shared), window_gram_(window.transpose() * window) {}

  Eigen::MatrixXd window_products() const { return marginal_products(window_gram_, members_); }
  /// `test`: columns as the window's, then directions of the test alone.
  Eigen::MatrixXd products_with(const Eigen::MatrixXd& test_gram) const {
    const Eigen::Index own = window_gram_.rows() - common_, theirs = test_gram.rows() - common_;
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(common_ + own + theirs, common_ + own + theirs);
    gram.topLeftCorner(common_ + own, common_ + own) = window_gram_;
    gram.topLeftCorner(common_, common_) += test_gram.topLeftCorner(common_, common_);
    gram.bottomLeftCorner(theirs, common_) = test_gram.bottomLeftCorner(theirs, common_);
    gram.topRightCorner(common_, theirs) = test_gram.topRightCorner(common_, theirs);
    gram.bottomRightCorner(theirs, theirs) = test_gram.bottomRightCorner(theirs, theirs);
    return marginal_products(gram, members_);
  }

 private:
  Eigen::Index members_, common_;
  Eigen::MatrixXd window_gram_;
};

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

/// Bins that a test's first command may have moved.
std::vector<bool> bins_from(Eigen::Index bins, std::size_t first_row) {
  std::vector<bool> kept(static_cast<std::size_t>(bins), true);
  const auto first = first_row / rows_per_bin;
  const auto before = first > NoiseModel::order ? first - NoiseModel::order : 0;  // whiten() looks back
  std::fill_n(kept.begin(), std::min(before, kept.size()), false);
  return kept;
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
    const Eigen::MatrixXd base = binned(tables[0]);
    std::vector<Eigen::VectorXd> z;
    for (std::size_t i = 1; i < tables.size(); ++i)
      z.push_back(fit_.noise.whiten(binned(tables[i]) - base, kept, window_.measured));
    const Eigen::MatrixXd j = nuisance_directions(fit_, responses_, kept, window_.measured, rules_.nuisance);
    for (const Parameter& parameter : responses_.parameters)
      parameter_size_.push_back(fit_.noise.whiten(parameter.response, kept, window_.measured).norm());
    Eigen::MatrixXd all(j.rows(), std::ssize(z) + j.cols());
    all << columns_of(z, j.rows()), j;
    return {all, std::ssize(z), shared()};
  }

  void try_plans() {
    for (TestPlan& plan : test_plans(engine_.channels(), members_, rules_)) {
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
      tried.missing = missing_in_test(window_.measured, bins, engine_.channels(), tried.plan.fan_coils.has_value());
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
    const Eigen::MatrixXd base = binned(tried.tables[0]);
    for (std::size_t k = 0; k < chosen.size(); ++k)
      r.parameters[chosen[k]].response = sign[k] * (binned(tables[k]) - base);
    return r;
  }

  void evaluate(TriedTest& tried, bool parameters) const {
    const Eigen::MatrixXd base = binned(tried.tables[0]);
    std::vector<Eigen::MatrixXd> members;
    std::vector<Eigen::VectorXd> z;
    const auto whiten = [&](const Eigen::MatrixXd& x) { return fit_.noise.whiten(x, tried.kept, tried.missing); };
    for (std::size_t i = 1; i < tried.tables.size(); ++i) {
      members.push_back(binned(tried.tables[i]) - base);
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
      // The hours are asked for one by one only where they will be told.
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

std::vector<double> gains_of(const Eigen::MatrixXd& products) {
  const Eigen::Index r = products.rows() - 1;
  std::vector<double> gains;
  for (Eigen::Index a = 0; a < r; ++a) {
    const double ar = products(a, r), aa = products(a, a);
    gains.push_back(ar > 0 && aa > 1e-9 ? ar * ar / aa : 0);
  }
  return gains;
}

}  // namespace

double power_of(double separation) {
  constexpr double z_one_sided_95 = 1.6448536;
  return 0.5 * std::erfc((z_one_sided_95 - std::sqrt(std::max(0.0, separation))) / std::sqrt(2.0));
}

std::vector<TestPlan> test_plans(const sim::Channels& channels, std::span<const sim::EffectChange> members,
                                 const ExperimentRules& rules) {
  const double cold = rules.lowest_setpoint_degc, warm = rules.highest_setpoint_degc;
  const auto degc = [](double t) { return fmt::format("{:.0f} degC", t); };
  std::vector<TestPlan> plans;
  const auto add = [&plans](const char* name, std::string text, double from_h, double to_h) -> TestPlan& {
    TestPlan plan;
    plan.name = name;
    plan.text = std::move(text);
    plan.from_h = from_h;
    plan.to_h = to_h;
    return plans.emplace_back(std::move(plan));
  };
  TestPlan& purge = add("night_purge", "open all boxes from 20 to 6 h and supply air at " + degc(cold), 20, 6);
  purge.setpoint_degc = cold;
  purge.boxes = 1;
  add("night_warm", "supply air at " + degc(warm) + " from 20 to 6 h", 20, 6).setpoint_degc = warm;
  add("day_cold", "supply air at " + degc(cold) + " from 9 to 17 h", 9, 17).setpoint_degc = cold;
  add("day_warm", "supply air at " + degc(warm) + " from 9 to 17 h", 9, 17).setpoint_degc = warm;
  TestPlan& steps =
      add("steps", "supply air at " + degc(cold) + " and " + degc(warm) + " by turns, 3 h each, day and night", 0, 24);
  steps.setpoint_degc = cold;
  steps.turns_with_degc = warm;
  add("fan_off_night", "close all boxes from 20 to 6 h", 20, 6).boxes = 0;
  add("fan_off_noon", "close all boxes from 11 to 13 h", 11, 13).boxes = 0;
  if (channels.fcus > 0) {
    add("fcu_off", "switch all fan coils off, day and night", 0, 24).fan_coils = 0;
    add("fcu_on_night", "run all fan coils from 20 to 6 h", 20, 6).fan_coils = 1;
  }
  TestPlan& weekend =
      add("weekend_closed", "close all boxes and switch all fan coils off from Saturday to Sunday", 0, 24);
  weekend.boxes = 0;
  if (channels.fcus > 0) weekend.fan_coils = 0;
  weekend.weekend = true;

  std::vector<int> boxes, fan_coils;
  places_of_members(channels, members, boxes, fan_coils);
  for (const int box : boxes) {
    TestPlan& shut = add("box_closed_night", fmt::format("close box {} from 20 to 6 h", box + 1), 20, 6);
    shut.name += fmt::format("@{}", box + 1);
    shut.boxes = 0;
    shut.box = box;
  }
  for (const int fan_coil : fan_coils) {
    TestPlan& off = add("fcu_off", fmt::format("switch fan coil {} off, day and night", fan_coil + 1), 0, 24);
    off.name += fmt::format("@{}", fan_coil + 1);
    off.fan_coils = 0;
    off.fan_coil = fan_coil;
    TestPlan& on = add("fcu_on_night", fmt::format("run fan coil {} from 20 to 6 h", fan_coil + 1), 20, 6);
    on.name += fmt::format("@{}", fan_coil + 1);
    on.fan_coils = 1;
    on.fan_coil = fan_coil;
  }
  return plans;
}

std::optional<TestRecording> test_recording(const sim::Recording& recording, const TestPlan& plan,
                                            const ExperimentRules& rules) {
  const int whole = static_cast<int>(recording.rows.size()) / rows_per_day;
  const int days = plan.weekend ? 2 : rules.days;
  int last = whole;  // the day after the test's last
  if (plan.weekend) {
    const auto sunday_before = [&](int day) {
      return recording.time(static_cast<std::size_t>(day - 1) * rows_per_day).weekday() == 6;
    };
    while (last > 0 && !sunday_before(last)) --last;
  }
  const int first = last - days;
  const int history = std::min(rules.history_days, first);
  if (history < 1) return std::nullopt;
  TestRecording test;
  test.recording.station = recording.station;
  const auto begin = static_cast<std::size_t>(first - history) * rows_per_day;
  test.recording.from = recording.time(begin);
  test.recording.rows.assign(recording.rows.begin() + static_cast<std::ptrdiff_t>(begin),
                             recording.rows.begin() + static_cast<std::ptrdiff_t>(last) * rows_per_day);
  const auto earliest = static_cast<std::size_t>(history) * rows_per_day +
                        static_cast<std::size_t>(std::lround(plan.from_h * rows_an_hour));
  test.first_row = test.recording.rows.size();
  for (std::size_t row = earliest; row < test.recording.rows.size(); ++row) {
    if (!acts_at(plan, test.recording.time(row).second_of_day() / 3600.0)) continue;
    const double since_h = static_cast<double>(row - earliest) / rows_an_hour;
    if (!apply_plan(plan, since_h, test.recording.rows[row])) continue;
    test.first_row = std::min(test.first_row, row);
    ++test.changed;
  }
  return test;
}

std::vector<ExperimentProposal> propose_experiments(const Engine& engine, const Window& window, const ReferenceFit& fit,
                                                    const Responses& responses,
                                                    std::span<const sim::EffectChange> members,
                                                    const Changes& fitted_parameters, int jobs,
                                                    const ExperimentRules& rules) {
  if (members.size() < 2) return {};
  return ExperimentSearch(engine, window, fit, responses, members, fitted_parameters, jobs, rules).run();
}

ExperimentOutcome judge_experiment(const Engine& engine, const Window& window, const Window& done,
                                   std::size_t first_row, const ReferenceFit& fit, const Responses& responses,
                                   const Responses& at_done, std::span<const sim::EffectChange> members,
                                   const Changes& fitted_parameters, const Nuisance& nuisance) {
  const Eigen::Index shared = std::ssize(responses.parameters) + fit.structural_scale.size();
  const auto count = static_cast<Eigen::Index>(members.size()) + 1;
  const auto stacked = [&](const Window& w, const Responses& r, const std::vector<bool>& kept) {
    const Eigen::MatrixXd base = binned(engine.simulate(fitted_parameters, w.recording));
    const auto whiten = [&](const Eigen::MatrixXd& x) { return fit.noise.whiten(x, kept, w.measured); };
    std::vector<Eigen::VectorXd> columns;
    for (const sim::EffectChange& m : members) {
      columns.push_back(whiten(binned(engine.simulate(with_member(fitted_parameters, m), w.recording)) - base));
    }
    columns.push_back(whiten(w.measured - base - fit.structural(r)));
    const Eigen::MatrixXd j = nuisance_directions(fit, r, kept, w.measured, nuisance);
    Eigen::MatrixXd all(j.rows(), count + j.cols());
    all << columns_of(columns, j.rows()), j;
    return all;
  };
  const StackedEvidence evidence(stacked(window, responses, counted_bins(window.measured.rows())), count, shared);
  const auto kept = bins_from(done.measured.rows(), first_row);
  Eigen::MatrixXd test = stacked(done, at_done, kept);
  const auto directions = directions_of(at_done, fit.structural_scale);
  const Eigen::Index before = test.cols();
  test.conservativeResize(Eigen::NoChange, before + std::ssize(directions));
  for (std::size_t i = 0; i < directions.size(); ++i) {
    test.col(before + static_cast<Eigen::Index>(i)) =
        nuisance.structural_sd * fit.noise.whiten(directions[i], kept, done.measured);
  }
  return {gains_of(evidence.window_products()), gains_of(evidence.products_with(test.transpose() * test))};
}

std::string sentence_of(std::span<const ExperimentProposal> proposals) {
  if (proposals.empty()) return "no test was tried: the log is too short";
  const ExperimentProposal& best = proposals.front();
  const std::string temps =
      fmt::format("zones are expected between {:.1f} and {:.1f} degC", best.lowest_room_degc, best.highest_room_degc);
  if (!best.separates) {
    return fmt::format(
        "no test that was tried tells them apart: the best, \"{}\" for {:.0f} h, would with a probability of {:.0f} % "
        "({}); {}",
        best.text, best.hours, 100 * best.power, best.hardest, temps);
  }
  return fmt::format(
      "to tell them apart: {}; after {:.0f} h the log will say which it is (with {:.0f} % probability "
      "after the whole test, at 5 % error); {}{}",
      best.text, best.hours, 100 * best.power, temps,
      best.comfortable ? "" : ", beyond what people accept: do it when nobody is there");
}

nlohmann::json json_of(const ExperimentProposal& p) {
  return {{"name", p.name},
          {"text", p.text},
          {"hours", p.hours},
          {"power", p.power},
          {"separation", p.separation},
          {"separates", p.separates},
          {"lowest_room_degc", p.lowest_room_degc},
          {"highest_room_degc", p.highest_room_degc},
          {"comfortable", p.comfortable},
          {"upper_bound", p.upper_bound},
          {"hardest", p.hardest}};
}

}  // namespace airside::tools::gap
