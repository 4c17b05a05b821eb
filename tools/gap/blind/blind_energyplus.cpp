#include "tools/gap/blind/blind_energyplus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "sim/energyplus/differing/other_numbers.hpp"
#include "sim/energyplus/differing/other_objects.hpp"
#include "sim/energyplus/plant.hpp"
#include "sim/energyplus/replay/replay.hpp"
#include "sim/json/merge_patch.hpp"
#include "sim/stateless_draw.hpp"
#include "tools/gap/blind/test_commands.hpp"

namespace airside::tools::gap {

namespace {

using Json = nlohmann::json;

enum BuiltDraw : std::uint64_t { draw_power_noise = 731, draw_door, draw_box_off, draw_fan_coil, draw_mau };

constexpr double power_noise_share = 0.01;

/// The merge patch that makes `target` of `base`.
Json patch_between(const Json& base, const Json& target) {
  if (!base.is_object() || !target.is_object()) return target;
  Json patch = Json::object();
  for (const auto& [key, value] : base.items()) {
    if (!target.contains(key)) patch[key] = nullptr;
  }
  for (const auto& [key, value] : target.items()) {
    if (!base.contains(key))
      patch[key] = value;
    else if (base[key] != value)
      patch[key] = patch_between(base[key], value);
  }
  return patch;
}

Json compact_schedule(Json data) {
  Json fields = Json::array();
  for (auto& item : data) fields.push_back({{"field", item}});
  return {{"schedule_type_limits_name", "Any Number"}, {"data", fields}};
}

/// On some days a door stands open for 2 to 6 h of the day.
Json door_schedule(std::uint64_t seed) {
  constexpr int month_days[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  Json data = Json::array();
  std::int64_t day = 0;
  for (int month = 1; month <= 12; ++month) {
    for (int date = 1; date <= month_days[month - 1]; ++date, ++day) {
      data.push_back(fmt::format("Through: {}/{}", month, date));
      data.push_back("For: AllDays");
      if (sim::draw_uniform(seed, draw_door, 0, day) < 0.45) {
        // Minutes that are multiples of the engine's step.
        const int from = 8 * 60 + 6 * static_cast<int>(50 * sim::draw_uniform(seed, draw_door, 1, day));
        const int to = from + 120 + 6 * static_cast<int>(40 * sim::draw_uniform(seed, draw_door, 2, day));
        data.push_back(fmt::format("Until: {:02}:{:02}", from / 60, from % 60));
        data.push_back(0);
        data.push_back(fmt::format("Until: {:02}:{:02}", to / 60, to % 60));
        data.push_back(1);
      }
      data.push_back("Until: 24:00");
      data.push_back(0);
    }
  }
  return compact_schedule(std::move(data));
}

/// 25 min of every 70 between 20:30 and 5:15.
Json heater_schedule() {
  Json data = {"Through: 12/31", "For: AllDays"};
  const auto until = [&data](int minute, int value) {
    data.push_back(fmt::format("Until: {:02}:{:02}", minute / 60, minute % 60));
    data.push_back(value);
  };
  for (const auto& [from, to] : {std::pair(48, 72), std::pair(117, 141), std::pair(186, 213), std::pair(258, 282),
                                 std::pair(1233, 1257), std::pair(1302, 1329), std::pair(1374, 1398)}) {
    until(from, 0);
    until(to, 1);
  }
  until(1440, 0);
  return compact_schedule(std::move(data));
}

std::string placed(std::string pattern, int place) {
  const auto mark = pattern.find('#');
  if (mark != std::string::npos) pattern.replace(mark, 1, std::to_string(place + 1));
  return pattern;
}

/// Days of the engine in which `on` holds by a clock that runs ahead.
Json schedule_of(const std::function<bool(CivilTime)>& on, CivilTime begin, CivilTime to, std::int64_t ahead_s) {
  Json data = Json::array();
  for (CivilTime day = begin; day < to; day.seconds += seconds_per_day) {
    const std::string date = sim::text_of(day);
    data.push_back(fmt::format("Through: {}/{}", std::stoi(date.substr(5, 2)), std::stoi(date.substr(8, 2))));
    data.push_back("For: AllDays");
    for (int row = 0; row < rows_per_day; ++row) {
      const bool now = on({day.seconds + row * row_s + ahead_s});
      if (row + 1 < rows_per_day && on({day.seconds + (row + 1) * row_s + ahead_s}) == now) continue;
      const int minute = (row + 1) * static_cast<int>(row_s / 60);
      data.push_back(fmt::format("Until: {:02}:{:02}", minute / 60, minute % 60));
      data.push_back(now ? 1 : 0);
    }
  }
  for (const char* rest : {"Through: 12/31", "For: AllDays", "Until: 24:00"}) data.push_back(rest);
  data.push_back(1);
  return compact_schedule(std::move(data));
}

/// Objects that would follow the plant's schedule follow the window's instead; what is stuck stays so.
void follow(Json& model, const char* type, const std::string& name, const std::string& plant, const Json& schedule) {
  Json& followed = model[type][name]["availability_schedule_name"];
  if (followed != plant) return;
  followed = "Built " + plant;
  model["Schedule:Compact"]["Built " + plant] = schedule;
}

/// Whether a test, else the window, has the box open.
bool box_on(const MeasuredRun& run, int vav, CivilTime t) {
  const std::optional<bool> tested = run.tests ? run.tests->box(vav, t) : std::nullopt;
  return tested.value_or(WindowCommands(run).box_on(vav, t));
}

bool fan_coil_on(const MeasuredRun& run, int fcu, CivilTime t) {
  const std::optional<bool> tested = run.tests ? run.tests->fan_coil(fcu, t) : std::nullopt;
  return tested.value_or(WindowCommands(run).fan_coil_on(fcu, t));
}

void follow_window(Json& model, const sim::ModelNames& names, const MeasuredRun& run, CivilTime begin, CivilTime to,
                   std::int64_t ahead_s) {
  for (int v = 0; v < std::ssize(names.interior_zones); ++v) {
    const Json schedule = schedule_of([&](CivilTime t) { return box_on(run, v, t); }, begin, to, ahead_s);
    follow(model, "AirTerminal:SingleDuct:VAV:NoReheat", names.interior_zones[static_cast<std::size_t>(v)] + " VAV",
           placed(names.vav_on_schedule, v), schedule);
  }
  for (int f = 0; !run.feedback && f < std::ssize(names.perimeter_zones); ++f) {
    const Json schedule = schedule_of([&](CivilTime t) { return fan_coil_on(run, f, t); }, begin, to, ahead_s);
    const std::string zone = names.perimeter_zones[static_cast<std::size_t>(f)];
    const std::string plant = placed(names.fcu_on_schedule, f);
    follow(model, "ZoneHVAC:FourPipeFanCoil", zone + " Fan Coil", plant, schedule);
    follow(model, "Fan:SystemModel", zone + " Supply Fan", plant, schedule);
  }
}

/// No make-up air unit holds its setpoint: its outlet wanders by as much as the RC rooms' does.
void wander_mau(Json& model, std::uint64_t seed, CivilTime begin, CivilTime to) {
  constexpr double sd_k = 0.35, memory_s = 2700;
  constexpr int step_min = 12;
  const char* schedule = "MAU Setpoint";
  if (!model["Schedule:Constant"].contains(schedule)) return;
  const double usual = model["Schedule:Constant"][schedule].value("hourly_value", 0.0);
  const Json limits = model["Schedule:Constant"][schedule].value("schedule_type_limits_name", Json("Any Number"));
  model["Schedule:Constant"].erase(schedule);
  Json data = Json::array();
  for (CivilTime day = begin; day < to; day.seconds += seconds_per_day) {
    const std::string date = sim::text_of(day);
    data.push_back(fmt::format("Through: {}/{}", std::stoi(date.substr(5, 2)), std::stoi(date.substr(8, 2))));
    data.push_back("For: AllDays");
    for (int minute = step_min; minute <= 24 * 60; minute += step_min) {
      data.push_back(fmt::format("Until: {:02}:{:02}", minute / 60, minute % 60));
      const double now_s = static_cast<double>(day.seconds) + 60.0 * minute;
      data.push_back(std::round(100 * (usual + sd_k * sim::draw_course(seed, draw_mau, 0, now_s, memory_s))) / 100);
    }
  }
  for (const char* rest : {"Through: 12/31", "For: AllDays", "Until: 24:00"}) data.push_back(rest);
  data.push_back(usual);
  model["Schedule:Compact"][schedule] = compact_schedule(std::move(data));
  model["Schedule:Compact"][schedule]["schedule_type_limits_name"] = limits;
}

/// The engine takes the sun's path as constant for 20 days or to the end of its run, whichever comes first, as its mean
/// over them. A run that lasts longer has the path of the shorter one in the days of both, if that is at most 20 days.
void keep_sun_of(Json& model, int days_of_shorter_run) {
  constexpr int usual_days = 20;
  model["ShadowCalculation"]["Built Sun"] = {
      {"shading_calculation_update_frequency", std::min(usual_days, days_of_shorter_run)}};
}

std::string zone_at(const sim::ModelNames& names, int place) {
  const int interior = static_cast<int>(names.interior_zones.size());
  return place < interior ? names.interior_zones.at(static_cast<std::size_t>(place))
                          : names.perimeter_zones.at(static_cast<std::size_t>(place - interior));
}

bool hide_outside(EnergyPlusRoom& room, const Hidden& h, std::uint64_t seed) {
  Json& model = room.hidden;
  const double m = h.magnitude;
  if (h.effect == "fcu_dial") {
    room.options.rooms.fcu_setpoint_degc += m;
  } else if (h.effect == "odd_heater") {
    model["Schedule:Compact"]["Built Heater Clock"] = heater_schedule();
    model["OtherEquipment"]["Built Heater"] = {
        {"fuel_type", "None"},
        {"zone_or_zonelist_or_space_or_spacelist_name", zone_at(room.options.names, h.place)},
        {"schedule_name", "Built Heater Clock"},
        {"design_level_calculation_method", "EquipmentLevel"},
        {"design_level", m},
        {"fraction_radiant", 0.3}};
  } else if (h.effect == "escape_door") {
    model["Schedule:Compact"]["Built Door"] = door_schedule(seed);
    model["ZoneVentilation:DesignFlowRate"]["Built Door"] = {
        {"zone_or_zonelist_or_space_or_spacelist_name", zone_at(room.options.names, h.place)},
        {"schedule_name", "Built Door"},
        {"design_flow_rate_calculation_method", "AirChanges/Hour"},
        {"air_changes_per_hour", m},
        {"ventilation_type", "Natural"}};
  } else if (h.effect == "ahu_time_switch") {
    const int until = 90 + 3 * static_cast<int>(std::lround(20 * m));
    model["Schedule:Constant"].erase("AHU On");
    model["Schedule:Compact"]["AHU On"] =
        compact_schedule({"Through: 12/31", "For: AllDays", "Until: 01:30", 1,
                          fmt::format("Until: {:02}:{:02}", until / 60, until % 60), 0, "Until: 24:00", 1});
  } else if (h.effect == "hot_gas_bypass") {
    sim::each_object(model, "Chiller:Electric:EIR",
                     [m](const auto&, Json& chiller) { chiller["minimum_unloading_ratio"] = m; });
  } else {
    return false;
  }
  return true;
}

/// A box or fan coil that does not do what is recorded follows a schedule that nobody commands.
void hide_command(EnergyPlusRoom& room, const sim::EffectOp& op, int place, double m) {
  const bool runs = m >= 0.5;
  if ((op.by == sim::By::raise && !runs) || (op.by == sim::By::multiply && runs)) return;
  const char* schedule = runs ? "Always On" : "Always Off";
  const sim::ModelNames& names = room.options.names;
  if (op.field == "fcu_on") {
    const std::string zone = names.perimeter_zones.at(static_cast<std::size_t>(place));
    room.hidden["ZoneHVAC:FourPipeFanCoil"][zone + " Fan Coil"]["availability_schedule_name"] = schedule;
    room.hidden["Fan:SystemModel"][zone + " Supply Fan"]["availability_schedule_name"] = schedule;
  } else if (op.field == "vav_on") {
    const std::string zone = names.interior_zones.at(static_cast<std::size_t>(place));
    room.hidden["AirTerminal:SingleDuct:VAV:NoReheat"][zone + " VAV"]["availability_schedule_name"] = schedule;
  }
}

void hide_common(EnergyPlusRoom& room, const sim::EffectChange& change) {
  for (const sim::EffectOp& op : change.at.effect->common) {
    const double m = op.offset + op.factor * change.magnitude;
    switch (op.on) {
      case sim::EffectOp::On::sensor: room.sensors.push_back(change); return;
      case sim::EffectOp::On::clock: room.clock_ahead_h += m; break;
      case sim::EffectOp::On::command: hide_command(room, op, change.at.place, m); break;
      case sim::EffectOp::On::weather:
        if (op.field == "solar") room.options.weather_change.solar_factor *= m;
        if (op.field == "outdoor_temp") room.outdoor_shown_k -= m;  // the change makes the truth of what is shown
        break;
      default: break;
    }
  }
}

}  // namespace

EnergyPlusRoom energyplus_measured_room(const std::string& twin, std::uint64_t seed, bool feedback) {
  EnergyPlusRoom room;
  room.options = sim::energyplus_room(twin);
  room.options.name = "built room " + twin;
  room.seed = seed;
  room.twin = room.nominal = sim::twin_of(room.options).model;
  sim::perturb_numbers(room.nominal, seed);
  const sim::WeatherChange weather = sim::perturb_loops(room.options.rooms, seed);
  room.options.weather_change.dry_bulb_offset_k = weather.dry_bulb_offset_k;
  room.options.weather_change.solar_factor = weather.solar_factor;
  room.hidden = room.nominal;
  if (feedback) room.modulation_per_k = sim::modulation_of(seed);
  return room;
}

bool energyplus_can_hide(const sim::Effect& effect) {
  const auto beyond_us = [](const sim::EffectOp& op) {
    return op.on == sim::EffectOp::On::weather && op.field != "solar" && op.field != "outdoor_temp";
  };
  return effect.candidate && effect.on_energyplus && (!effect.energyplus.empty() || !effect.common.empty()) &&
         std::none_of(effect.common.begin(), effect.common.end(), beyond_us);
}

EnergyPlusRoom hide(EnergyPlusRoom room, const std::vector<Hidden>& hidden, const std::vector<sim::Effect>& effects,
                    std::uint64_t seed) {
  for (const Hidden& h : hidden) {
    const sim::Effect* effect = find_effect(effects, h.effect);
    if (effect == nullptr) {
      if (!hide_outside(room, h, seed)) throw std::invalid_argument("cannot hide " + h.effect);
      continue;
    }
    if (!energyplus_can_hide(*effect)) throw std::invalid_argument("cannot hide " + h.effect);
    const sim::EffectChange change{{effect, h.place}, h.magnitude};
    const auto one = std::span(&change, 1);
    room.hidden = sim::merge_patched(room.hidden, sim::model_patch(room.hidden, room.options.names, one), h.effect);
    room.options.rooms = sim::changed_loops(room.options.rooms, one);
    hide_common(room, change);
  }
  return room;
}

bool WindowCommands::box_on(int vav, CivilTime t) const {
  const auto lot = [&](std::int64_t what) {
    return sim::draw_uniform(seed_, draw_box_off, static_cast<std::uint64_t>(vav), 3 * t.day() + what);
  };
  if (lot(0) >= 0.1) return true;
  const int from = 8 * 60 + 6 * static_cast<int>(90 * lot(1)), minutes = 36 + 6 * static_cast<int>(10 * lot(2));
  return t.minute_of_day() < from || t.minute_of_day() >= from + minutes;
}

bool WindowCommands::fan_coil_on(int fcu, CivilTime t) const {
  const int hour = t.minute_of_day() / 60;
  return hour >= 7 && hour < 20 &&
         sim::draw_uniform(seed_, draw_fan_coil, static_cast<std::uint64_t>(fcu), 24 * t.day() + hour) < 0.54;
}

nlohmann::json built_model(const EnergyPlusRoom& room, sim::RoomLoopOptions& loops) {
  return sim::other_objects(room.hidden, room.nominal, room.options.names, loops, {room.seed, room.modulation_per_k});
}

std::vector<hal::LogRow> measure(const EnergyPlusRoom& room, const std::filesystem::path& weather,
                                 const MeasuredRun& run) {
  // A clock that runs ahead shows what was there before; rows stay on the log's grid.
  const std::int64_t ahead_s = row_s * std::llround(3600 * room.clock_ahead_h / row_s);
  const CivilTime from{run.start.seconds - ahead_s}, to{from.seconds + run.days * seconds_per_day};
  const CivilTime begin{(from.day() - measured_lead_days) * seconds_per_day};
  const auto days_to = [&](int logged) {
    return static_cast<int>((from.seconds + logged * seconds_per_day - 1) / seconds_per_day - begin.day()) + 1;
  };
  sim::EnergyPlusOptions options = room.options;
  options.weather = weather;
  options.seed = sim::draw_bits(room.seed, sim::draw_built, 999, static_cast<std::int64_t>(run.seed)) >> 16;
  options.rooms.vav_off_per_day = 0;  // the window's commands say when
  const int fcus = static_cast<int>(options.names.perimeter_zones.size());
  if (run.tests && run.feedback) options.rooms.switched = switched_by_tests(*run.tests, fcus, ahead_s);
  Json built = built_model(room, options.rooms);
  follow_window(built, options.names, run, begin, to, ahead_s);
  wander_mau(built, run.seed, begin, to);
  constexpr int plant_lead_days = 1;
  if (run.passive_days > 0) keep_sun_of(built, plant_lead_days + days_to(run.passive_days));
  options.patches.push_back({"built room", patch_between(room.twin, built)});
  options.days = days_to(run.days);
  const std::string date = sim::text_of(begin);
  options.start_month = std::stoi(date.substr(5, 2));
  options.start_day = std::stoi(date.substr(8, 2));
  options.initial_setpoint_degc = 23;

  sim::EnergyPlusPlant plant(options);
  MeasuredOperator operated(run);
  WrongSensors wrong(room.sensors, run.start);
  std::vector<hal::LogRow> rows;
  double setpoint = 23;
  while (plant.time() < to) {
    const CivilTime t{plant.time().seconds + ahead_s};  // by the log's clock
    sim::Sensors shown = plant.sensors();
    for (std::size_t p = 0; p < shown.power_kw.size(); ++p) {
      const double noise = power_noise_share * sim::draw_normal(run.seed, draw_power_noise, p, t.seconds);
      shown.power_kw[p] = std::round(100 * std::max(0.0, shown.power_kw[p] * (1 + noise))) / 100;
    }
    shown.outdoor_temp_degc = std::round(100 * (shown.outdoor_temp_degc + room.outdoor_shown_k)) / 100;
    wrong.apply(shown, t);
    if (default_cycle.starts(t)) {
      const double usual = operated.setpoint_degc(t, shown.room_temp_degc);
      setpoint = run.tests ? run.tests->setpoint_degc(t, usual, setpoint) : usual;
      plant.set_setpoint(setpoint);
    }
    plant.advance_to({t.seconds - ahead_s + row_s / 2});
    // Commands are logged as they hold from now on.
    shown.fcu_on = plant.sensors().fcu_on;
    for (int v = 0; v < std::ssize(shown.vav_on); ++v)
      shown.vav_on[static_cast<std::size_t>(v)] = box_on(run, v, t) ? 1 : 0;
    for (int f = 0; !run.feedback && f < std::ssize(shown.fcu_on); ++f)
      shown.fcu_on[static_cast<std::size_t>(f)] = fan_coil_on(run, f, t) ? 1 : 0;
    plant.advance_to({t.seconds - ahead_s + row_s});
    if (!(t < run.start)) rows.push_back(measured_row(shown, t, setpoint, run));
  }
  return rows;
}

}  // namespace airside::tools::gap
