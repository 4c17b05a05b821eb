#pragma once
// What is watched over days beside each single reading: whether sensors drift, supply air follows, the setpoint moves,
// and whether the schedule would do better. Plain bytes, part of the durable state; every judgement is a bool that the
// mode arbiter turns into a control mode.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "airside/civil_time.hpp"
#include "airside/settings.hpp"

namespace airside {

/// How long something has been so without a break.
class PersistentCondition {
 public:
  /// Returns whether it has been so for at least `seconds`. Nobody knows of a longest gap between two looks, such as a
  /// bus that was away or a clock that was set: it begins anew.
  constexpr bool lasts(bool is_so, CivilTime t, std::int64_t seconds, std::int64_t longest_gap_s = seconds_per_day) {
    if (!is_so) {
      looked_s_ = 0;
      return false;
    }
    const std::int64_t gap_s = t.seconds + 1 - looked_s_;
    if (looked_s_ == 0 || gap_s < 0 || gap_s > longest_gap_s) since_s_ = t.seconds;
    looked_s_ = t.seconds + 1;
    return t.seconds - since_s_ >= seconds;
  }

 private:
  std::int64_t since_s_ = 0;
  std::int64_t looked_s_ = 0;  ///< a second after the last look; 0: it was not so then
};

/// How often somebody else sets what this controller has set. Source: docs/box-and-safety.md, row 25.
class OverrideMonitor {
 public:
  /// Takes one time more; returns whether it is the third within 24 h.
  constexpr bool third_in_a_day(CivilTime t) {
    const bool set_back = times_ > 0 && t.seconds < last_s_;
    if (set_back) times_ = 0;
    const bool third = times_ >= 2 && t.seconds - before_last_s_ < seconds_per_day;
    before_last_s_ = last_s_;
    last_s_ = t.seconds;
    times_ = times_ < 2 ? times_ + 1 : 2;
    return third;
  }

 private:
  std::int64_t before_last_s_ = 0, last_s_ = 0, times_ = 0;
};

/// Whether the setpoint has been at a limit of its range for long while the rooms stay beyond the target on the side
/// that the limit should bring them back from. Rooms that come nearer by `follows_k` are on their way: time begins
/// anew.
class AuthorityMonitor {
 public:
  /// Takes one row. Returns whether it has been so for `authority_s`.
  bool row(const ControllerSettings& s, CivilTime t, double setpoint_degc, double held_degc) {
    const double error_k = held_degc - s.target_degc, off_k = std::abs(error_k);
    const double slack_k = 0.5 * s.action_step_k;
    const bool coldest = setpoint_degc <= s.action_min_degc + slack_k && error_k > s.authority_k;
    const bool warmest = setpoint_degc >= s.action_max_degc - slack_k && error_k < -s.authority_k;
    const bool is_stuck = coldest || warmest;
    const bool begins = is_stuck && off_k < begun_k_ - follows_k;
    if (begins) stuck_ = PersistentCondition();
    if (begins || !is_stuck) begun_k_ = is_stuck ? off_k : unknown_k;
    return stuck_.lasts(is_stuck, t, static_cast<std::int64_t>(s.authority_s), seconds_per_hour);
  }

 private:
  static constexpr double follows_k = 0.3, unknown_k = 1e9;

  PersistentCondition stuck_;
  double begun_k_ = unknown_k;  ///< distance from the target when it began
};

/// Whether one room leaves the others slowly: its distance from their mean over a day against that over two weeks.
/// Shape: one pair of means a room, at most Rooms. Units: K. Source: docs/box-and-safety.md, row 7 and "Thresholds".
template <int Rooms>
class DriftMonitor {
 public:
  /// Takes the rooms of one row. Returns whether any has moved by more than `limit_k`.
  template <class Vector>
  bool row(const Vector& rooms_degc, double limit_k) {
    const double mean = rooms_degc.mean();
    if (rows_ < 14 * rows_per_day) ++rows_;
    const double fast_share = 1.0 / static_cast<double>(std::min<std::int64_t>(rows_, rows_per_day));
    const double slow_share = 1.0 / static_cast<double>(rows_);
    bool drifts = false;
    for (int i = 0; i < static_cast<int>(rooms_degc.size()); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double distance = rooms_degc(i) - mean;
      fast_k_[k] += fast_share * (distance - fast_k_[k]);
      slow_k_[k] += slow_share * (distance - slow_k_[k]);
      drifts = drifts || (rows_ > 2 * rows_per_day && std::abs(fast_k_[k] - slow_k_[k]) > limit_k);
    }
    return drifts;
  }

 private:
  std::array<double, static_cast<std::size_t>(Rooms)> fast_k_{}, slow_k_{};
  std::int64_t rows_ = 0;
};

/// Whether the setpoint has moved within the last day: standard deviation of the applied setpoints, exponentially
/// forgotten with a day's time constant.
class ExcitationMonitor {
 public:
  /// Takes one cycle's applied setpoint. Returns whether it has hardly moved, known only after a day.
  bool cycle(double setpoint_degc, double least_sd_k, int cycles_per_day) {
    if (cycles_ < cycles_per_day) ++cycles_;
    const double share = 1.0 / static_cast<double>(cycles_);
    const double step = setpoint_degc - mean_degc_;
    mean_degc_ += share * step;
    variance_k2_ += share * (step * (setpoint_degc - mean_degc_) - variance_k2_);
    return cycles_ == cycles_per_day && variance_k2_ < least_sd_k * least_sd_k;
  }

 private:
  double mean_degc_ = 0, variance_k2_ = 0;
  std::int64_t cycles_ = 0;
};

/// Our error against that of the schedule's shadow, in working hours: the held value as it would be had the schedule's
/// setpoint been applied, by the room head's gain.
///   shadow = s + gain (a_expert - a_applied),  errors |s - target|, |shadow - target|, means over a working day
class ScheduleShadowMonitor {
 public:
  void cycle(const ControllerSettings& settings, double held_degc, double applied_degc, double expert_degc,
             double gain) {
    if (!std::isfinite(applied_degc) || !std::isfinite(held_degc)) return;
    const double shadow = held_degc + gain * (expert_degc - applied_degc);
    if (cycles_ < control_cycle(settings).per_day() / 2) ++cycles_;  // a working day
    const double share = 1.0 / static_cast<double>(cycles_);
    ours_k_ += share * (std::abs(held_degc - settings.target_degc) - ours_k_);
    schedule_k_ += share * (std::abs(shadow - settings.target_degc) - schedule_k_);
  }
  bool worse(const ControllerSettings& settings) const {
    const int least = control_cycle(settings).per_day() * 3 / 20;  // 3.6 h
    return cycles_ >= least && ours_k_ > schedule_k_ + settings.worse_k;
  }
  void reset() { *this = {}; }
  double ours_k() const { return known(ours_k_); }  ///< NaN before the first working cycle
  double schedule_k() const { return known(schedule_k_); }

 private:
  double known(double mean_k) const { return cycles_ > 0 ? mean_k : std::numeric_limits<double>::quiet_NaN(); }

  double ours_k_ = 0, schedule_k_ = 0;
  std::int64_t cycles_ = 0;
};

}  // namespace airside
