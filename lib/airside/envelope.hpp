#pragma once
// The last gate before the actuator, and the only maker of a Command.

#include <algorithm>
#include <cmath>
#include <limits>

#include "airside/command.hpp"
#include "airside/settings.hpp"

namespace airside {

/// What stands in the AHU's register, degC: one value where it is known, a range after writes whose fate is not, NaN
/// where nothing was ever written or read.
struct StandingSetpoint {
  double low_degc = std::numeric_limits<double>::quiet_NaN();
  double high_degc = std::numeric_limits<double>::quiet_NaN();

  void is(double degc) { low_degc = high_degc = degc; }
  void may_be(double degc) {
    low_degc = std::fmin(low_degc, degc);  // takes the number of a number and a NaN
    high_degc = std::fmax(high_degc, degc);
  }
};

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
    return limit(proposal_degc, StandingSetpoint{last_degc, last_degc}, fallback_degc);
  }
  /// The same, within one step of whatever may stand. A range stays narrower than a step, since each setpoint that
  /// was written lay within one of both its ends.
  Command limit(double proposal_degc, const StandingSetpoint& standing, double fallback_degc) const {
    double a = std::isfinite(proposal_degc) ? proposal_degc : fallback_degc;
    if (!std::isfinite(a)) a = std::isfinite(standing.low_degc) ? standing.low_degc : max_;
    double low = min_, high = max_;
    if (std::isfinite(standing.low_degc) && std::isfinite(standing.high_degc)) {
      low = std::max(min_, std::clamp(standing.high_degc, min_, max_) - change_);
      high = std::max(low, std::min(max_, std::clamp(standing.low_degc, min_, max_) + change_));
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
