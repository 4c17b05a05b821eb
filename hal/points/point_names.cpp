#include "hal/points/point_names.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>

namespace airside::hal {
namespace {

struct PlacedStem {
  const char* stem;
  const char* unit;
  SignalKind counted;
};
constexpr std::array<PlacedStem, 8> placed_stems = {{{"room_temp", "degc", SignalKind::room_temp},
                                                     {"fcu_temp", "degc", SignalKind::fcu_temp},
                                                     {"vav_on", "", SignalKind::vav_on},
                                                     {"fcu_on", "", SignalKind::fcu_on},
                                                     {"power", "kw", SignalKind::power},
                                                     {"damper", "", SignalKind::room_temp},
                                                     {"zone_setpoint", "degc", SignalKind::room_temp},
                                                     {"zone_heating_setpoint", "degc", SignalKind::room_temp}}};

struct KnownPoint {
  const char* name;
  const char* unit;
};
constexpr std::array<KnownPoint, 13> single_points = {{{"mau_temp", "degc"},
                                                       {"outdoor_temp", "degc"},
                                                       {"rain", ""},
                                                       {"setpoint", "degc"},
                                                       {"supply_temp", "degc"},
                                                       {"ahu_on", ""},
                                                       {"occupied", ""},
                                                       {"supply_flow", "m3/s"},
                                                       {"clock_s", "s"},
                                                       {"clock_advance_s", "s"},
                                                       {"heartbeat", ""},
                                                       {"device_heartbeat", ""},
                                                       {"map_fingerprint", ""}}};

}  // namespace

std::optional<PlacedName> placed_name(std::string_view name) {
  for (const PlacedStem& known : placed_stems) {
    const std::string_view stem = known.stem;
    if (!name.starts_with(stem) || name.size() < stem.size() + 2 || name[stem.size()] != '_') continue;
    const char* const begin = name.data() + stem.size() + 1;
    const char* const end = name.data() + name.size();
    int place = 0;
    const auto [rest, error] = std::from_chars(begin, end, place);
    if (error != std::errc{}) continue;
    if (rest == end) return PlacedName{stem, known.counted, place};
    const bool lettered = rest + 1 == end && *rest >= first_sensor && *rest <= last_sensor;
    if (lettered && stem == "room_temp") return PlacedName{stem, known.counted, place, *rest};
  }
  return std::nullopt;
}

std::string sensor_name(int place, char sensor) { return fmt::format("room_temp_{}{}", place, sensor); }

const char* expected_unit(std::string_view name) {
  if (const auto placed = placed_name(name)) {
    for (const PlacedStem& known : placed_stems) {
      if (placed->stem == known.stem) return known.unit;
    }
  }
  for (const KnownPoint& known : single_points) {
    if (name == known.name) return known.unit;
  }
  return nullptr;
}

}  // namespace airside::hal
