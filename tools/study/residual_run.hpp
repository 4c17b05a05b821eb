#pragma once
// What the room head does not foresee: its error in each cycle beside all that a forecaster might know of it.

#include <string>

#include "tools/study/control_methods.hpp"

namespace airside::tools {

/// Runs the product on the trial, trained on the schedule's days alone, and returns a CSV with a line a cycle:
///   time, setpoint_degc applied from then on, head_error_k of the cycle that ended then (empty: no forecast),
///   every signal then and, as before_NAME, 6 min earlier,
///   outdoor_AHEAD_degc and sun_AHEAD_w_m2 of the weather file AHEAD = 0, 18, 36, 54 min later,
///   people_w and people_18_w, the true heat of people and devices then and 18 min later (RC rooms; empty: unknown).
/// Errors: hal::InputError of the trial.
std::string residual_csv(const Trial& trial);

}  // namespace airside::tools
