#pragma once
// The best that any controller could do on an RC room for one cycle, found by branching the plant: with nothing
// known of the future, with the mean daily profile known, with everything known. Studies compare against these.

#include "sim/rc/rc_plant.hpp"

namespace airside::sim {

/// What the one who chooses knows of the coming cycle.
enum class Foresight {
  frozen,   ///< disturbances stay as they are now
  profile,  ///< the expected daily profile, without its random part
  full,     ///< the true future
};

/// Mean room temperature (what the sensors show, without noise) after `ahead_s` at a held setpoint; the plant itself
/// stays where it is.  degC.
double mean_room_temp_after(const RcPlant& plant, double setpoint_degc, Foresight foresight,
                            int ahead_s = default_cycle.seconds());

/// The setpoint in [lo, hi], held for `ahead_s`, a control cycle, whose mean room temperature at their end is nearest
/// to the target; a limit if the target is out of reach.  degC. Source: docs/method.md 4.3, 16.4.  Cost: about 6
/// simulated cycles, 20 us.
double floor_setpoint(const RcPlant& plant, double target_degc, double lo, double hi, Foresight foresight,
                      int ahead_s = default_cycle.seconds());

/// floor_setpoint with disturbances frozen at their last value: the floor without forecasting.
double frozen_floor_setpoint(const RcPlant& plant, double target_degc, double lo, double hi);
/// floor_setpoint with the mean daily profile known.
double profile_floor_setpoint(const RcPlant& plant, double target_degc, double lo, double hi);
/// floor_setpoint with the true future known.
double full_forecast_setpoint(const RcPlant& plant, double target_degc, double lo, double hi);

}  // namespace airside::sim
