#include "tools/gap/inference/refit.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

namespace {

/// Of the magnitudes, the best one in the linear model, no further than two probes at a time and not below null.
Eigen::VectorXd best_step(const Metric& metric, Eigen::MatrixXd z, const Eigen::VectorXd& r,
                          const std::vector<Chosen>& chosen) {
  const Eigen::Index n = z.cols();
  if (n == 0) return {};
  for (Eigen::Index i = 0; i < n; ++i) {
    if (chosen[static_cast<std::size_t>(i)].held) z.col(i).setZero();
  }
  Eigen::MatrixXd m_z(z.rows(), n);
  for (Eigen::Index i = 0; i < n; ++i) m_z.col(i) = metric.times(z.col(i));
  const Eigen::MatrixXd normal = m_z.transpose() * z + 1e-9 * Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd step = normal.ldlt().solve(m_z.transpose() * r).cwiseMax(-2.0).cwiseMin(2.0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Chosen& c = chosen[static_cast<std::size_t>(i)];
    step(i) = c.held ? 0 : std::max(step(i), -c.steps);
  }
  return step;
}

Eigen::VectorXd steps_between(const std::vector<Chosen>& from, const std::vector<Chosen>& to) {
  Eigen::VectorXd step(std::ssize(from));
  for (std::size_t i = 0; i < from.size(); ++i) step(static_cast<Eigen::Index>(i)) = to[i].steps - from[i].steps;
  return step;
}

}  // namespace

Tangent::Tangent(const std::vector<Candidate>& candidates, std::shared_ptr<const Eigen::MatrixXd> z, Metric metric,
                 Eigen::MatrixXd mixing, Eigen::MatrixXd parameters, std::vector<Parameter> responses)
    : responses_(std::move(responses)),
      parameters_(std::move(parameters)),
      mixing_(std::move(mixing)),
      evidence_(candidates, std::move(z), std::move(metric)),
      others_(this->metric().without_first(count())) {}

Eigen::VectorXd Tangent::mean(const Eigen::VectorXd& r) const {
  const Eigen::VectorXd all = metric().along(metric().times(r));
  return mixing_.triangularView<Eigen::Lower>() * all.head(count());
}

/// J C's first columns times u are J_p C_pp u + J_o C_op u, and C_pp u is what moved.
Eigen::VectorXd Tangent::without_moved(const Eigen::VectorXd& r, const Eigen::VectorXd& moved) const {
  const Eigen::VectorXd u = mixing_.triangularView<Eigen::Lower>().solve(moved);
  return r - (metric().first(u) - parameters_ * moved);
}

double Tangent::distance(const Eigen::VectorXd& r, const Eigen::VectorXd& moved) const {
  const Eigen::VectorXd u = mixing_.triangularView<Eigen::Lower>().solve(moved);
  const Eigen::VectorXd s = without_moved(r, moved);
  return u.squaredNorm() + others_.dot(s, s);
}

Refitter::Refitter(const Engine& engine, const Window& window, const Responses& responses, const ReferenceFit& fit,
                   const Nuisance& sizes, std::vector<bool> kept, int jobs, Start start)
    : engine_(engine),
      window_(window),
      responses_(responses),
      fit_(fit),
      kept_(std::move(kept)),
      jobs_(jobs),
      sizes_(sizes),
      all_(counted_bins(window.measured.rows())),
      structural_(fit.structural(responses)),
      z_(whitened_candidates()),
      mixing_(mixing_of(fit.covariance, sizes)),
      structure_(structure_of(kept_, z_)) {
  tangent_ = tangent_with(start == Start::twin || engine.spares_runs() ? responses.parameters : parameters_at_fit());
}

void Refitter::simulate_tangent() {
  if (!engine_.spares_runs()) tangent_ = tangent_with(parameters_at_fit());
}

void Refitter::set_structure(const Eigen::MatrixXd& mean, std::vector<Eigen::MatrixXd> directions) {
  if (mean.size() > 0) structural_ += mean;
  ensemble_ = std::move(directions);
  structure_ = structure_of(kept_, z_);
  tangent_ = tangent_with(tangent_->responses());
}

std::vector<Parameter> Refitter::parameters_at_fit() const {
  return parameters_at({}, Eigen::VectorXd::Zero(std::ssize(responses_.parameters)));
}

std::shared_ptr<const Eigen::MatrixXd> Refitter::whitened_candidates() const {
  const auto& candidates = responses_.candidates;
  Eigen::MatrixXd z((window_.measured.rows() - NoiseModel::order) * window_.measured.cols(), std::ssize(candidates));
  for (Eigen::Index k = 0; k < z.cols(); ++k) z.col(k) = whiten(candidates[static_cast<std::size_t>(k)].response);
  return std::make_shared<const Eigen::MatrixXd>(std::move(z));
}

