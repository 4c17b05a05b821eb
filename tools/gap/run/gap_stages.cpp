#include "tools/gap/run/gap_stages.hpp"

#include <algorithm>
#include <cmath>

#include "tools/gap/explain/flux.hpp"

namespace airside::tools::gap {

namespace {

constexpr double serial_fit = 18;     // six of the reference, two tangents, iterations of the model without effects
constexpr double serial_search = 50;  // of one effect: trials, its refit, its rivals
constexpr double search_of_nothing = 8;
constexpr double test_days = 5;    // simulated for each test on site
constexpr double heat_part = 0.6;  // of the window, that a pulse of heat is lived through
constexpr double fit_algebra = 1.0, search_algebra = 1.0, heat_algebra = 1.0;

/// Of steps one after another and others side by side.
double weight_of(double serial, double parallel, int jobs) {
  return (serial + parallel / jobs) / std::max(1.0, serial + parallel);
}

}  // namespace

bool seems_to_miss_something(const CaseData& data, const WindowResponses& responses) {
  const auto rmse = [](const Eigen::MatrixXd& residual, Eigen::Index channel) {
    double square = 0, count = 0;
    for (const double x : residual.col(channel)) {
      if (!std::isfinite(x)) continue;
      square += x * x;
      count += 1;
    }
    return std::sqrt(square / std::max(1.0, count));
  };
  const Eigen::MatrixXd before = data.reference.measured - responses.reference.base;
  const Eigen::MatrixXd now = data.test.measured - responses.test.base;
  for (Eigen::Index c = 0; c < now.cols(); ++c) {
    if (rmse(now, c) > 4.0 / 3.0 * rmse(before, c)) return true;
  }
  return false;
}

GapStages::GapStages(const Engine& engine, const Library& library, int days, int jobs)
    : responses_(2.0 * static_cast<double>(simulated_runs(engine, library))),
      parameters_(engine.spares_runs() ? 0.0 : static_cast<double>(library.parameters.size())),
      zones_(engine.channels().mau_temp()),
      jobs_(std::max(1, jobs)),
      days_(std::max(1, days)),
      spares_(engine.spares_runs()) {}

double GapStages::heat_steps() const {
  const HeatRules rules;
  return zones_ * static_cast<double>(rules.pulse_hours.size()) + rules.refinements + 1;
}

std::vector<Stage> GapStages::stages() const {
  const auto algebra = [this](double rc) { return spares_ ? 1.0 : rc; };
  return {
      {"simulating every effect", responses_, 1.0 / jobs_},
      {"fitting", serial_fit + 3 * parameters_, algebra(fit_algebra) * weight_of(serial_fit, 3 * parameters_, jobs_)},
      {"searching", 0.6 * (serial_search + parameters_),
       algebra(search_algebra) * weight_of(serial_search, parameters_, jobs_)},
      {"explaining", 0.3 * experiment_steps(), algebra(heat_algebra) * (test_days / days_ + heat_part) / 2 / jobs_}};
}

double GapStages::search_steps(double over_limit) const {
  return over_limit > 1 ? serial_search + parameters_ : search_of_nothing;
}

double GapStages::explaining_steps(const Verdict& verdict) const {
  switch (verdict.kind) {
    case VerdictKind::ambiguous: return 2 + experiment_steps();
    case VerdictKind::unknown: return 2 + heat_steps();
    case VerdictKind::named:
    case VerdictKind::none: break;
  }
  return 2;
}

}  // namespace airside::tools::gap
