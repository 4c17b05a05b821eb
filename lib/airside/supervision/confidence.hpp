#pragma once
// Confidence: how much of the model's setpoint replaces the schedule's. It grows while forecasts come true and falls
// after a surprise.

#include <algorithm>
#include <cmath>

#include "airside/exponential.hpp"
#include "airside/settings.hpp"

namespace airside {

/// c_t = b_c exp(-loss / sigma_c) + (1 - b_c) c_{t-1}.  Source: docs/method.md 6.2. A loss that is not finite counts
/// as complete surprise.
inline double confidence_step(const ControllerSettings& s, double confidence, double loss) {
  const double trust = std::isfinite(loss) ? exponential(-loss / s.confidence_scale) : 0.0;
  return s.confidence_smoothing * trust + (1.0 - s.confidence_smoothing) * confidence;
}

/// c_eff = min(1, c / c_full): with c_full < 1 a converged model leaves no standing offset.
/// Source: docs/method.md 16.1.
inline double effective_confidence(const ControllerSettings& s, double confidence) {
  return std::clamp(confidence / s.confidence_full, 0.0, 1.0);
}

/// A* = c A + (1 - c) A_expert, degC.  Source: docs/method.md 6.2.
constexpr double fuse(double confidence, double setpoint_degc, double expert_degc) {
  return confidence * setpoint_degc + (1.0 - confidence) * expert_degc;
}

}  // namespace airside
