#pragma once
// Which objective the setpoint serves, and every number of the objective "band".

#include <array>
#include <cstdint>

#include "airside/civil_time.hpp"

namespace airside {

/// What a site wants of the supply-air setpoint.
enum class Objective : std::uint8_t {
  mean = 0,  ///< hold the mean room temperature at its target: boxes that are open or shut
  band = 1,  ///< least energy with every zone in its band: boxes that modulate
};

/// Of the objective `band`: its numbers of a cycle and its profiles are of this length.
constexpr ControlCycle band_cycle = default_cycle;
constexpr bool fits_objective(Objective objective, int cycle_min) {
  return is_cycle_min(cycle_min) && (objective != Objective::band || cycle_min == band_cycle.minutes());
}

/// Source: docs/method.md 17.
struct DemandSettings {
  double band_k = 0.5;               ///< a zone may be so far above its setpoint
  double damper_high = 0.90;         ///< a damper that must open further is short of cold air
  double saturation_cost = 4.0;      ///< of a zone's (damper - damper_high)^2, in shares of the mean power
  double warm_cost = 0.5;            ///< of a zone's excess over its band in K, in shares of the mean power
  double cold_cost = 5.0;            ///< of a zone's lack to its band in K, in shares of the mean power
  double caution = 1.0;              ///< standard deviations of a saving that are not counted
  double move_cost = 0.004;          ///< a K^2 of the setpoint's move, in shares of the mean power
  double warm_step_k = 0.6;          ///< at most so much warmer in a cycle; colder is free
  double stay_share = 0.003;         ///< a saving below this share of the mean power moves nothing
  double recover_cycles = 3;         ///< in which a zone above its setpoint is to be back
  double heat_worth = 1.0;           ///< of a kWh of heat that boxes or preheater add, in kWh of electricity
  double outdoor_share = 0.15;       ///< ventilation's least flow, share of all dampers open
  int fan_meter = 1;                 ///< 1-based meter of the supply fan alone; 0: no meter shows it alone
  int ready_cycles = 60;             ///< learned cycles before the choice counts
  double power_noise = 0.10;         ///< sd of a cycle's power about its model, share of the mean power
  double forget_per_cycle = 0.0004;  ///< share of the prior's variance that returns in a cycle: 3 % a day
  double cooling_gain_prior = 0.15;  ///< K a cycle for each K of supply air below the room, damper open
};

/// One overridable number of the objective "band": its name in site files, where it lives, its bounds.
struct DemandSettingEntry {
  const char* name;
  double DemandSettings::*real;
  int DemandSettings::*whole;
  double min, max;
};

/// Every number by name. Shape: one entry a field of DemandSettings.
constexpr auto demand_setting_table = std::to_array<DemandSettingEntry>({
    {"band_k", &DemandSettings::band_k, nullptr, 0, 5},
    {"band_damper_high", &DemandSettings::damper_high, nullptr, 0.3, 1},
    {"band_saturation_cost", &DemandSettings::saturation_cost, nullptr, 0, 1000},
    {"band_warm_cost", &DemandSettings::warm_cost, nullptr, 0, 1000},
    {"band_cold_cost", &DemandSettings::cold_cost, nullptr, 0, 1000},
    {"band_caution", &DemandSettings::caution, nullptr, 0, 5},
    {"band_move_cost", &DemandSettings::move_cost, nullptr, 0, 1000},
    {"band_warm_step_k", &DemandSettings::warm_step_k, nullptr, 0.1, 20},
    {"band_stay_share", &DemandSettings::stay_share, nullptr, 0, 1},
    {"band_recover_cycles", &DemandSettings::recover_cycles, nullptr, 1, 80},
    {"band_heat_worth", &DemandSettings::heat_worth, nullptr, 0, 10},
    {"band_outdoor_share", &DemandSettings::outdoor_share, nullptr, 0, 1},
    {"band_fan_meter", nullptr, &DemandSettings::fan_meter, 0, 8},
    {"band_ready_cycles", nullptr, &DemandSettings::ready_cycles, 1, 100000},
    {"band_power_noise", &DemandSettings::power_noise, nullptr, 1e-3, 10},
    {"band_forget_per_cycle", &DemandSettings::forget_per_cycle, nullptr, 0, 0.1},
    {"band_cooling_gain_prior", &DemandSettings::cooling_gain_prior, nullptr, 1e-4, 10},
});

constexpr bool demand_settings_valid(const DemandSettings& s) {
  for (const DemandSettingEntry& e : demand_setting_table) {
    const double v = e.real != nullptr ? s.*e.real : static_cast<double>(s.*e.whole);
    if (!(v >= e.min && v <= e.max)) return false;
  }
  return true;
}
static_assert(demand_settings_valid({}));

}  // namespace airside
