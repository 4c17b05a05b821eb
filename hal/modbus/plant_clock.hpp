#pragma once
// Clocks of the control loop: the machine's own, and that of a simulated plant behind Modbus, which runs as fast
// as its server likes. Both satisfy lib's Clock.

#include <atomic>
#include <cmath>
#include <csignal>
#include <optional>

#include "airside/civil_time.hpp"
#include "airside/plant.hpp"
#include "hal/modbus/link.hpp"
#include "hal/modbus/wire.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

/// Second 0 of clock_s and clock_advance_s: 2000-01-01 00:00 local standard time.
constexpr CivilTime clock_epoch{946684800};

/// Somebody's wish to stop: a signal handler's variable, a thread's atomic, or none.
class StopFlag {
 public:
  StopFlag() = default;
  explicit StopFlag(const volatile std::sig_atomic_t* flag) : signal_(flag) {}
  explicit StopFlag(const std::atomic<bool>* flag) : atomic_(flag) {}
  bool raised() const { return (signal_ != nullptr && *signal_ != 0) || (atomic_ != nullptr && atomic_->load()); }

 private:
  const volatile std::sig_atomic_t* signal_ = nullptr;
  const std::atomic<bool>* atomic_ = nullptr;
};

/// Sleeps in slices until `deadline_ns` of monotonic_ns(). False: the flag was raised before.
bool sleep_until_ns(std::int64_t deadline_ns, const StopFlag& stop);

/// The machine's clock in local standard time; waits run on the monotonic clock, so a jump of the wall clock
/// neither skips nor repeats one.
class SystemClock {
 public:
  /// `utc_offset_s`: of local standard time, s east of UTC; without it the machine's time zone. `speed`: from now on
  /// `speed` times as fast as the machine's clock, for measurements.
  explicit SystemClock(StopFlag stop = {}, std::optional<int> utc_offset_s = std::nullopt, double speed = 1.0);
  CivilTime now() const;
  /// A hastened clock that stands before t is set to t, so that a process that is started again goes on.
  void go_on_from(CivilTime t);
  /// False: asked to stop before t. Cost: returns within 0.1 s of a stop.
  bool sleep_until(CivilTime t) const {
    return sleep_until(t, HUGE_VAL, [] {});
  }
  /// The same, and calls `meanwhile()` each `every_s` of this clock that pass before t.
  template <class Meanwhile>
  bool sleep_until(CivilTime t, double every_s, const Meanwhile& meanwhile) const {
    const std::int64_t left_ns = t.seconds * 1'000'000'000 - site_ns();
    due_ns_ = monotonic_ns() + machine_ns(static_cast<double>(left_ns));
    bool goes_on = true;
    if (every_s * 1e9 < static_cast<double>(left_ns)) {
      const std::int64_t every_ns = machine_ns(every_s * 1e9);
      for (std::int64_t at = monotonic_ns() + every_ns; goes_on && at < due_ns_; at = monotonic_ns() + every_ns) {
        goes_on = sleep_until_ns(at, stop_);
        if (goes_on) meanwhile();
      }
    }
    goes_on = goes_on && sleep_until_ns(due_ns_, stop_);
    woke_ns_ = monotonic_ns();
    woke_ = now();
    return goes_on;
  }
  CivilTime woke() const { return woke_; }
  /// The instant that the last sleep_until waited for, and when it came back, in monotonic_ns().
  std::int64_t due_ns() const { return due_ns_; }
  std::int64_t woke_ns() const { return woke_ns_; }

 private:
  std::int64_t site_ns() const;
  /// What passes on the machine's clock while `ns` pass on this one.
  std::int64_t machine_ns(double ns) const { return std::llround(ns / speed_); }

  StopFlag stop_;
  int utc_offset_s_;
  double speed_;
  std::int64_t began_wall_ns_, began_ns_;
  mutable std::int64_t due_ns_ = 0, woke_ns_ = 0;  ///< noted, of no influence
  mutable CivilTime woke_;
};

/// The clock of a plant that publishes clock_s and takes clock_advance_s: asks it to reach t, then waits.
///
/// One reading may be wrong. A reading is believed at once where it is within `leap_s` of the last one believed, or not
/// further than `leap_s` beyond the instant that the plant was asked to reach. Any other one is a jump, believed only
/// once `confirmations` further readings, each `confirm_every_s` after the one before, go on steadily from it.
/// No wait is begun, nor gone on with, for an instant further than `longest_wait_s` ahead of the clock, so that a clock
/// that was ahead and is right again is followed.
class ModbusPlantClock {
 public:
  static constexpr std::int64_t leap_s = clock_leap_s;
  static constexpr int confirmations = 3;
  static constexpr double confirm_every_s = 0.1;
  /// A clock that has not read near the last time believed for so long, nor steadily, is believed at its last word.
  static constexpr double give_in_s = 2.0;
  /// run_cycles() waits at most for the row after a clock that was set back by clock_leap_s.
  static constexpr std::int64_t longest_wait_s = clock_leap_s + row_s;

  /// Jumps since the start.
  struct Jumps {
    std::uint64_t doubted = 0;  ///< that did not last
    std::uint64_t taken = 0;    ///< that were confirmed
    CivilTime from, to;         ///< the newest one
  };

  /// `stall_s`: real seconds without progress of clock_s after which sleep_until gives up.
  /// Errors: InputError where the map has no clock_s or no clock_advance_s.
  ModbusPlantClock(const PointMap& map, ModbusLink& link, StopFlag stop = {}, double stall_s = 120.0);
  /// The plant's time; the last one believed while the link is down or a jump is not confirmed.
  /// Cost: one exchange; the first time `confirmations` more, since there is nothing to compare with.
  CivilTime now();
  /// False: asked to stop, the plant's clock stood still for stall_s, or it is too far behind t.
  bool sleep_until(CivilTime t);
  CivilTime woke() const { return last_; }
  /// Whether the last sleep_until ended because the plant stood still.
  bool stalled() const { return stalled_; }
  /// Whether it ended because the clock is further than longest_wait_s behind t: go on from now().
  bool set_back() const { return set_back_; }
  const Jumps& jumps() const { return jumps_; }

 private:
  bool read_clock();
  bool request(CivilTime t);
  /// Believes a reading, or keeps it as a jump that waits to be confirmed. Returns whether it is believed.
  bool take(CivilTime reading);

  Point clock_, advance_;
  ModbusLink* link_;
  StopFlag stop_;
  double stall_s_;
  CivilTime last_ = clock_epoch;
  CivilTime wanted_ = clock_epoch;  ///< that the plant was asked to reach
  bool known_ = false;              ///< last_ was read
  bool stalled_ = false, set_back_ = false;
  CivilTime jump_;  ///< the newest reading that awaits confirmation
  std::int64_t jump_ns_ = 0, strange_since_ns_ = 0;
  int confirming_ = 0, strange_ = 0;  ///< readings that go on steadily from jump_; all that were not believed
  Jumps jumps_;
};

static_assert(Clock<SystemClock> && Clock<ModbusPlantClock>);

}  // namespace airside::hal
