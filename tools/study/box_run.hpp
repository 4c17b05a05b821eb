#pragma once
// One run of a room whose boxes modulate under one way of choosing the supply-air setpoint, and its figures.

#include <cstdint>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "airside/demand_settings.hpp"
#include "airside/settings.hpp"
#include "sim/rc/modulating_room.hpp"

namespace airside::tools {

/// How the setpoint is chosen.
struct BoxMethod {
  enum class Kind : std::uint8_t { constant, guideline36, band };
  Kind kind = Kind::constant;
  double degc = 14;  ///< the constant, or Guideline 36's warmest setpoint
  DemandSettings demand{};
  std::string name() const;
};

/// Means a day over the scored days.
struct BoxFigures {
  double fan_kwh = 0, cooling_kwh = 0, heat_kwh = 0;
  double above_degch = 0;  ///< zone degree-hours above setpoint + 0.5 K in occupied hours, sum over zones
  double below_degch = 0;  ///< below heating setpoint - 0.5 K
  double saturated_h = 0;  ///< zone-hours with a damper above 0.95
  double setpoint_degc = 0;
  double darv_degc = 0;                      ///< docs/method.md 9, on 18-min samples of occupied hours
  double lowest_degc = 0, highest_degc = 0;  ///< setpoints written
  double total_kwh() const { return fan_kwh + cooling_kwh + heat_kwh; }
};

struct BoxRun {
  std::string scenario = "mild";
  std::uint64_t seed = 1;
  CivilTime from;               ///< first scored midnight
  int days = 14;                ///< that are scored
  int schedule_days = 6;        ///< before, under the schedule
  double blind_from_day = 1e9;  ///< dampers are lost from that scored day on
};

/// Setpoints 12 to 18 degC; the schedule that runs before and is fallen back to has 14 degC.
ControllerSettings box_site_settings();

/// Every setpoint passes the safety envelope. Guideline 36 is asked every 3 min, the objective every 18.
/// Errors: hal::InputError for an unknown scenario.  Cost: about 10 ms a run of 20 days.
BoxFigures run_boxes(const BoxRun& run, const BoxMethod& method);

/// Of these constants the one that takes least energy among those that keep zones in their band as well as the best
/// of them, to 0.25 zone degree-hours a day.  Shape: figures one a constant, not empty.
std::size_t best_constant(const std::vector<BoxFigures>& figures);

}  // namespace airside::tools
