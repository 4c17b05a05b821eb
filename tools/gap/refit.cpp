#include "tools/gap/refit.hpp"

#include <algorithm>
#include <cmath>

namespace airside::tools::gap {

Tangent::Tangent(const std::vector<Candidate>& candidates, NuisanceResponses nuisance, Eigen::MatrixXd mixing,
                 std::shared_ptr<const Eigen::MatrixXd> z, Eigen::Index parameters)
    : parameters_(parameters),
      nuisance_(std::move(nuisance)),
      mixing_(std::move(mixing)),
      evidence_(candidates, std::move(z), Metric(nuisance_.joined() * mixing_.triangularView<Eigen::Lower>())),
      others_((nuisance_.joined() * mixing_.triangularView<Eigen::Lower>()).rightCols(mixing_.cols() - parameters)) {}

Eigen::VectorXd Tangent::mean(const Eigen::VectorXd& r) const {
  const Eigen::VectorXd m_r = metric().times(r);
  Eigen::VectorXd along(mixing_.rows());
  along << nuisance_.directions.transpose() * m_r, nuisance_.day_gain.transpose() * m_r,
      nuisance_.day_shift.transpose() * m_r;
  const auto root = mixing_.triangularView<Eigen::Lower>();
  const Eigen::VectorXd all = root * (root.transpose() * along);
  return all.head(parameters_);
}

double Tangent::distance(const Eigen::VectorXd& r, const Eigen::VectorXd& moved) const {
  const Eigen::Index structure = nuisance_.directions.cols() - parameters_;
  const Eigen::VectorXd u = mixing_.topLeftCorner(parameters_, parameters_).triangularView<Eigen::Lower>().solve(moved);
  const Eigen::VectorXd s =
      r - nuisance_.directions.rightCols(structure) * (mixing_.block(parameters_, 0, structure, parameters_) * u);
  return u.squaredNorm() + others_.dot(s, s);
}

Refitter::Refitter(const Engine& engine, const Window& window, const Responses& responses, const ReferenceFit& fit,
                   const Nuisance& sizes, std::vector<bool> kept, int jobs)
    : engine_(engine),
      window_(window),
      responses_(responses),
      fit_(fit),
      kept_(std::move(kept)),
      jobs_(jobs),
      sizes_(sizes),
      structural_(fit.structural(responses)) {
  const auto& candidates = responses.candidates;
  Eigen::MatrixXd z((window.measured.rows() - NoiseModel::order) * window.measured.cols(), std::ssize(candidates));
  for (Eigen::Index k = 0; k < z.cols(); ++k) z.col(k) = whiten(candidates[static_cast<std::size_t>(k)].response);
  z_ = std::make_shared<const Eigen::MatrixXd>(std::move(z));
  tangent_ = engine.spares_runs() ? tangent_with(responses.parameters)
                                  : tangent_at({}, Eigen::VectorXd::Zero(std::ssize(responses.parameters)));
}

std::shared_ptr<const Tangent> Refitter::tangent_with(const std::vector<Parameter>& parameters) const {
  NuisanceResponses nuisance = nuisance_responses(fit_, parameters, responses_.candidates, kept_, window_.measured);
  Eigen::MatrixXd mixing = nuisance.mixing(fit_.covariance, sizes_);
  return std::make_shared<const Tangent>(responses_.candidates, std::move(nuisance), std::move(mixing), z_,
                                         std::ssize(parameters));
}

std::shared_ptr<const Tangent> Refitter::tangent_at(const std::vector<Chosen>& chosen,
                                                    const Eigen::VectorXd& moved) const {
  const Eigen::MatrixXd shown = binned(engine_.simulate(changes(chosen, moved), window_.recording));
  return tangent_with(parameters_about(engine_, window_.recording, responses_.parameters,
                                       fit_.estimate.head(moved.size()) + moved, changes_of(chosen), shown, jobs_));
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
  return window_.measured - binned(engine_.simulate(changes(chosen, moved), window_.recording)) - structural_;
}

Eigen::MatrixXd Refitter::unmoved_residual(const std::vector<Chosen>& chosen) const {
  return residual_of(chosen, Eigen::VectorXd::Zero(std::ssize(responses_.parameters)));
}

Eigen::VectorXd Refitter::effective(const Refit& at) const {
  return whiten(at.residual) + at.tangent->parameters() * at.moved;
}

void Refitter::judge(Refit& at) const {
  at.distance = at.tangent->distance(whiten(at.residual), at.moved);
  at.cost = at.distance + at.tangent->metric().log_det() - tangent_->metric().log_det();
}

Refit Refitter::refit(const std::vector<Chosen>& chosen, const std::shared_ptr<const Tangent>& tangent,
                      const Eigen::VectorXd& moved) const {
  const Metric& metric = tangent->metric();
  Refit now{chosen, moved, residual_of(chosen, moved), 0, 0, tangent};
  judge(now);
  Refit best = now;
  const Eigen::Index n = std::ssize(chosen);
  Eigen::VectorXd r = effective(now);
  Eigen::MatrixXd z(r.size(), n);
  for (Eigen::Index i = 0; i < n; ++i)
    z.col(i) = tangent->evidence().response(chosen[static_cast<std::size_t>(i)].candidate);
  for (int iteration = 0; iteration < 4; ++iteration) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
    double largest = 0;
    if (n > 0) {
      Eigen::MatrixXd m_z(z.rows(), n);
      for (Eigen::Index i = 0; i < n; ++i) m_z.col(i) = metric.times(z.col(i));
      const Eigen::MatrixXd normal = m_z.transpose() * z + 1e-9 * Eigen::MatrixXd::Identity(n, n);
      const Eigen::VectorXd wanted = normal.ldlt().solve(m_z.transpose() * r);
      for (Eigen::Index i = 0; i < n; ++i) {
        Chosen& c = now.chosen[static_cast<std::size_t>(i)];
        const double before = c.steps;
        c.steps = std::max(0.0, c.steps + std::clamp(wanted(i), -2.0, 2.0));
        step(i) = c.steps - before;
        largest = std::max(largest, std::abs(step(i)) / std::max(0.3, c.steps));
      }
    }
    const Eigen::VectorXd before = now.moved;
    now.moved = tangent->mean(r - z * step);
    if (largest < 0.01 && (now.moved - before).norm() < 0.1) break;
    now.residual = residual_of(now.chosen, now.moved);
    judge(now);
    const Eigen::VectorXd next = effective(now);
    if (largest >= 0.01) z += (r - next - z * step) * step.transpose() / step.squaredNorm();
    r = next;
    if (now.cost < best.cost) best = now;
    if (largest < 0.03 && (now.moved - before).norm() < 0.3) break;
  }
  return best;
}

Refit Refitter::about_itself(const Refit& at) const {
  if (engine_.spares_runs()) return at;
  return refit(at.chosen, tangent_at(at.chosen, at.moved), at.moved);
}

}  // namespace airside::tools::gap
