#pragma once
// Faults of sensors and of the AHU as a script: what happens, when, for how long, to which signal. What the bus and the
// box can do wrong beside that is made by `airside chaos` and by the tests.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/log/log_csv.hpp"

namespace airside::sim {

enum class FaultKind : std::uint8_t {
  not_a_number,      ///< a signal has no value
  set_to,            ///< a signal reads the magnitude
  offset,            ///< a signal reads so much too high
  stuck,             ///< a signal repeats its value
  drift,             ///< a signal reads too high by so much more each day
  reversed,          ///< a signal of 0 to 1 reads 1 less its value
  all_stuck,         ///< the device repeats all its values
  all_offset,        ///< all rooms read so much too high
  setpoint_clamped,  ///< the AHU takes at most this setpoint
  setpoint_by_hand,  ///< somebody sets this setpoint once
  setpoint_fought,   ///< somebody sets this setpoint again and again, every 12 min
  setpoint_ignored,  ///< the AHU shows the setpoint, and goes on with the one before
  restarted,         ///< the AHU stays at this default until another is written
};

/// What a kind is called in a script, and what its magnitude is.
struct FaultKindText {
  FaultKind kind;
  const char* name;
  bool on_signal;         ///< needs the name of a signal
  const char* magnitude;  ///< unit and meaning; empty: none
  const char* meaning;
};
std::span<const FaultKindText> fault_kinds();

/// One fault. Hours count from the start of the run.
struct ScriptedFault {
  FaultKind kind;
  double begin_h = 0, for_h = 0;
  int signal = -1;  ///< index in fault_signals(); -1 where the kind has none
  double magnitude = 0;
};
using FaultScript = std::vector<ScriptedFault>;

/// The signals that can have faults: those of the topology in its order, then what is no input of the network:
/// supply_temp, occupied, supply_flow, ahu_on, the dampers, the zone setpoints. Where a plant does not offer one, a
/// fault of it changes nothing.
std::vector<std::string> fault_signals(const hal::TopologyCounts& counts);

/// Reads `begin_h,for_h,fault,signal,magnitude` lines under that header; # begins a comment line. Any order, any
/// overlap.  Errors: hal::InputError naming line and field; nothing of a bad file is used.
/// Source: docs/formats.md "Faults of a simulated room".
FaultScript read_fault_script(const std::string& path, const hal::TopologyCounts& counts);

}  // namespace airside::sim