/// Of C, lower triangular: a parameter's column has structure too, a structural one has none of the parameters.
Refitter::Structure Refitter::structure_of(const std::vector<bool>& bins,
                                           std::shared_ptr<const Eigen::MatrixXd> z) const {
  const Eigen::Index parameters = std::ssize(responses_.parameters), others = fit_.covariance.cols() - parameters;
  const NuisanceResponses all = nuisance_responses(fit_, {}, responses_.candidates, bins, window_.measured, ensemble_);
  const Eigen::Index rooms = all.structure.cols();
  Structure structure{Eigen::MatrixXd::Zero(z_->rows(), parameters), nullptr};
  Eigen::MatrixXd j(z_->rows(), others + rooms);
  if (others > 0) {
    structure.with_parameters = all.directions * mixing_.bottomLeftCorner(others, parameters);
    j.leftCols(others) = all.directions * mixing_.bottomRightCorner(others, others).triangularView<Eigen::Lower>();
  }
  j.rightCols(rooms) = all.structure;
  if (j.cols() > 0) structure.shared = std::make_shared<const SharedColumns>(std::move(j), std::move(z));
  return structure;
}

Refitter::Own Refitter::own_of(const std::vector<Parameter>& parameters, const std::vector<bool>& bins,
                               const Structure& structure) const {
  NuisanceResponses own = nuisance_responses(fit_, parameters, {}, bins, window_.measured);
  const Eigen::Index count = own.directions.cols(), gains = own.day_gain.cols(), shifts = own.day_shift.cols();
  Eigen::MatrixXd j(z_->rows(), count + gains + shifts);
  j.leftCols(count) = own.directions * mixing_.topLeftCorner(count, count).triangularView<Eigen::Lower>();
  j.leftCols(count) += structure.with_parameters;
  j.middleCols(count, gains) = sizes_.day_gain_sd * own.day_gain;
  j.rightCols(shifts) = sizes_.day_shift_h * own.day_shift;
  return {std::move(own.directions), Metric(std::move(j), structure.shared)};
}

std::shared_ptr<const Tangent> Refitter::tangent_with(std::vector<Parameter> parameters) const {
  Own own = own_of(parameters, kept_, structure_);
  const auto count = std::ssize(parameters);
  return std::make_shared<const Tangent>(responses_.candidates, z_, std::move(own.metric),
                                         mixing_.topLeftCorner(count, count), std::move(own.parameters),
                                         std::move(parameters));
}

std::vector<Parameter> Refitter::parameters_at(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved) const {
  const Eigen::MatrixXd shown = binned(engine_.simulate(changes(chosen, moved), window_.recording), engine_.channels());
  return parameters_about(engine_, window_.recording, responses_.parameters, fit_.estimate.head(moved.size()) + moved,
                          changes_of(chosen), shown, jobs_);
}

Eigen::VectorXd Refitter::whiten(const Eigen::MatrixXd& x) const {
  return fit_.noise.whiten(x, kept_, window_.measured);
}

double Refitter::magnitude(const Chosen& chosen) const {
  const Candidate& candidate = responses_.candidates[chosen.candidate];
  const sim::Effect& effect = *candidate.at.effect;
  const double m = effect.null_value + chosen.steps * (candidate.probe - effect.null_value);
  return std::clamp(m, effect.low, effect.high);
}

Changes Refitter::changes(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved) const {
  Changes changes = fit_.changes(moved);
  const Changes effects = changes_of(chosen);
  changes.insert(changes.end(), effects.begin(), effects.end());
  return changes;
}

Changes Refitter::changes_of(const std::vector<Chosen>& chosen) const {
  Changes changes;
  for (const Chosen& c : chosen) changes.push_back({responses_.candidates[c.candidate].at, magnitude(c)});
  return changes;
}

Eigen::MatrixXd Refitter::residual_of(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved) const {
  return window_.measured - binned(engine_.simulate(changes(chosen, moved), window_.recording), engine_.channels()) -
         structural_;
}

Eigen::MatrixXd Refitter::unmoved_residual(const std::vector<Chosen>& chosen) const {
  return residual_of(chosen, Eigen::VectorXd::Zero(std::ssize(responses_.parameters)));
}

