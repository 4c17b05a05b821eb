#pragma once
// Everything that describes a room whose boxes modulate: each zone holds its own temperature by its damper, so the
// supply air's temperature decides what fan, chiller and reheat take, and hardly how warm the rooms are.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/rc/rc_room.hpp"
#include "sim/weather/synthetic_weather.hpp"

namespace airside::sim {

/// How the boxes and their air handler work. Lists have one entry a box.
struct ModulatingAir {
  std::vector<double> flow_max_m3_s;     ///< damper open
  std::vector<double> flow_min_share;    ///< of it that flows with the damper at its minimum
  std::vector<double> cooling_degc;      ///< zone setpoint in occupied hours; the box cools above
  std::vector<double> heating_degc;      ///< the box reheats below
  std::vector<double> reheat_kw;         ///< 0: no coil
  double setback_k = 4;                  ///< both setpoints move away by this outside occupied hours
  double loop_gain_per_k = 0.5;          ///< of the cooling and the heating loop
  double loop_integral_per_kh = 1.0;     ///< the same, integral part
  double discharge_max_degc = 32;        ///< of a reheating box
  double fan_kw = 2.8;                   ///< all dampers open
  double fan_heat_share = 0.9;           ///< of it that warms the air after the coil
  double static_share = 0.1;             ///< of the fan's pressure that does not fall with flow; 1: held constant
  double outdoor_min_m3_s = 0.25;        ///< ventilation in occupied hours
  bool economizer = true;                ///< more outdoor air where it is colder than the return air
  double economizer_high_degc = 24;      ///< and colder than this
  double supply_lag_s = 240;             ///< first order, towards the setpoint
  double coil_capacity_kw = 45;          ///< total cooling
  double coldest_supply_degc = 10;       ///< that chilled water can make
  double chiller_cop = 4.0;              ///< at 30 degC outdoors, full load
  double chiller_cop_per_k = -0.08;      ///< a K of outdoors
  double chiller_part_load_loss = 0.25;  ///< at no load it takes so much more a kW than at full load, share
  double pump_kw = 0.5;                  ///< while there is a load
  double moisture_g_s_per_zone = 0.07;   ///< of a zone's people, all there
  double fan_start_h = 6, fan_stop_h = 20;
  double occupied_start_h = 7, occupied_stop_h = 19;
};

struct ModulatingRoom {
  std::string name;
  RcRoom building;  ///< envelope, mass, gains, sensors; its own boxes, fan coils and chiller are not used
  ModulatingAir air;
  Climate climate;  ///< that it was made for
};

/// Names that modulating_room knows, in the order of tables.
std::vector<std::string_view> modulating_scenarios();

/// The room of a scenario: cores and the four façades in turn; fan, coil and ventilation grow with its boxes. `seed`
/// draws loads, sizes, setpoints and efficiencies about the scenario's own, as two buildings of one kind differ; 0
/// draws nothing.
///   humid     hot and humid, no economizer, no reheat: cold air pays but for moisture
///   mild      temperate, economizer, low minimum flow
///   reheat    temperate, economizer, high minimum flow that is reheated much of the year
///   duct      temperate, economizer, a fan at nearly constant pressure in a narrow duct: flow is dear
/// `powers` meters: one of all; fan and the rest; or fan, cooling and heat.
/// Errors: hal::InputError for another name, no box, or other meters than 0 to 3.
ModulatingRoom modulating_room(std::string_view scenario, std::uint64_t seed, int boxes = 8, int powers = 2);

/// What the name of such a room says: "modulating-mild", "modulating-mild-2".
struct ModulatingName {
  std::string scenario;
  std::uint64_t seed = 0;
};
/// Nothing for a name that does not begin with "modulating-".
/// Errors: hal::InputError for one that does and is none.
std::optional<ModulatingName> modulating_name(std::string_view room);

}  // namespace airside::sim
