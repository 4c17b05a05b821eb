#pragma once
// A command of any setpoint, through the only maker of commands.

#include <cmath>

#include "airside/supervision/envelope.hpp"

namespace airside {

inline Command command_of(double setpoint_degc, double round_k = 0.1) {
  ControllerSettings settings;
  settings.limit_min_degc = 8;
  settings.limit_max_degc = 32;
  settings.limit_change_k = 30;
  settings.round_k = round_k;
  return SafetyEnvelope(settings).limit(setpoint_degc, std::nan(""), setpoint_degc);
}

}  // namespace airside
