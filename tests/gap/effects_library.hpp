#pragma once
// The library of effects as its tests use it: on a room of five zones, five fan coils and two powers, for a weekend.

#include <array>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sim/rc/rc_replay.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/model/engine.hpp"

namespace airside::sim {

inline const std::filesystem::path library_folder =
    std::filesystem::path(AIRSIDE_SOURCE_DIR) / "sim" / "effects" / "library";

inline const std::vector<Effect>& library() {
  static const std::vector<Effect> effects = load_effects(library_folder);
  return effects;
}

inline const Effect& effect_named(std::string_view name) {
  for (const Effect& e : library()) {
    if (e.name == name) return e;
  }
  throw std::logic_error("no effect " + std::string(name));
}

constexpr Channels five{5, 5, 2};
constexpr std::array<bool, facades> windows{false, true, true, true};

inline std::shared_ptr<const Weather> station() {
  static const auto weather = synthetic_weather(3);
  return weather;
}

/// Friday to Sunday; cold enough before dawn for the RC room's coil to drip.
inline Recording weekend() { return eventful_recording(station(), civil_midnight(2021, 7, 2), 3, 12, 4); }

}  // namespace airside::sim
