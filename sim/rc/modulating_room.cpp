#include "sim/rc/modulating_room.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"
#include "sim/stateless_draw.hpp"

namespace airside::sim {
namespace {

constexpr double usual_boxes = 8;  // of the fan, the coil and the ventilation as ModulatingAir has them
constexpr std::string_view name_stem = "modulating-";
constexpr std::uint64_t modulating_stream = 171;

/// Glass by place: core, south, east, north, west, in turn.
void place_windows(RcRoom& room, std::size_t boxes) {
  for (std::size_t z = 0; z < boxes; ++z) {
    room.window_south_m2[z] = room.window_east_m2[z] = room.window_north_m2[z] = room.window_west_m2[z] = 0;
    room.wall_area_m2[z] = z % 5 == 0 ? 0 : 14;
    room.wall_ua_w_k[z] = z % 5 == 0 ? 0 : 10;
    room.infiltration_share[z] = z % 5 == 0 ? 0.1 : 0.8;
    switch (z % 5) {
      case 1: room.window_south_m2[z] = 8; break;
      case 2: room.window_east_m2[z] = 7; break;
      case 3: room.window_north_m2[z] = 8; break;
      case 4: room.window_west_m2[z] = 7; break;
      default: break;
    }
  }
  room.window_u_w_m2k = 1.8;
  room.mixing_interior_m3_s = 0.03;
  room.neighbour_temp_degc = 23.5;
  room.gain_base_w_m2 = 6;
  room.gain_occupied_w_m2 = 18;
  room.vav_off_per_day = 0;
}

Climate temperate() {
  Climate c;
  c.location = {"synthetic temperate site", 41.9, -87.6, -6.0, 190.0};
  c.mean_temp_degc = 13.0;
  c.seasonal_swing_k = 11.0;
  c.daily_swing_k = 5.5;
  c.day_temp_sd_k = 3.0;
  return c;
}

void spread_boxes(ModulatingRoom& room, std::uint64_t seed) {
  std::uint64_t place = 0;
  const auto draw = [&](double width) {
    const double sign = seed == 0 ? 0.0 : 2 * draw_uniform(seed, modulating_stream, place++, 0) - 1;
    return 1 + width * sign;
  };
  ModulatingAir& air = room.air;
  for (std::size_t z = 0; z < air.flow_max_m3_s.size(); ++z) {
    room.building.gain_factor[z] *= draw(0.25);
    air.flow_max_m3_s[z] *= draw(0.15);
    air.cooling_degc[z] += 0.5 * (draw(1.0) - 1);
    air.heating_degc[z] += 0.5 * (draw(1.0) - 1);
  }
  air.fan_kw *= draw(0.25);
  air.chiller_cop *= draw(0.15);
  air.outdoor_min_m3_s *= draw(0.2);
  room.building.gain_occupied_w_m2 *= draw(0.15);
  room.building.capacity_factor *= draw(0.2);
  room.building.seed = seed;
}

}  // namespace

std::vector<std::string_view> modulating_scenarios() { return {"humid", "mild", "reheat", "duct"}; }

std::optional<ModulatingName> modulating_name(std::string_view room) {
  if (!room.starts_with(name_stem)) return std::nullopt;
  const std::string_view rest = room.substr(name_stem.size());
  const std::size_t dash = std::min(rest.find('-'), rest.size());
  ModulatingName name{std::string(rest.substr(0, dash)), 0};
  const std::string_view digits = rest.substr(std::min(dash + 1, rest.size()));
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), name.seed);
  const bool whole = error == std::errc{} && end == digits.data() + digits.size() && name.seed > 0;
  const std::vector<std::string_view> known = modulating_scenarios();
  if (std::ranges::find(known, name.scenario) == known.end() || (dash < rest.size() && !whole)) {
    throw hal::InputError("room", "\"" + std::string(room) + "\"",
                          "modulating-humid, -mild, -reheat or -duct, with -1, -2, ... for other buildings of a kind",
                          "correct the name");
  }
  return name;
}

ModulatingRoom modulating_room(std::string_view scenario, std::uint64_t seed, int boxes, int powers) {
  if (boxes < 1 || boxes > 64 || powers < 0 || powers > 3) {
    throw hal::InputError("room", std::to_string(boxes) + " boxes that modulate, " + std::to_string(powers) + " meters",
                          "1 to 64 boxes; 0 to 3 meters: of all, of fan and the rest, or of fan, cooling and heat",
                          "choose another topology for the site");
  }
  const auto zones = static_cast<std::size_t>(boxes);
  const double size = boxes / usual_boxes;
  ModulatingRoom room;
  room.name = std::string(name_stem) + std::string(scenario) + (seed == 0 ? "" : "-" + std::to_string(seed));
  room.building = make_room(boxes, 0, powers);
  place_windows(room.building, zones);
  ModulatingAir& air = room.air;
  air.flow_max_m3_s.assign(zones, 0.21);
  air.flow_min_share.assign(zones, 0.15);
  air.cooling_degc.assign(zones, 24.0);
  air.heating_degc.assign(zones, 21.0);
  air.reheat_kw.assign(zones, 0.0);
  for (std::size_t z = 0; z < zones; ++z) air.flow_max_m3_s[z] *= z % 5 == 0 ? 0.85 : z % 5 == 3 ? 0.95 : 1.15;
  if (scenario == "humid") {
    air.economizer = false;
    air.outdoor_min_m3_s = 0.2;
  } else if (scenario == "mild") {
    room.climate = temperate();
    air.reheat_kw.assign(zones, 2.0);
  } else if (scenario == "reheat") {
    room.climate = temperate();
    air.flow_min_share.assign(zones, 0.4);
    air.reheat_kw.assign(zones, 2.5);
  } else if (scenario == "duct") {
    room.climate = temperate();
    air.reheat_kw.assign(zones, 2.0);
    air.fan_kw = 4.5;
    air.static_share = 0.6;
  } else {
    throw hal::InputError("room", "\"" + std::string(scenario) + "\"", "humid, mild, reheat or duct",
                          "name one of these scenarios");
  }
  for (double* part : {&air.fan_kw, &air.outdoor_min_m3_s, &air.coil_capacity_kw, &air.pump_kw}) *part *= size;
  spread_boxes(room, seed);
  room.building.name = room.name;
  return room;
}

}  // namespace airside::sim