Predicted Refitter::predicted(const Refit& with, const Refit& without) const {
  struct Unfitted {
    Eigen::MatrixXd parameters;  // of all bins
    Eigen::VectorXd left;
    Eigen::VectorXd all, kept;
    Metric metric;
    const Metric& metric_kept;
    double dot(const Eigen::VectorXd& a, const Eigen::VectorXd& k) const {
      return metric.dot(a, a) - metric_kept.dot(k, k);
    }
    double cost() const { return dot(all, kept) + metric.log_det() - metric_kept.log_det(); }
  };
  const Structure structure = structure_of(all_, nullptr);
  const auto unfitted = [&](const Refit& at) {
    Own own = own_of(at.tangent->responses(), all_, structure);
    Eigen::VectorXd left = fit_.noise.whiten(at.residual, all_, window_.measured),
                    all = left + own.parameters * at.moved;
    return Unfitted{std::move(own.parameters), std::move(left),     std::move(all), effective(at),
                    std::move(own.metric),     at.tangent->metric()};
  };
  const Unfitted one = unfitted(with), other = unfitted(without);
  // Far from the reference's parameters the two tangents differ by more than the effect does: one for both.
  const Eigen::VectorXd moved = without.moved - with.moved;
  const Eigen::VectorXd all = other.left - one.left + other.parameters * moved,
                        kept = whiten(without.residual) - whiten(with.residual) + without.tangent->parameters() * moved;
  return {other.cost() - one.cost(), other.dot(all, kept)};
}

Eigen::VectorXd Refitter::effective(const Refit& at) const {
  return whiten(at.residual) + at.tangent->parameters() * at.moved;
}

void Refitter::judge(Refit& at) const {
  at.distance = at.tangent->distance(whiten(at.residual), at.moved);
  at.cost = at.distance + at.tangent->metric().log_det() - tangent_->metric().log_det();
}

Refit Refitter::at(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved,
                   const std::shared_ptr<const Tangent>& tangent) const {
  Refit at{chosen, moved, residual_of(chosen, moved), 0, 0, tangent};
  judge(at);
  return at;
}

Eigen::MatrixXd Refitter::responses_of(const Refit& at) const {
  const Eigen::Index n = std::ssize(at.chosen);
  Eigen::MatrixXd z(z_->rows(), n);
  for (Eigen::Index i = 0; i < n; ++i)
    z.col(i) = z_->col(static_cast<Eigen::Index>(at.chosen[static_cast<std::size_t>(i)].candidate));
  return z;
}

Refit Refitter::magnitudes_alone(const Refit& from, const Eigen::MatrixXd& z) const {
  const Tangent& tangent = *from.tangent;
  const Eigen::VectorXd left = tangent.without_moved(whiten(from.residual), from.moved);
  const Eigen::VectorXd step = best_step(tangent.others(), z, left, from.chosen);
  std::vector<Chosen> chosen = from.chosen;
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i].steps += step(static_cast<Eigen::Index>(i));
  return at(chosen, from.moved, from.tangent);
}

Refit Refitter::refit(const Refit& from, const std::shared_ptr<const Tangent>& tangent) const {
  Refit now = from;
  now.tangent = tangent;
  judge(now);
  Eigen::MatrixXd z = responses_of(now);
  for (int iteration = 0; iteration < 4; ++iteration) {
    const Eigen::VectorXd r = effective(now);
    const Eigen::VectorXd step = best_step(tangent->metric(), z, r, now.chosen);
    const Eigen::VectorXd move = tangent->mean(r - z * step) - now.moved;
    const auto gone = [&](double share) {
      std::vector<Chosen> chosen = now.chosen;
      for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i].steps += share * step(static_cast<Eigen::Index>(i));
      return at(chosen, now.moved + share * move, tangent);
    };
    const double foreseen =
        now.distance - tangent->distance(r - z * step - tangent->parameters() * (now.moved + move), now.moved + move);
    if (foreseen < 1) break;
    Refit next = gone(1);
    if (next.cost > now.cost - foreseen / 4) {
      const double share = std::clamp(foreseen / (next.cost - now.cost + 2 * foreseen), 0.1, 0.75);
      const Refit nearer = gone(share);
      if (nearer.cost < next.cost) next = nearer;
    }
    if (next.cost > now.cost - foreseen / 4 && !now.chosen.empty()) {
      Refit alone = magnitudes_alone(now, z);
      if (alone.cost < next.cost) next = std::move(alone);
    }
    const double gained = now.cost - next.cost;
    if (gained <= 0) break;
    const Eigen::VectorXd done = steps_between(now.chosen, next.chosen);
    const Eigen::VectorXd by_steps = z * done;
    const double of_steps = by_steps.squaredNorm(),
                 of_move = (tangent->parameters() * (next.moved - now.moved)).squaredNorm();
    if (of_steps > 0) {
      const Eigen::VectorXd bent = r - effective(next) - by_steps;
      z += bent * done.transpose() * (of_steps / (of_steps + of_move) / done.squaredNorm());
    }
    now = std::move(next);
    if (gained < 1) break;
  }
  return now;
}

