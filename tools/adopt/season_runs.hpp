#pragma once
// The engine's runs of one adoption: weeks under the model's own control, and the same two days of each season under
// setpoints.

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/energyplus/install.hpp"
#include "sim/energyplus/process.hpp"
#include "tools/adopt/comparison.hpp"
#include "tools/adopt/model/weather_choice.hpp"
#include "tools/adopt/observation.hpp"

namespace airside::tools {

/// Called before each run of the engine: how many are done, of how many, and what runs now.
using OnEngineRun = std::function<void(int done, int planned, const std::string& what)>;

class SeasonRuns {
 public:
  /// All that is named must outlive this. `place`: the model's, for complaints.
  SeasonRuns(const sim::EnergyPlusInstall& install, const WeatherChoice& weather, std::string place, int planned,
             OnEngineRun progress)
      : install_(install),
        weather_(weather),
        place_(std::move(place)),
        planned_(planned),
        progress_(std::move(progress)) {}

  /// Some days from a Monday on. The run's files stay in folder() until the next. `what`: for people.
  /// Errors: as observe().
  Observation run(const nlohmann::json& model, const AirLoop& loop, Season season, int days, const std::string& what);
  std::filesystem::path folder() const { return folder_.path() / "run"; }

 private:
  const sim::EnergyPlusInstall& install_;
  const WeatherChoice& weather_;
  std::string place_;
  int planned_, done_ = 0;
  OnEngineRun progress_;
  sim::RunFolder folder_;
};

/// The patched model with the setpoint's schedule (a Schedule:Constant) at a value. Units: degC.
nlohmann::json held_at(nlohmann::json patched, const std::string& schedule, double degc);
/// The same with the site's schedule: work_degc in its working hours, off_degc otherwise.
nlohmann::json scheduled(nlohmann::json patched, const std::string& schedule, const SiteChoices& choices);

}  // namespace airside::tools
