#pragma once
// What was decided in one cycle and why: everything a log row, a status page or a person needs.

#include <cmath>
#include <limits>

#include "airside/civil_time.hpp"
#include "airside/command.hpp"
#include "airside/fault.hpp"
#include "airside/network/losses.hpp"
#include "airside/supervision/control_mode.hpp"

namespace airside {

/// One decision. Units: degC, losses in scaled units. Numbers that do not exist this time are NaN.
struct Decision {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  CivilTime time;
  Command command;
  ControlMode mode = ControlMode::expert;
  Reason reason = Reason::none;  ///< why the mode is what it is
  Fault fault = Fault::none;
  int fault_signal = -1;  ///< index in Layout<T> of the signal that caused the fault, or -1
  double room_mean_degc = none;
  double held_degc = none;     ///< the value of the rooms that is held at the target; their mean, or as the site has it
  double network_degc = none;  ///< the network's choice, A_highest
  double head_degc = none;     ///< the room head's choice
  double expert_degc = none;   ///< the schedule
  double g36_degc = none;      ///< what Guideline 36 would command
  double confidence = none;    ///< c_t before it is made effective
  double head_share = none;    ///< weight of the head against the network
  double network_error_k = none;   ///< by which the network's forecast of the cycle that ended was wrong
  double head_error_k = none;      ///< the same of the room head's
  double residual_k = none;        ///< by which the residual network expects the head's forecast to be wrong, K
  double residual_share = none;    ///< of that which the choice takes into account: 0, 0.5 or 1
  double expected_degc = none;     ///< held value forecast for the end of the cycle, at the applied setpoint
  double expected_error_k = none;  ///< root mean square of what such forecasts were wrong by lately, 20 cycles
  LossTerms loss{none, none, none, none, none, none};  ///< of the transition that just ended
};

}  // namespace airside
