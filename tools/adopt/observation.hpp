#pragma once
// Days of a foreign model, run by the engine's own program: what its own control does, and what a setpoint does.

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/energyplus/install.hpp"
#include "tools/adopt/loop/air_loop.hpp"

namespace airside::tools {

/// Some days from a Monday on, at the model's own time step. Series are of one length; empty where the model has none.
struct Observation {
  int steps_per_day = 0;
  std::vector<std::vector<double>> room_degc;   ///< a zone of the loop, in its order
  std::vector<std::vector<double>> cooling_sp;  ///< thermostats, degC
  std::vector<std::vector<double>> heating_sp;
  std::vector<std::vector<double>> people;  ///< persons
  std::vector<std::vector<double>> damper;  ///< 0..1, of terminals that have one
  std::vector<double> setpoint_degc;        ///< of the supply outlet; -999: none at that step
  std::vector<double> supply_degc, flow_kg_s, outdoor_degc;
  std::map<std::string, std::vector<double>> meter_kw;  ///< those that the model has and that are not always zero

  std::size_t steps() const { return supply_degc.size(); }
  double hour_of_day(std::size_t step) const {
    return 24.0 * static_cast<double>(step % static_cast<std::size_t>(steps_per_day)) / steps_per_day;
  }
  int weekday(std::size_t step) const { return static_cast<int>(step / static_cast<std::size_t>(steps_per_day)) % 7; }
};

/// What to run.
struct ObservationPlan {
  const nlohmann::json* model = nullptr;  ///< with its patches
  const AirLoop* loop = nullptr;
  std::filesystem::path weather;
  int month = 7, first_day = 12;  ///< of 2021, a Monday
  int days = 7;
};

/// Meters of power that a site may show: the loop's own, then the building's.
const std::vector<std::string>& candidate_meters();

/// Runs the engine once in `folder`, where its files stay (eplusout.eio, for sizes).
/// Errors: hal::InputError with the engine's own words where the run fails.
/// Cost: 1 to 10 s.
Observation observe(const ObservationPlan& plan, const sim::EnergyPlusInstall& install,
                    const std::filesystem::path& folder, const std::string& place);

}  // namespace airside::tools
