#pragma once
// The last gate before the actuator, and the only maker of a Command.

#include <algorithm>
#include <cmath>
#include <limits>

#include "airside/command.hpp"
#include "airside/settings.hpp"

namespace airside {

/// The setpoint in the AHU's register: one value where it is known, a range after writes whose fate is not, NaN where
/// nothing was ever written or read. Units: degC.
struct StoredSetpoint {
  double low_degc = std::numeric_limits<double>::quiet_NaN();
  double high_degc = std::numeric_limits<double>::quiet_NaN();

  void is(double degc) { low_degc = high_degc = degc; }
  void may_be(double degc) {
    low_degc = std::fmin(low_degc, degc);  // takes the number of a number and a NaN
    high_degc = std::fmax(high_degc, degc);
  }
};

/// Limits a proposal: finite, then clamp, then rate, then round, then to a value that the AHU's register can hold.
class SafetyEnvelope {
 public:
  constexpr explicit SafetyEnvelope(const ControllerSettings& s)
      : min_(s.limit_min_degc),
        max_(s.limit_max_degc),
        change_(s.limit_change_k),
        jump_(s.outside_jump != 0),
        round_(s.round_k),
        step_(s.register_step_k),
        offset_(s.register_offset_degc) {}

  /// The nearest safe setpoint to `proposal_degc`, at most one rate step from `last_degc`.
  /// A register that is found outside the limits by more than a step is moved by one step towards them, each cycle
  /// until it is inside: a command is inside the limits, or nearer to them than what is stored and one step from it.
  /// A sudden move of many kelvin slams valves and trips frost protection, while a value on the way in is never worse
  /// than the one that the AHU runs on already. With `outside_jump` the step counts from the nearer limit instead.
  /// Units: degC. `fallback_degc` replaces a proposal that is not finite; `last_degc` may be NaN (unknown): no rate
  /// limit then, since any other choice would invent a value.
  /// A register's values that lie all beyond that step are reached in one of their own.
  /// Errors: none; every input, NaN included, yields a safe Command.
  Command limit(double proposal_degc, double last_degc, double fallback_degc) const {
    return limit(proposal_degc, StoredSetpoint{last_degc, last_degc}, fallback_degc);
  }
  /// The same, within one step of whatever may be stored. A range stays narrower than a step, since each setpoint that
  /// was written lay within one of both its ends.
  Command limit(double proposal_degc, const StoredSetpoint& stored, double fallback_degc) const {
    double a = std::isfinite(proposal_degc) ? proposal_degc : fallback_degc;
    if (!std::isfinite(a)) a = std::isfinite(stored.low_degc) ? stored.low_degc : max_;
    double low = min_, high = max_;
    if (std::isfinite(stored.low_degc) && std::isfinite(stored.high_degc)) {
      const double coldest = jump_ ? std::clamp(stored.low_degc, min_, max_) : stored.low_degc;
      const double warmest = jump_ ? std::clamp(stored.high_degc, min_, max_) : stored.high_degc;
      if (warmest < min_ && coldest + change_ < lowest_held()) return Command(towards(coldest, coldest + change_));
      if (coldest > max_ && warmest - change_ > highest_held()) return Command(towards(warmest, warmest - change_));
      low = std::max(min_, warmest - change_);
      high = std::max(low, std::min(max_, coldest + change_));
    }
    a = std::clamp(a, low, high);
    const double rounded = std::clamp(on_grid(a, low, high, round_, 0, 0), low, high);
    if (!(step_ > 0)) return Command(rounded);
    double held = on_grid(rounded, low, high, step_, offset_, slack_k);
    if (held > high + slack_k) held = on_grid(rounded, min_, max_, step_, offset_, slack_k);
    return Command(std::clamp(held, min_, max_));
  }

  constexpr double min_degc() const { return min_; }
  constexpr double max_degc() const { return max_; }
  constexpr double change_k() const { return change_; }

 private:
  static constexpr double slack_k = 1e-9;  ///< a limit on the grid is a decimal, the grid's value a product

  /// Rounding must not undo a limit: towards the inside where the nearest step lies outside.
  static double on_grid(double a, double low, double high, double step, double offset, double slack) {
    const double n = (a - offset) / step;
    double rounded = offset + step * std::round(n);
    if (rounded > high + slack) rounded = offset + step * std::floor(n);
    if (rounded < low - slack) rounded = offset + step * std::ceil(n);
    return rounded;
  }

  /// The outermost setpoints within the limits that the register can hold.
  double lowest_held() const {
    return step_ > 0 ? offset_ + step_ * std::ceil((min_ - offset_) / step_ - slack_k) : min_;
  }
  double highest_held() const {
    return step_ > 0 ? offset_ + step_ * std::floor((max_ - offset_) / step_ + slack_k) : max_;
  }

  /// From outside the limits towards them: the value on the grid next to `reach` on the way from `from`, and the first
  /// one at all where the grid is wider than a rate step. A value so far away that a step is lost in its last bits is
  /// no setpoint: it counts as the nearer limit.
  double towards(double from, double reach) const {
    const double step = step_ > 0 ? step_ : round_, offset = step_ > 0 ? offset_ : 0;
    const bool up = reach > from;
    const auto nearer = [&](double a) { return up ? a > from && a <= max_ : a < from && a >= min_; };
    const double n = (reach - offset) / step, first = (from - offset) / step;
    const double near = offset + step * (up ? std::floor(n + slack_k) : std::ceil(n - slack_k));
    if (nearer(near)) return near;
    const double next = offset + step * (up ? std::floor(first + slack_k) + 1 : std::ceil(first - slack_k) - 1);
    const double own = step_ > 0 ? next : reach;
    if (nearer(own)) return own;
    return std::clamp(from < min_ ? lowest_held() : highest_held(), min_, max_);
  }

  double min_, max_, change_;
  bool jump_;
  double round_, step_, offset_;
};

}  // namespace airside
