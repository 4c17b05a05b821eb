#pragma once
// Models that the project did not write: those of the PyPI package pyenergyplus-lbnl, beside the engine's own package.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "sim/energyplus/install.hpp"

#define AIRSIDE_NEEDS_ADOPT_ENGINE()    \
  if (!airside::sim::have_energyplus()) \
  GTEST_SKIP() << "\n*** EnergyPlus is not installed: run tools/setup. This test checked nothing. ***"

#define AIRSIDE_NEEDS_FOREIGN_MODELS()                                                                    \
  AIRSIDE_NEEDS_ADOPT_ENGINE();                                                                           \
  if (airside::tools::foreign_models().empty())                                                           \
  GTEST_SKIP() << "\n*** The reference buildings are not installed: run tools/setup --for test, or name " \
                  "their folder in AIRSIDE_FOREIGN_MODELS. This test checked nothing. ***"

namespace airside::tools {

/// The folder of the reference buildings; empty where it is not there.
inline std::filesystem::path foreign_models() {
  const char* named = std::getenv("AIRSIDE_FOREIGN_MODELS");
  const std::filesystem::path folder =
      named != nullptr ? std::filesystem::path(named)
                       : sim::find_energyplus().folder.parent_path().parent_path() / "pyenergyplus" / "data" / "model";
  return std::filesystem::is_directory(folder) ? folder : std::filesystem::path();
}

}  // namespace airside::tools