/// Candidates stand in pairs, one for each direction.
bool Refitter::bends(std::size_t candidate) const {
  const auto one = z_->col(static_cast<Eigen::Index>(candidate)),
             other = z_->col(static_cast<Eigen::Index>(candidate ^ 1U));
  return std::abs(one.dot(other)) < 0.8 * one.norm() * other.norm();
}

Refit Refitter::add(const Refit& to, const Score& added, const std::shared_ptr<const Tangent>& tangent) const {
  Refit from = to;
  from.chosen.push_back({added.candidate, 0});
  Refit best = refit(from, tangent);
  from.tangent = tangent;
  judge(from);
  if (from.cost - best.cost < 0.5 * added.log_likelihood_ratio && bends(added.candidate)) {
    std::vector<Chosen> chosen = from.chosen;
    chosen.back().steps = 1;
    const Eigen::VectorXd moved = tangent->mean(effective(from) - z_->col(static_cast<Eigen::Index>(added.candidate)));
    Refit far = refit(at(chosen, moved, tangent), tangent);
    if (far.cost < best.cost) best = std::move(far);
  }
  return best;
}

const Refitter::FarSizes& Refitter::far_sizes() const {
  std::call_once(far_once_, [this] {
    constexpr int shares = 4;
    for (std::size_t i = 0; i < responses_.candidates.size(); ++i) {
      if (!bends(i)) continue;
      const sim::Effect& effect = *responses_.candidates[i].at.effect;
      const double probe = responses_.candidates[i].probe - effect.null_value;
      const double bound = (probe > 0 ? effect.high : effect.low) - effect.null_value;
      for (int n = 1; n <= shares; ++n) far_.sizes.push_back({i, bound / probe * n / shares});
    }
    const Eigen::MatrixXd none = unmoved_residual({});
    far_.z.resize(z_->rows(), std::ssize(far_.sizes));
    in_parallel(far_.sizes.size(), jobs_, [&](std::size_t n) {
      far_.z.col(static_cast<Eigen::Index>(n)) = whiten(none - unmoved_residual({far_.sizes[n]}));
    });
  });
  return far_;
}

std::vector<Refit> Refitter::far(const Refit& now, std::size_t most,
                                 const std::function<bool(std::size_t)>& open) const {
  if (engine_.spares_runs()) return {};
  const FarSizes& known = far_sizes();
  if (known.sizes.empty()) return {};
  const Tangent& tangent = *now.tangent;
  const Eigen::VectorXd left = tangent.others().times(tangent.without_moved(whiten(now.residual), now.moved));
  const Eigen::VectorXd gained = 2 * known.z.transpose() * left - tangent.others().squares(known.z);
  std::map<std::size_t, std::pair<double, std::size_t>> best_size;  // of a candidate: gained, index
  for (std::size_t n = 0; n < known.sizes.size(); ++n) {
    const double gain = gained(static_cast<Eigen::Index>(n));
    if (gain <= 0 || !open(known.sizes[n].candidate)) continue;
    const auto at = best_size.try_emplace(known.sizes[n].candidate, gain, n).first;
    if (gain > at->second.first) at->second = {gain, n};
  }
  std::vector<std::pair<double, std::size_t>> likely;
  for (const auto& [candidate, size] : best_size) likely.push_back(size);
  std::sort(likely.rbegin(), likely.rend());
  likely.resize(std::min(likely.size(), most));
  std::vector<std::optional<Refit>> starts(likely.size());
  in_parallel(starts.size(), jobs_, [&](std::size_t i) {
    std::vector<Chosen> chosen = now.chosen;
    chosen.push_back(known.sizes[likely[i].second]);
    starts[i] = at(chosen, now.moved, now.tangent);
  });
  std::vector<Refit> best;
  for (auto& start : starts)
    if (start->cost < now.cost) best.push_back(std::move(*start));
  std::sort(best.begin(), best.end(), [](const Refit& a, const Refit& b) { return a.cost < b.cost; });
  return best;
}

Refit Refitter::about_itself(const Refit& at) const {
  if (engine_.spares_runs()) return at;
  return refit(at, tangent_with(parameters_at(at.chosen, at.moved)));
}

}  // namespace airside::tools::gap
