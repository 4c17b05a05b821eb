#pragma once
// Sensors may be wrong at any time, and are checked here, once, every row. Nothing behind the validator sees an
// unchecked number: only Validator makes a ValidReading.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tl/expected.hpp>

#include "airside/civil_time.hpp"
#include "airside/fault.hpp"
#include "airside/presets.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/signals.hpp"
#include "airside/supervision/limits.hpp"  // IWYU pragma: export
#include "airside/topology.hpp"

namespace airside {

/// A reading that passed. Shape: T. Units: SI.  Values that were lost for less than `hold_s` are held at the last good
/// one.
template <Topology T>
class ValidReading {
 public:
  CivilTime time() const { return time_; }
  const typename Reading<T>::Vector& value() const { return value_; }
  /// True if every value is fresh and good: only such a reading may be learned from.
  bool learnable() const { return held_ == 0; }
  int held() const { return held_; }
  double room_mean_degc() const { return value_.head(rooms_of<T>(site_)).mean(); }
  double setpoint_degc() const { return setpoint_degc_; }

 private:
  template <Topology U>
  friend class Validator;
  CivilTime time_;
  typename Reading<T>::Vector value_;
  double setpoint_degc_ = 0;
  int held_ = 0;
  Shape site_;
};

/// Checks each row against limits and the rows before, of which it keeps what that needs. Shape: T, of which the site's
/// own signals. Plain bytes: part of the durable state.
template <Topology T>
class Validator {
 public:
  static constexpr int n = Layout<T>::signals;

  Validator() { take_settings(product_settings()), fill_default_limits<T>(limits_); }
  explicit Validator(const LimitsTable<T>& limits, const ControllerSettings& settings = product_settings()) {
    use_limits(limits, settings);
  }

  /// Checks every signal: finite, fresh, in range, not too fast, not stuck; replaces a lost one by its last good
  /// value for at most hold_s, and a single room far from all others by the median of the rooms.
  /// Errors: the first fault whose value can no longer be held; frozen, if no signal has changed for frozen_s;
  /// disagrees, if more than one room does. Cost: O(signals).  Source: docs/box-and-safety.md, rows 1-6.
  Expected<ValidReading<T>> check(const Reading<T>& reading) { return check(reading, reading.time); }
  /// The same for a row whose instant counts, not the one at which the plant was asked.
  /// Rooms are compared with each other only while air flows: without it one may get much warmer than the others.
  Expected<ValidReading<T>> check(const Reading<T>& reading, CivilTime t, bool flows = true) {
    ValidReading<T> out;
    out.time_ = t;
    out.setpoint_degc_ = reading.setpoint_degc;
    out.site_ = site_;
    Fault lost = Fault::none;
    const bool moved = peers_moved(reading, t);
    for (int i = 0; i < n; ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      if (!limits_[k].sensed) {
        out.value_(i) = limits_[k].stand_in;
        faults_[k] = Fault::none;
        continue;
      }
      faults_[k] = examine(i, reading, t, moved);
      if (faults_[k] == Fault::none) {
        out.value_(i) = last_good_[k];
        continue;
      }
      const std::int64_t lost_s = t.seconds - good_at_[k];  // negative after the clock was set back
      const bool held = seen_[k] && lost_s >= 0 && lost_s <= static_cast<std::int64_t>(hold_s_);
      if (!held && lost == Fault::none) lost = faults_[k], lost_signal_ = i;
      out.value_(i) = last_good_[k];
      ++out.held_;
    }
    if (lost == Fault::none && flows) lost = disagreement(out);
    if (frozen(reading, t)) lost = Fault::frozen, lost_signal_ = -1;
    if (lost != Fault::none) return tl::unexpected(lost);
    return out;
  }

  /// Replaces the limits, which belong to the site file and not to the saved state.
  void use_limits(const LimitsTable<T>& limits, const ControllerSettings& settings) {
    limits_ = limits;
    take_settings(settings);
  }

  /// Fault of each signal at the last check, and the signal whose loss refused the reading.
  const std::array<Fault, static_cast<std::size_t>(n)>& faults() const { return faults_; }
  int lost_signal() const { return lost_signal_; }

 private:
  void take_settings(const ControllerSettings& settings) {
    site_ = shape_in<T>(settings.shape);
    keep_to_shape<T>(site_, limits_);
    hold_s_ = settings.hold_s;
    frozen_s_ = settings.frozen_s;
    disagree_k_ = settings.disagree_k;
  }

  Fault examine(int i, const Reading<T>& reading, CivilTime t, bool peers_moved) {
    const std::size_t k = static_cast<std::size_t>(i);
    const SignalLimits& l = limits_[k];
    const double v = reading.value(i);
    const Fault unfit = !std::isfinite(v)                  ? Fault::not_finite
                        : !(reading.age_s(i) <= l.stale_s) ? Fault::stale
                        : v < l.min || v > l.max           ? Fault::out_of_range
                                                           : Fault::none;
    if (unfit != Fault::none) {
      suspects_[k] = 0;
      return unfit;
    }
    const bool status = is_status(signal_id<T>(i).kind);
    if (seen_[k] && !status) {
      const double minutes = std::max(1.0, static_cast<double>(t.seconds - good_at_[k]) / 60.0);
      if (std::abs(v - last_good_[k]) > l.max_rate_per_min * minutes && !confirmed(k, v, l.max_rate_per_min)) {
        return Fault::rate_exceeded;
      }
    }
    suspects_[k] = 0;
    const bool set_back = changed_at_[k] > t.seconds;
    if (!seen_[k] || set_back || v != last_good_[k]) changed_at_[k] = t.seconds;
    last_good_[k] = v;
    seen_[k] = true;
    const bool can_stick = signal_id<T>(i).kind == SignalKind::room_temp;
    const bool rests = t.seconds - changed_at_[k] > static_cast<std::int64_t>(l.stuck_s);
    // Once found stuck it stays so until it moves, also while the peers rest.
    if (can_stick && rests && (peers_moved || faults_[k] == Fault::stuck)) {
      return Fault::stuck;
    }
    good_at_[k] = t.seconds;
    return Fault::none;
  }

