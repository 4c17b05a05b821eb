#pragma once
// Which weather an adopted model runs on.

#include <filesystem>
#include <string>

#include "sim/energyplus/install.hpp"
#include "tools/adopt/model/model_view.hpp"

namespace airside::tools {

struct WeatherChoice {
  std::filesystem::path file;
  std::string note;         ///< why this one
  double latitude_deg = 0;  ///< of the file's station
};

/// `wanted`, or the station nearest to the model's Site:Location among the weather files beside the model, in a folder
/// `weather` next to its own, and of the engine's package.
/// Errors: hal::InputError for a file that is absent, broken or not of a whole year.
WeatherChoice choose_weather(const ModelView& model, const std::filesystem::path& model_file,
                             const std::filesystem::path& wanted, const sim::EnergyPlusInstall& install);

}  // namespace airside::tools
