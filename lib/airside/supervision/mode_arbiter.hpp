#pragma once
// The mode arbiter LEARN < RUN < EXPERT < RELEASE: the highest control mode that any active reason asks for wins. Every
// reason says why it is there and how it ends.

#include <array>
#include <cstdint>
#include <limits>

#include "airside/civil_time.hpp"

namespace airside {

/// Control modes of the mode arbiter, numbers frozen. Source: docs/box-and-safety.md, "Control modes".
enum class ControlMode : std::uint8_t {
  learn = 0,    ///< control and learn
  run = 1,      ///< control with frozen weights
  expert = 2,   ///< the schedule
  release = 3,  ///< nothing is written
};

constexpr const char* text_of(ControlMode mode) {
  switch (mode) {
    case ControlMode::learn: return "learn";
    case ControlMode::run: return "run";
    case ControlMode::expert: return "expert";
    case ControlMode::release: return "release";
  }
  return "unknown";
}

/// Why a control mode was taken. Frozen numbers: they stand in logs, snapshots and durable state. Those of control mode
/// LEARN are alarms alone.
enum class Reason : std::uint8_t {
  none = 0,
  setpoint_altered = 1,         ///< the AHU took another setpoint than the one written
  storage_failed = 2,           ///< state or log cannot be written; all goes on in memory
  signal_held = 3,              ///< a signal stands in with its last good value
  room_disagrees = 4,           ///< one room is far from all others; their median stands in
  sensor_drifts = 5,            ///< one room has moved away from the others for days
  supply_ignores_setpoint = 6,  ///< supply air stays away from its setpoint
  no_excitation = 7,            ///< the setpoint has hardly moved for a day
  learning_refused = 8,         ///< the gate refused every update for a day
  worse_than_schedule = 9,      ///< the rooms are further off than the schedule would have them
  no_weights = 10,              ///< nothing has been trained yet
  signal_lost = 11,             ///< a signal is gone for longer than it may be held
  no_reading = 12,              ///< the plant does not answer
  forecast_invalid = 13,        ///< network and head give no number
  gain_reversed = 14,           ///< the rooms answer to the setpoint the wrong way round
  write_refused = 15,           ///< the AHU refused a setpoint
  clock_not_set = 16,           ///< the clock cannot be right
  crash_loop = 17,              ///< the daemon was restarted too often
  state_lost = 18,              ///< no saved generation is whole, though there was one
  worse_for_long = 19,          ///< as worse_than_schedule, for a working day
  overridden = 20,              ///< somebody else has set the setpoint
  two_masters = 21,             ///< somebody else sets it again and again
  writes_refused = 22,          ///< the AHU refused the schedule's setpoint too
  map_differs = 23,             ///< the device is not the one that the point map describes
  released_by_hand = 24,        ///< an operator asked for it
  map_refused = 25,             ///< the device refuses a request that the point map makes
  gateway_failed = 26,          ///< a gateway does not reach the device behind it
  order_doubted = 27,           ///< a value makes sense only in another order of its words
  forecasts_doubted = 28,       ///< forecasts have been so wrong for a day that the schedule has the say
};
constexpr int reason_count = 29;

/// What a reason asks for. Texts are whole phrases for log, status and page.
struct ModeRequest {
  const char* name;
  ControlMode mode;
  bool beats;       ///< the heartbeat goes on, also while nothing is written
  bool for_person;  ///< ends only when a person hands the AHU back
  const char* why;
  const char* way_out;
};

/// Where a controller stands on the mode arbiter, and why.
struct ActiveMode {
  ControlMode mode = ControlMode::learn;
  Reason reason = Reason::none;
  bool operator==(const ActiveMode&) const = default;
};

constexpr ModeRequest request_of(Reason reason) {
  switch (reason) {
    case Reason::none: return {"none", ControlMode::learn, true, false, "all is well", "none needed"};
    case Reason::setpoint_altered:
      return {"setpoint altered",
              ControlMode::learn,
              true,
              false,
              "the AHU took another setpoint than the one written",
              "ends with the first setpoint that is taken as written; look for limits in the AHU"};
    case Reason::storage_failed:
      return {"storage failed",
              ControlMode::learn,
              true,
              false,
              "state or log cannot be written",
              "ends with the first write that succeeds; look at the disk"};
    case Reason::signal_held:
      return {"signal held",
              ControlMode::run,
              true,
              false,
              "a signal stands in with its last good value",
              "ends when the signal is back"};
    case Reason::room_disagrees:
      return {"room disagrees",
              ControlMode::run,
              true,
              false,
              "one room sensor is far from all others, whose median stands in",
              "ends when it is back among them; look at that sensor"};
    case Reason::sensor_drifts:
      return {"sensor drifts",
              ControlMode::run,
              true,
              false,
              "one room sensor has moved away from the others for days",
              "ends when it stays where it is for two weeks; compare that sensor with a thermometer"};
    case Reason::supply_ignores_setpoint:
      return {"supply ignores setpoint",
              ControlMode::run,
              true,
              false,
              "supply air stays away from its setpoint",
              "ends when it follows again; look at valve, coil and fan"};
    case Reason::no_excitation:
      return {"no excitation",
              ControlMode::run,
              true,
              false,
              "the setpoint has hardly moved for a day, nothing can be learned from that",
              "ends when it moves"};
    case Reason::learning_refused:
      return {"learning refused", ControlMode::run, true, false, "every update of the weights was refused for a day",
              "ends after a day"};
    case Reason::worse_than_schedule:
      return {"worse than schedule",
              ControlMode::run,
              true,
              false,
              "rooms are further from target than the schedule would have them",
              "ends when they are closer again"};
    case Reason::no_weights:
      return {"no weights", ControlMode::expert,        true,
              false,        "there are no weights yet", "ends with the first weights; airside push"};
    case Reason::signal_lost:
      return {"signal lost",
              ControlMode::expert,
              true,
              false,
              "a signal is gone for longer than it may be held",
              "ends when the signal is back"};
    case Reason::no_reading:
      return {"no reading", ControlMode::expert,       true,
              false,        "the AHU does not answer", "ends with the first answer; look at the bus"};
    case Reason::forecast_invalid:
      return {"forecast invalid",
              ControlMode::expert,
              true,
              false,
              "network and head give no number",
              "ends with the first forecast"};
    case Reason::gain_reversed:
      return {"gain reversed",
              ControlMode::expert,
              true,
              false,
              "rooms get warmer when supply air gets colder",
              "ends when the schedule's days show a sane answer; look for a heating AHU or exchanged sensors"};
    case Reason::write_refused:
      return {"write refused",
              ControlMode::expert,
              true,
              false,
              "the AHU refused a setpoint",
              "ends with the first setpoint that is taken; look at limits and rights of the register"};
    case Reason::clock_not_set:
      return {"clock not set", ControlMode::expert, true, false, "the clock cannot be right", "ends when it is set"};
    case Reason::crash_loop:
      return {"crash loop",
              ControlMode::expert,
              true,
              false,
              "the daemon was started too often in ten minutes",
              "ends after an hour without a restart"};
    case Reason::state_lost:
      return {"state lost",
              ControlMode::expert,
              true,
              true,
              "no saved state is whole and of this version, though there was one",
              "ends when weights are pushed or the AHU is handed back; look at the disk"};
    case Reason::worse_for_long:
      return {"worse for long",
              ControlMode::expert,
              true,
              false,
              "rooms were further from target than the schedule would have had them, for a working day",
              "ends after a day under the schedule"};
    case Reason::overridden:
      return {"overridden",
              ControlMode::release,
              true,
              false,
              "somebody else has set the setpoint",
              "ends after the override's time, or when the AHU is handed back"};
    case Reason::two_masters:
      return {"two masters",
              ControlMode::release,
              false,
              true,
              "somebody else sets the setpoint again and again, or another airsided has taken this one's state folder",
              "ends when the AHU is handed back; find the other master"};
    case Reason::writes_refused:
      return {"writes refused",
              ControlMode::release,
              false,
              false,
              "the AHU refused the schedule's setpoint too",
              "tried again every hour, and when the AHU is handed back"};
    case Reason::map_differs:
      return {"map differs",
              ControlMode::release,
              false,
              false,
              "the device is not the one that the point map describes",
              "ends when it is; correct points.csv or the address"};
    case Reason::released_by_hand:
      return {"released by hand",           ControlMode::release, false, true, "an operator has released the AHU",
              "ends when it is handed back"};
    case Reason::map_refused:
      return {"map refused",
              ControlMode::learn,
              true,
              false,
              "the device refuses a request that the point map makes",
              "ends when it answers; correct function, address or type in points.csv, airside probe shows which"};
    case Reason::gateway_failed:
      return {"gateway failed",
              ControlMode::learn,
              true,
              false,
              "a gateway does not reach the device behind it",
              "ends when it does; look at the gateway and at unit_id"};
    case Reason::order_doubted:
      return {"order doubted",
              ControlMode::learn,
              true,
              false,
              "a value makes sense only in another order of its words",
              "ends when it makes sense as the map has it; airside probe shows which order fits"};
    case Reason::forecasts_doubted:
      return {"forecasts doubted",
              ControlMode::learn,
              true,
              false,
              "the room's forecasts have been so wrong for a day that the schedule has the say",
              "ends when they come true again; look for what has changed in the room, or push other weights"};
  }
  return {"unknown", ControlMode::release, false, true, "unknown", "unknown"};
}

constexpr const char* text_of(Reason reason) { return request_of(reason).name; }
/// What people read of it. The schedule without a reason is where every controller begins.
constexpr const char* why_of(ActiveMode on) {
  return on == ActiveMode{ControlMode::expert, Reason::none} ? "it has decided nothing yet" : request_of(on.reason).why;
}
constexpr const char* way_out_of(ActiveMode on) {
  return on == ActiveMode{ControlMode::expert, Reason::none} ? "ends with its first cycle"
                                                             : request_of(on.reason).way_out;
}

/// Which reasons are active and until when. Plain bytes: part of the durable state.
class ModeArbiter {
 public:
  /// Keeps `reason` from t for `seconds`, or for ever where only a person ends it. Called again it begins anew.
  constexpr void hold(Reason reason, CivilTime t, std::int64_t seconds) {
    if (reason == Reason::none) return;
    if (!active(reason, t)) since(reason) = t.seconds;
    until(reason) = request_of(reason).for_person ? for_ever : t.seconds + seconds;
  }
  /// Active until the next set(reason, false).
  constexpr void set(Reason reason, bool is_so, CivilTime t) {
    if (reason == Reason::none) return;
    if (!is_so) {
      until(reason) = 0;
    } else {
      if (!active(reason, t)) since(reason) = t.seconds;
      until(reason) = for_ever;
    }
  }
  /// A person gives the AHU back: everything that waits for one ends, and every override.
  constexpr void hand_back() {
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      if (r == Reason::map_differs) continue;  // nobody's word makes it the right device
      if (request_of(r).for_person || request_of(r).mode == ControlMode::release) until(r) = 0;
    }
  }
  /// Ends everything that does not keep the AHU released. What is known of the clock stays: limits are moved by it.
  constexpr void keep_only_releases() {
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      if (request_of(r).mode != ControlMode::release && r != Reason::clock_not_set) until(r) = 0;
    }
  }
  /// Follows the clock to t. What keeps the AHU released on another mode arbiter, which has followed it there, keeps it
  /// on this one at least as long, and so does a crash loop; and what the other knows of the clock holds here.
  constexpr void join_releases(const ModeArbiter& other, CivilTime t) {
    tick(t);
    set(Reason::clock_not_set, other.active(Reason::clock_not_set, t), t);
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      const auto at = static_cast<std::size_t>(i);
      if (request_of(r).mode != ControlMode::release && r != Reason::crash_loop) continue;
      if (!other.active(r, t) || other.until_s_[at] <= until(r)) continue;
      since(r) = other.since_s_[at];
      until(r) = other.until_s_[at];
    }
  }
  /// Follows the clock: where it is set back, what began later is moved with it, so that no time limit grows; and
  /// where one that was never set is set at last, so that none shrinks.
  constexpr void tick(CivilTime t) {
    const bool set_back = t.seconds < last_s_ - cycle_s;
    const bool set_at_last = t.seconds > last_s_ + cycle_s && active(Reason::clock_not_set, t);
    if (last_s_ != never && (set_back || set_at_last)) {
      const std::int64_t moved_s = t.seconds - last_s_;
      for (int i = 1; i < reason_count; ++i) {
        const auto r = static_cast<Reason>(i);
        if (until(r) == 0) continue;
        since(r) += moved_s;
        if (until(r) != for_ever) until(r) += moved_s;
      }
    }
    last_s_ = t.seconds;
  }

  constexpr bool active(Reason reason, CivilTime t) const {
    return until_s_[static_cast<std::size_t>(reason)] > t.seconds;
  }
  constexpr std::int64_t since_s(Reason reason) const { return since_s_[static_cast<std::size_t>(reason)]; }

  /// The gravest active reason: of the highest control mode, the one with the highest number.
  constexpr Reason gravest(CivilTime t) const {
    Reason found = Reason::none;
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      if (!active(r, t)) continue;
      if (request_of(r).mode >= request_of(found).mode)
        found = r;  // uncovered: so far numbers rise with the control modes
    }
    return found;
  }
  constexpr ControlMode mode(CivilTime t) const { return request_of(gravest(t)).mode; }
  /// Whether the heartbeat may go on: no active reason forbids it.
  constexpr bool beats(CivilTime t) const {
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      if (active(r, t) && !request_of(r).beats) return false;
    }
    return true;
  }

 private:
  static constexpr std::int64_t for_ever = std::numeric_limits<std::int64_t>::max();
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::min() + cycle_s;

  constexpr std::int64_t& until(Reason r) { return until_s_[static_cast<std::size_t>(r)]; }
  constexpr std::int64_t& since(Reason r) { return since_s_[static_cast<std::size_t>(r)]; }

  std::array<std::int64_t, reason_count> until_s_{};  ///< 0: not active
  std::array<std::int64_t, reason_count> since_s_{};
  std::int64_t last_s_ = never;
};

}  // namespace airside
