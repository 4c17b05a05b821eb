#pragma once
// The last gate before the actuator, and the only maker of a Command.

#include <algorithm>
#include <cmath>

#include "airside/command.hpp"
#include "airside/settings.hpp"

namespace airside {

/// Limits a proposal: finite, then clamp, then rate, then round.
class SafetyEnvelope {
 public:
  constexpr explicit SafetyEnvelope(const ControllerSettings& s)
      : min_(s.limit_min_degc), max_(s.limit_max_degc), change_(s.limit_change_k), round_(s.round_k) {}

  /// The nearest safe setpoint to `proposal_degc`, at most one rate step from `last_degc`, or from the nearer
  /// limit where that lies outside.
  /// Units: degC. `fallback_degc` replaces a proposal that is not finite; `last_degc` may be NaN (unknown): no rate
  /// limit then, since any other choice would invent a value.
  /// Errors: none; every input, NaN included, yields a safe Command.
  Command limit(double proposal_degc, double last_degc, double fallback_degc) const {
    double a = std::isfinite(proposal_degc) ? proposal_degc : fallback_degc;
    if (!std::isfinite(a)) a = std::isfinite(last_degc) ? last_degc : max_;
    double low = min_, high = max_;
    if (std::isfinite(last_degc)) {
      const double from = std::clamp(last_degc, min_, max_);
      low = std::max(min_, from - change_);
      high = std::min(max_, from + change_);
    }
    a = std::clamp(a, low, high);
    // Rounding must not undo a limit: towards the inside where the nearest step lies outside.
    double rounded = round_ * std::round(a / round_);
    if (rounded > high) rounded = round_ * std::floor(a / round_);
    if (rounded < low) rounded = round_ * std::ceil(a / round_);
    return Command(std::clamp(rounded, low, high));
  }

  constexpr double min_degc() const { return min_; }
  constexpr double max_degc() const { return max_; }
  constexpr double change_k() const { return change_; }

 private:
  double min_, max_, change_, round_;
};

}  // namespace airside
