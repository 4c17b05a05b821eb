#pragma once
// A foreign EnergyPlus model made into a site: what was found, chosen and changed, and the files that say so.

#include <filesystem>
#include <string>
#include <vector>

#include "tools/adopt/choices.hpp"
#include "tools/adopt/comparison.hpp"
#include "tools/adopt/loop/air_loop.hpp"
#include "tools/adopt/loop/setpoint_patch.hpp"
#include "tools/adopt/season_runs.hpp"
#include "tools/adopt/sizes.hpp"
#include "tools/adopt/upgrade/upgrade.hpp"

namespace airside::tools {

struct AdoptRequest {
  std::filesystem::path model;    ///< .idf or .epJSON
  std::string air_loop;           ///< empty: the only one
  std::filesystem::path weather;  ///< empty: the nearest file beside the model or of the engine's package
  std::filesystem::path folder;   ///< of the site
  bool force = false;             ///< write into a folder that has files already
  OnEngineRun progress;
  std::string transitions = {};  ///< folder of Transition programs; empty: AIRSIDE_TRANSITIONS, the engine's, or none
};

struct Adoption {
  std::string model_name;    ///< file name, for documents
  std::string weather_name;  ///< file name in the site's folder
  std::string weather_note;
  std::string engine;  ///< its version
  AirLoop loop;
  SetpointPatch setpoint;
  FoundSizes sizes;
  SiteChoices choices;
  double probed_min_degc = 0, probed_max_degc = 0;
  std::vector<Comparison> seasons;  ///< summer, winter, autumn: what a setpoint does, between these two
  std::vector<double> most_kw;      ///< of each power meter, in the two weeks
  std::vector<std::string> notes;   ///< of conversion and repair
  Upgrade upgrade;                  ///< of a model of an older version

  /// Of a season.
  const Response& response(Season season) const { return seasons.at(static_cast<std::size_t>(season)).response; }
  bool shows_people() const { return choices.people; }
  /// Boxes that modulate and show it: the objective is "band", which needs no weights. Else it is the rooms' mean.
  bool serves_band() const;
  std::string topology() const;  ///< "5vav-0fcu-2power"
};

/// Adopts a model: model.epJSON, twin.patch.json, site.toml, points.csv, map.toml, adopt.md and the weather appear in
/// the folder, all or none.
/// Errors: hal::InputError for a model that cannot be adopted, a folder that has files already, weather that is absent
///   or not of a whole year.
/// Cost: six runs of some days, 10 to 60 s; seven where the engine refuses hard sizes.
Adoption adopt(const AdoptRequest& request);

/// All that adopt() checks before the engine runs: conversion, loop, setpoint, meters, schema, weather. Nothing is
/// written; sizes, choices, seasons and powers stay empty. `folder` is not looked at.
/// Errors: as of adopt().
/// Cost: below 1 s.
Adoption check_adoptable(const AdoptRequest& request);

/// The part of adopt() that needs no engine: loop and setpoint patch, after the model was read.
/// Errors: hal::InputError.
Adoption examine(const nlohmann::json& model, const std::string& place, const std::string& air_loop);

}  // namespace airside::tools
