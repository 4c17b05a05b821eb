#include "sim/scenarios/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "hal/text/input_error.hpp"

namespace airside::sim {

namespace {

constexpr const char* august = "2021-08-01";

void irregular_people(RcRoom& room) {
  room.occupancy_day_sd = 0.30;
  room.occupancy_zone_sd = 0.40;
  room.occupancy_noise_sd = 0.40;
  room.arrival_sd_min = 45;
  room.occupancy_absent_share = 0.15;
}

void crowded(RcRoom& room) {
  room.gain_occupied_w_m2 *= 2;
  room.occupancy_zone_sd = 0.30;
}

void many_outages(RcRoom& room) { room.vav_off_per_day = 1; }

void small_coil(RcRoom& room) { room.coil_capacity_kw *= 0.6; }

void boxes_that_modulate(RcRoom& room) { room.vav_modulation_per_k = 0.35; }

void much_glass(RcRoom& room) {
  for (auto* side : {&room.window_north_m2, &room.window_east_m2, &room.window_south_m2, &room.window_west_m2})
    for (double& m2 : *side) m2 *= 2.5;
}

void open_doors(RcRoom& room) {
  room.door_ach.assign(static_cast<std::size_t>(room.zones()), 3.0);
  room.door_days_share = 0.8;
}

void slow_air(RcRoom& room) {
  room.supply_lag_s = 900;
  room.duct_lag_s = 600;
}

void no_fan_coils(RcRoom& room) { room.fcu_forced.assign(static_cast<std::size_t>(room.fcus), -1); }

constexpr auto all = std::to_array<Scenario>({
    {.name = "summer", .text = "August, as in the tables of docs/results.md", .start = august},
    {.name = "april", .text = "spring: cool nights, mild days", .start = "2021-04-01"},
    {.name = "october", .text = "autumn: cool nights, mild days", .start = "2021-10-15"},
    {.name = "january", .text = "winter: supply air at its warmest is often too cold", .start = "2021-01-10"},
    {.name = "weekends", .text = "Saturday and Sunday nearly empty", .start = august, .weekends = true},
    {.name = "irregular",
     .text = "people come when they like: three times the spread of days, zones and minutes",
     .start = august,
     .change_room = irregular_people,
     .change_engine = [](EnergyPlusOptions& o) { o.rooms.occupancy_noise = 3; }},
    {.name = "crowded",
     .text = "twice the people",
     .start = august,
     .change_room = crowded,
     .change_engine = [](EnergyPlusOptions& o) { o.rooms.occupancy_scale *= 1.6; }},
    {.name = "outages",
     .text = "each VAV box closes once a day for half an hour to one and a half",
     .start = august,
     .change_room = many_outages,
     .change_engine = [](EnergyPlusOptions& o) { o.rooms.vav_off_per_day = 1; }},
    {.name = "storms",
     .text = "an afternoon storm on five days a week",
     .start = august,
     .change_engine = [](EnergyPlusOptions& o) { o.weather_change.storms_per_week = 5; },
     .on_rc = false},
    {.name = "setback",
     .text = "the AHU rests from 20:00 to 06:00",
     .start = august,
     .fan_start_h = 6,
     .fan_stop_h = 20,
     .on_energyplus = false},
    {.name = "small-coil",
     .text = "the AHU's coil has 0.6 of its capacity",
     .start = august,
     .change_room = small_coil,
     .on_energyplus = false},
    {.name = "modulating",
     .text = "boxes open with the room's temperature",
     .start = august,
     .change_room = boxes_that_modulate,
     .on_energyplus = false},
    {.name = "glass",
     .text = "two and a half times the windows",
     .start = august,
     .change_room = much_glass,
     .on_energyplus = false},
    {.name = "doors",
     .text = "doors to the outside stand open some hours on most days",
     .start = august,
     .change_room = open_doors,
     .on_energyplus = false},
    {.name = "slow-air",
     .text = "supply air takes 15 min to follow its setpoint, and 10 min through the duct",
     .start = august,
     .change_room = slow_air,
     .on_energyplus = false},
    {.name = "no-fan-coils",
     .text = "the fan coil units stand still",
     .start = august,
     .change_room = no_fan_coils,
     .on_energyplus = false},
});

}  // namespace

std::span<const Scenario> scenarios() { return all; }

const Scenario& scenario(const std::string& option, const std::string& name) {
  const auto found = std::ranges::find(all, name, &Scenario::name);
  if (found != all.end()) return *found;
  std::vector<std::string_view> names;
  for (const Scenario& s : all) names.push_back(s.name);
  throw hal::InputError(option, '"' + name + '"', fmt::format("one of {}", fmt::join(names, ", ")),
                        "choose a name from the list");
}

}  // namespace airside::sim
