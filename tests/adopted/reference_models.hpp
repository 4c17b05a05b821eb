#pragma once
// Reference buildings that the project did not write, from a Python package, and what of them a plant is told.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "sim/energyplus/install.hpp"
#include "sim/energyplus/options.hpp"

namespace airside::sim {

/// The package's folder with `model` and `weather`: that above $AIRSIDE_FOREIGN_MODELS, which names the former, else
/// beside the engine's own package; empty where there is none.
std::filesystem::path reference_models();

#define AIRSIDE_NEEDS_REFERENCES()                                                                             \
  if (!airside::sim::have_energyplus() || airside::sim::reference_models().empty())                            \
  GTEST_SKIP()                                                                                                 \
      << "\n*** EnergyPlus or the reference buildings are not installed: run tools/setup --for test, or name " \
         "their folder in AIRSIDE_FOREIGN_MODELS. This test checked nothing. ***"

/// A building, converted to epJSON once a process.
std::filesystem::path reference_model(const std::string& name);
/// A weather file whose name has this part.
std::filesystem::path reference_weather(const std::string& part);

/// The patch that has `node` follow a schedule "airside supply setpoint", by the manager of setpoints that stands
/// there.
nlohmann::json setpoint_patch(const std::filesystem::path& model, const std::string& node);

/// The bottom floor of the medium office: five zones of an AHU with VAV boxes and electric reheat, Chicago.
EnergyPlusOptions medium_office();
/// The core of the small office: one zone, a packaged unit of constant flow.
EnergyPlusOptions small_office();
/// The third floor of the large hotel: outdoor air by the AHU, four-pipe fan coils in three zones.
EnergyPlusOptions large_hotel();

}  // namespace airside::sim
