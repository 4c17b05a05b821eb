#pragma once
// The control modes LEARN < RUN < EXPERT < RELEASE and the reasons that ask for them (mode_table.hpp).

#include <cstdint>

namespace airside {

/// Control modes of the mode arbiter, numbers frozen.
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
  authority_lost = 29,          ///< the setpoint stays at its limit and the rooms do not follow
};

}  // namespace airside
