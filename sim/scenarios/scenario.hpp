#pragma once
// Rooms that are harder to control than a summer's office: named conditions that any built-in room can be put into.
// What differs is drawn from the run's seed as ever.

#include <span>
#include <string>
#include <string_view>

#include "sim/energyplus/options.hpp"
#include "sim/rc/rc_room.hpp"

namespace airside::sim {

struct Scenario {
  std::string_view name;
  std::string_view text;                                ///< what is hard, one line
  std::string_view start;                               ///< first day, "2021-08-01"
  bool weekends = false;                                ///< Saturday and Sunday nearly empty
  double fan_start_h = 0, fan_stop_h = 0;               ///< the AHU rests outside; equal: never. RC alone
  void (*change_room)(RcRoom&) = nullptr;               ///< nullptr: nothing
  void (*change_engine)(EnergyPlusOptions&) = nullptr;  ///< nullptr: nothing
  bool on_rc = true, on_energyplus = true;
};

/// All, easiest first.
std::span<const Scenario> scenarios();

/// Errors: hal::InputError naming `option` for a name that is none.
const Scenario& scenario(const std::string& option, const std::string& name);

}  // namespace airside::sim
