#pragma once
// Which objective the setpoint serves, and every number of the objective "band".

#include <cstdint>

namespace airside {

/// What a site wants of the supply-air setpoint.
enum class Objective : std::uint8_t {
  mean = 0,  ///< hold the mean room temperature at its target: boxes that are open or shut
  band = 1,  ///< least energy with every zone in its band: boxes that modulate
};

/// Source: docs/method.md 17.
struct DemandSettings {
  double band_k = 0.5;               ///< a zone may be so far above its setpoint
  double damper_high = 0.90;         ///< a damper that must open further is short of cold air
  double saturation_cost = 4.0;      ///< of a zone's (damper - damper_high)^2, in shares of the mean power
  double warm_cost = 0.5;            ///< of a zone's excess over its band in K, in shares of the mean power
  double caution = 1.0;              ///< standard deviations of a saving that are not counted
  double move_cost = 0.004;          ///< a K^2 of the setpoint's move, in shares of the mean power
  double recover_cycles = 3;         ///< in which a zone above its setpoint is to be back
  double heat_worth = 1.0;           ///< of a kWh of heat that boxes or preheater add, in kWh of electricity
  double outdoor_share = 0.15;       ///< ventilation's least flow, share of all dampers open
  int fan_meter = 1;                 ///< 1-based meter of the supply fan alone; 0: no meter shows it alone
  int ready_cycles = 60;             ///< learned cycles before the choice counts
  double power_noise = 0.10;         ///< sd of a cycle's power about its model, share of the mean power
  double forget_per_cycle = 0.0004;  ///< share of the prior's variance that returns in a cycle: 3 % a day
  double cooling_gain_prior = 0.15;  ///< K a cycle for each K of supply air below the room, damper open
};

constexpr bool demand_settings_valid(const DemandSettings& s) {
  return s.band_k >= 0 && s.band_k <= 5 && s.damper_high >= 0.3 && s.damper_high <= 1 && s.saturation_cost >= 0 &&
         s.warm_cost >= 0 && s.caution >= 0 && s.caution <= 5 && s.move_cost >= 0 && s.recover_cycles >= 1 &&
         s.fan_meter >= 0 && s.fan_meter <= 8 && s.ready_cycles >= 1 && s.power_noise > 0 && s.forget_per_cycle >= 0 &&
         s.forget_per_cycle <= 0.1 && s.cooling_gain_prior > 0;
}
static_assert(demand_settings_valid({}));

}  // namespace airside
