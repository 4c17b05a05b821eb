#include "tools/gap/verdict/fitted_case.hpp"

#include <algorithm>
#include <cmath>

namespace airside::tools::gap {

namespace {

std::vector<bool> fitted_bins(const Rules& rules, Eigen::Index bins) {
  auto kept = counted_bins(bins);
  std::fill(kept.begin() + locked_from(rules, bins), kept.end(), false);
  return kept;
}

Eigen::VectorXd channel_norms(const Tangent& tangent, std::size_t candidate) {
  const Eigen::VectorXd z = tangent.evidence().response(candidate);
  const Eigen::Index width = tangent.responses().front().response.cols();
  return Eigen::Map<const Eigen::MatrixXd>(z.data(), width, z.size() / width).rowwise().norm();
}

}  // namespace

FittedCase::FittedCase(const Engine& with, const CaseData& of, const WindowResponses& shown, const Rules& by,
                       int threads, Refitter::Start start)
    : engine(with),
      data{evidence_of(of.reference, with.channels()), evidence_of(of.test, with.channels())},
      responses(shown),
      rules(by),
      kept(fitted_bins(by, data.test.measured.rows())),
      fit(data.has_reference() ? fit_reference(with, shown.reference, data.reference, threads)
                               : prior_fit(with, shown.test, data.test, kept, threads)),
      jobs(threads),
      nulls(data.has_reference() ? null_blocks(fit, shown.reference, data.reference) : no_null_blocks(shown.test)),
      refitter(with, data.test, shown.test, fit, nulls.nuisance, kept, threads, start) {}

void FittedCase::draw_buildings() {
  if (rules.buildings == 0) return;
  ensemble = structure_ensemble(engine, fit, data.reference, data.test, responses, refitter.tangent()->responses(),
                                rules.buildings, jobs);
  refitter.set_structure(ensemble.mean, ensemble.directions);
}

bool FittedCase::plausible(const Refit& at) const {
  const Chosen& last = at.chosen.back();
  return candidate(last).at.effect->plausible(refitter.magnitude(last));
}

bool FittedCase::already(const Refit& now, std::size_t other) const {
  return std::any_of(now.chosen.begin(), now.chosen.end(),
                     [&](const Chosen& c) { return candidate(c).at.id() == responses.test.candidates[other].at.id(); });
}

double FittedCase::samples() const {
  const auto r = refitter.whiten(data.test.measured - responses.test.base);
  return std::max(1.0, static_cast<double>((r.array() != 0).count()));
}

double FittedCase::residual_ratio_of_chance() const {
  const double days = std::max(1.0, static_cast<double>(std::count(kept.begin(), kept.end(), true)) / bins_per_day);
  return 1 + (rules.residual_ratio_limit - 1) * std::sqrt(std::max(1.0, rules.residual_ratio_days / days));
}

Selection beside(const Refit& now, std::size_t left_out) {
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < now.chosen.size(); ++i) {
    if (i != left_out) others.push_back(now.chosen[i].candidate);
  }
  return Selection(now.tangent->evidence(), others);
}

double channel_overlap(const Tangent& tangent, const std::vector<Chosen>& chosen, std::size_t candidate) {
  const Eigen::VectorXd own = channel_norms(tangent, candidate);
  double overlap = 0;
  for (const Chosen& c : chosen) {
    const Eigen::VectorXd other = channel_norms(tangent, c.candidate);
    const double norms = own.norm() * other.norm();
    if (norms > 0) overlap = std::max(overlap, own.dot(other) / norms);
  }
  return overlap;
}

double shape_error(const Rules& rules, const Tangent& tangent, const std::vector<Chosen>& chosen, double explained,
                   std::size_t candidate) {
  const double overlap = channel_overlap(tangent, chosen, candidate);
  return rules.further_share * overlap * overlap * std::max(0.0, explained);
}

}  // namespace airside::tools::gap
