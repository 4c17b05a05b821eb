#pragma once
// One run of an adopted building under one way of choosing the supply-air setpoint, and its figures.

#include <cstdint>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "tools/run/control_run.hpp"
#include "tools/run/site.hpp"
#include "tools/study/metered_model.hpp"

namespace airside::tools {

/// How the setpoint is chosen.
struct BuildingMethod {
  enum class Kind : std::uint8_t {
    own,          ///< the model's own setpoint managers, as its author left them
    schedule,     ///< the site's
    constant,     ///< value: degC
    integral,     ///< value: gain, 1/h
    guideline36,  ///< by zones and dampers; without dampers only what is 2 K too warm asks. value: warmest, degC
    mpc,
    ours,  ///< the site's preset and objective
  };
  Kind kind = Kind::own;
  double value = 0;
};

struct BuildingRun {
  CivilTime from;                   ///< first scored midnight, 2021
  int days = 14;                    ///< that are scored
  int schedule_days = 5;            ///< before, under the schedule
  std::uint64_t seed = 1;           ///< of the sensors' noise
  const BlobBytes* blob = nullptr;  ///< ours with the objective "mean": weights to fine-tune; nullptr: from scratch
};

/// Errors: hal::InputError for a site without a [twin] of its own control.
void check_building(const Site& site);

/// Errors: as check_building(), and what the engine complains of.
/// Cost: 2 to 15 s a run of 19 days.
BuildingFigures run_building(const Site& site, const BuildingRun& run, const BuildingMethod& method);

/// Weights for `ours`, pretrained on the site's twin in the `days` before `until`.
BlobBytes pretrain_building(const Site& site, CivilTime until, int days, std::uint64_t seed);

/// The constants that a site's range offers, coldest first: six, evenly spaced to 0.1 K.
std::vector<double> building_constants(const Site& site);

/// Of these figures the best for an objective. mean: least DAE. band: least energy among those whose zones are outside
/// their bands not more than most_outside_degch().
/// Shape: not empty.
std::size_t best_for(Objective objective, int zones, const std::vector<BuildingFigures>& figures);

/// mean: no limit. band: the fewest degree-hours of these figures, and 0.05 a zone and day.
double most_outside_degch(Objective objective, int zones, const std::vector<BuildingFigures>& figures);

/// `own`, `schedule`, `constants`, `integral`, `guideline-36`, `mpc`, `ours`.
std::string name_of(BuildingMethod::Kind kind);
/// Errors: std::invalid_argument.
BuildingMethod::Kind kind_of(const std::string& name);
std::vector<std::string> building_kinds();

}  // namespace airside::tools
