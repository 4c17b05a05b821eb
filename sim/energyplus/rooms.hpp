#pragma once
// The rooms' own control and life beside the engine: fan coil thermostats, VAV outages, occupancy, the AHU's lag,
// and what the sensors make of the truth. Pure computation from a seed; one call a step.

#include <cstdint>
#include <vector>

#include "airside/civil_time.hpp"
#include "airside/splitmix64.hpp"
#include "sim/energyplus/options.hpp"

namespace airside::sim {

/// What the engine receives for one step. Shape: one entry a VAV, an FCU, a zone (interior then perimeter).
struct RoomCommands {
  double supply_setpoint_degc = 0;
  std::vector<double> vav_on, fcu_on, occupancy;
};

class RoomLoops {
 public:
  /// `vavs` interior and `fcus` perimeter zones.
  RoomLoops(const RoomLoopOptions& options, int vavs, int fcus, std::uint64_t seed, double setpoint_degc);

  /// The commands for the step that starts at t, given the true fan coil zone temperatures at t. Stateful: the
  /// lag, the thermostats and the occupancy noise advance by one step.
  const RoomCommands& step(CivilTime t, int step_s, double setpoint_degc, const std::vector<double>& fcu_temps_degc);

  /// Commands for warm-up: the first day without noise or outages, the setpoint without lag. Changes no state.
  RoomCommands warm_up(CivilTime t, double setpoint_degc, const std::vector<double>& fcu_temps_degc) const;

  const RoomCommands& commands() const { return commands_; }

  /// A temperature as its sensor reports it: noise, then two decimals. Draws from the sensors' own stream.
  double sensed_degc(double true_degc);

 private:
  double profile(CivilTime t, int zone) const;
  bool vav_out(CivilTime t, int vav) const;
  bool fcu_wanted(CivilTime t, double temp_degc, bool on) const;
  SplitMix64 day_stream(std::int64_t day, int zone, std::uint64_t purpose) const;

  RoomLoopOptions options_;
  int vavs_;
  std::uint64_t seed_;
  SplitMix64 sensor_stream_, occupancy_stream_;
  std::vector<double> occupancy_noise_;
  double lagged_setpoint_degc_;
  RoomCommands commands_;
};

/// Fraction of full occupancy at a minute of a working day: empty to 7, full from 9 to 17 with a lunch dip,
/// empty again at 20.
double office_profile(double minute_of_day);

}  // namespace airside::sim