  /// A jump is believed when three samples in a row agree on the new level.
  bool confirmed(std::size_t k, double v, double max_rate_per_min) {
    const bool agrees = suspects_[k] > 0 && std::abs(v - suspect_[k]) <= std::max(0.5, 6.0 * max_rate_per_min);
    suspects_[k] = agrees ? static_cast<std::uint8_t>(suspects_[k] + 1) : std::uint8_t{1};
    suspect_[k] = v;
    return suspects_[k] >= 3;
  }

  /// Excitation: some room has moved by 0.5 K within the present window of at most stuck_s. A room that has not
  /// changed for longer than stuck_s has not moved in it, so it was another one.
  bool peers_moved(const Reading<T>& reading, CivilTime t) {
    double widest = 0;
    const std::int64_t window_s = t.seconds - window_at_;  // negative after the clock was set back
    const auto over = [window_s](double stuck_s) {
      return window_s < 0 || window_s > static_cast<std::int64_t>(stuck_s);
    };
    for (int r = 0; r < rooms_of<T>(site_); ++r) {
      const std::size_t k = static_cast<std::size_t>(r);
      const double v = reading.value(r);
      if (!std::isfinite(v)) continue;
      if (!seen_[k] || over(limits_[k].stuck_s)) low_[k] = high_[k] = v;
      low_[k] = std::min(low_[k], v);
      high_[k] = std::max(high_[k], v);
      widest = std::max(widest, high_[k] - low_[k]);
    }
    if (over(limits_[0].stuck_s)) window_at_ = t.seconds;
    return widest >= 0.5;
  }

  /// One room far from the median of the good ones is replaced by it; with more of them nobody knows who is right.
  Fault disagreement(ValidReading<T>& out) {
    const int rooms = rooms_of<T>(site_);
    std::array<double, static_cast<std::size_t>(Layout<T>::rooms)> good;  // in order
    std::size_t count = 0;
    for (int r = 0; r < rooms; ++r) {
      if (faults_[static_cast<std::size_t>(r)] != Fault::none) continue;
      std::size_t at = count++;
      for (; at > 0 && good[at - 1] > out.value_(r); --at) good[at] = good[at - 1];
      good[at] = out.value_(r);
    }
    if (count < 3) return Fault::none;
    const double median = 0.5 * (good[(count - 1) / 2] + good[count / 2]);
    int outliers = 0;
    for (int r = 0; r < rooms; ++r) {
      const std::size_t k = static_cast<std::size_t>(r);
      if (faults_[k] != Fault::none || std::abs(out.value_(r) - median) <= disagree_k_) continue;
      faults_[k] = Fault::disagrees;
      lost_signal_ = r;
      out.value_(r) = median;
      ++out.held_;
      ++outliers;
    }
    return outliers > 1 ? Fault::disagrees : Fault::none;
  }

  /// A gateway that lost its device may repeat the last answer for ever; no building repeats every digit for an hour.
  bool frozen(const Reading<T>& reading, CivilTime t) {
    bool same = true;
    for (int i = 0; i < n; ++i) {
      const double v = reading.value(i), before = previous_[static_cast<std::size_t>(i)];
      same = same && (v == before || (std::isnan(v) && std::isnan(before)));
      previous_[static_cast<std::size_t>(i)] = v;
    }
    if (!same || moved_at_ > t.seconds) moved_at_ = t.seconds;
    return static_cast<double>(t.seconds - moved_at_) > frozen_s_;
  }

  LimitsTable<T> limits_;
  double hold_s_ = 0, frozen_s_ = 0, disagree_k_ = 0;
  std::array<double, static_cast<std::size_t>(n)> last_good_{};
  std::array<std::int64_t, static_cast<std::size_t>(n)> good_at_{};
  std::array<std::int64_t, static_cast<std::size_t>(n)> changed_at_{};
  std::array<double, static_cast<std::size_t>(n)> suspect_{};
  std::array<double, static_cast<std::size_t>(Layout<T>::rooms)> low_{}, high_{};
  std::int64_t window_at_ = 0;
  std::array<double, static_cast<std::size_t>(n)> previous_{};
  std::int64_t moved_at_ = 0;
  std::array<std::uint8_t, static_cast<std::size_t>(n)> suspects_{};
  std::array<bool, static_cast<std::size_t>(n)> seen_{};
  std::array<Fault, static_cast<std::size_t>(n)> faults_{};
  std::int32_t lost_signal_ = -1;
  Shape site_ = capacity_of<T>();
};

}  // namespace airside
