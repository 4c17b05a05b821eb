#include "tools/adopt/model/weather_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <optional>
#include <sstream>
#include <vector>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/weather.hpp"
#include "sim/weather/epw.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

struct Place {
  double latitude_deg = 0, longitude_deg = 0;
};

/// Of the line LOCATION,City,State,Country,Source,WMO,latitude,longitude,...
std::optional<Place> place_of_file(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line) || !line.starts_with("LOCATION")) return std::nullopt;
  std::vector<std::string> cells;
  std::istringstream parts(line);
  for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(cell);
  if (cells.size() < 8) return std::nullopt;
  return Place{std::strtod(cells[6].c_str(), nullptr), std::strtod(cells[7].c_str(), nullptr)};
}

double distance_km(const Place& a, const Place& b) {
  const double rad = std::numbers::pi / 180;
  const double c = std::sin(a.latitude_deg * rad) * std::sin(b.latitude_deg * rad) +
                   std::cos(a.latitude_deg * rad) * std::cos(b.latitude_deg * rad) *
                       std::cos((a.longitude_deg - b.longitude_deg) * rad);
  return 6371 * std::acos(std::clamp(c, -1.0, 1.0));
}

std::optional<Place> place_of_model(const ModelView& model) {
  for (const ModelObject& site : model.all("Site:Location")) {
    const auto latitude = site.fields->find("latitude"), longitude = site.fields->find("longitude");
    if (latitude == site.fields->end() || longitude == site.fields->end()) continue;
    if (latitude->is_number() && longitude->is_number())
      return Place{latitude->get<double>(), longitude->get<double>()};
  }
  return std::nullopt;
}

WeatherChoice nearest(const ModelView& model, const fs::path& model_file, const sim::EnergyPlusInstall& install) {
  const auto here = place_of_model(model);
  if (!here)
    return {sim::default_weather(install),
            "the model has no Site:Location; **a default, name the right file with --weather**", 0};
  const fs::path folder = fs::absolute(model_file).parent_path();
  WeatherChoice best;
  double least = 1e9;
  for (const fs::path& place : {folder, folder.parent_path() / "weather", install.folder / "WeatherData"}) {
    std::error_code failed;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(place, failed)) {
      if (engine_upper(entry.path().extension().string()) == ".EPW") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
      const auto station = place_of_file(file);
      if (!station || distance_km(*station, *here) >= least) continue;
      least = distance_km(*station, *here);
      best = {file, {}, 0};
    }
  }
  if (best.file.empty())
    return {sim::default_weather(install), "no station near the model is at hand; **a default**", 0};
  best.note = fmt::format("the nearest at hand, {:.0f} km from the model's Site:Location", least);
  if (least > 300) best.note += "; **too far to be its climate: name the right file with --weather**";
  return best;
}

}  // namespace

WeatherChoice choose_weather(const ModelView& model, const fs::path& model_file, const fs::path& wanted,
                             const sim::EnergyPlusInstall& install) {
  WeatherChoice choice{wanted, "named by --weather", 0};
  if (wanted.empty()) {
    choice = nearest(model, model_file, install);
  } else if (!fs::is_regular_file(wanted)) {
    throw hal::InputError(wanted.string(), "no such weather file", "an EPW file of a whole year",
                          "check the path, or leave --weather out: the nearest station at hand is taken");
  }
  (void)sim::read_epw_file(choice.file, {.whole_year = true, .from = {}, .to = {}});
  choice.latitude_deg = sim::read_epw(choice.file.string())->location().latitude_deg;
  return choice;
}

}  // namespace airside::tools
