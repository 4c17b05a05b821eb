#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <utility>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/adopted/model_index.hpp"
#include "sim/energyplus/epjson_lint.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/options.hpp"
#include "sim/energyplus/protocol.hpp"
#include "sim/energyplus/run_config.hpp"
#include "sim/json/json_file.hpp"
#include "sim/json/merge_patch.hpp"

namespace airside::sim {
namespace {

void expect(bool holds, const char* field, const std::string& found, const char* expected) {
  if (!holds) throw hal::InputError(std::string("EnergyPlus options: ") + field, found, expected, "correct it");
}

bool within(double value, double low, double high) { return std::isfinite(value) && value >= low && value <= high; }

void check_counts(std::size_t rooms, std::size_t fcus, std::size_t powers) {
  expect(rooms >= 1 && rooms <= max_zones, "zones", std::to_string(rooms), "1 to 32 names");
  expect(fcus <= max_zones, "zones with fan coils", std::to_string(fcus), "at most 32 names");
  expect(powers <= max_powers, "powers", std::to_string(powers), "at most 8 meters");
}

void check_loops(const RoomLoopOptions& rooms, const ModelNames& names) {
  const auto number = [](double value) { return std::to_string(value); };
  check_counts(names.interior_zones.size(), names.perimeter_zones.size(), names.powers.size());
  expect(rooms.dampers.size() == names.interior_zones.size(), "dampers", std::to_string(rooms.dampers.size()),
         "one number a VAV zone");
  for (const double damper : rooms.dampers) expect(within(damper, 0, 1), "dampers", number(damper), "0 to 1");
  expect(within(rooms.supply_bias_k, -5, 5), "supply_bias_k", number(rooms.supply_bias_k), "-5 to 5");
  expect(within(rooms.occupancy_scale, 0, 2), "occupancy_scale", number(rooms.occupancy_scale), "0 to 2");
  expect(within(rooms.occupancy_noise, 0, 5), "occupancy_noise", number(rooms.occupancy_noise), "0 to 5");
  expect(within(rooms.occupancy_shift_min, -300, 300), "occupancy_shift_min", number(rooms.occupancy_shift_min),
         "-300 to 300");
  expect(within(rooms.vav_off_per_day, 0, 1), "vav_off_per_day", number(rooms.vav_off_per_day), "0 to 1");
  expect(within(rooms.fcu_band_k, 0, 5), "fcu_band_k", number(rooms.fcu_band_k), "0 to 5");
  expect(within(rooms.fcu_setpoint_degc, 10, 40), "fcu_setpoint_degc", number(rooms.fcu_setpoint_degc), "10 to 40");
}

void check(const EnergyPlusOptions& options) {
  const auto number = [](double value) { return std::to_string(value); };
  expect(options.days >= 1 && options.days <= 364, "days", std::to_string(options.days), "1 to 364");
  expect(options.step_min == 3 || options.step_min == 6, "step_min", std::to_string(options.step_min), "3 or 6");
  expect(within(options.initial_setpoint_degc, 5, 40), "initial_setpoint_degc", number(options.initial_setpoint_degc),
         "5 to 40");
  expect(within(options.weather_change.dry_bulb_offset_k, -15, 15), "dry_bulb_offset_k",
         number(options.weather_change.dry_bulb_offset_k), "-15 to 15");
  expect(within(options.weather_change.solar_factor, 0, 2), "solar_factor", number(options.weather_change.solar_factor),
         "0 to 2");
  expect(within(options.weather_change.storms_per_week, 0, 7), "storms_per_week",
         number(options.weather_change.storms_per_week), "0 to 7");
  start_of_day_2021(options.start_month, options.start_day);
  const RoomLoopOptions& rooms = options.rooms;
  expect(within(rooms.supply_lag_s, 0, 7200), "supply_lag_s", number(rooms.supply_lag_s), "0 to 7200");
  expect(within(rooms.sensor_noise_k, 0, 2), "sensor_noise_k", number(rooms.sensor_noise_k), "0 to 2");
  if (options.own) {
    check_counts(options.own->zones.size(), options.own->fcu_zones.size(), options.own->powers.size());
  } else {
    check_loops(rooms, options.names);
  }
}

/// Replaces time step and run period; what else the model says of its run period stays.
void set_dates(nlohmann::json& model, const EnergyPlusOptions& options) {
  using namespace std::chrono;
  // One day of lead. The engine's own year is a label: 1 January takes 2022, since the year before 2021 is a leap
  // year and the weather files know none.
  const bool new_year = options.start_month == 1 && options.start_day == 1;
  const sys_days first = new_year ? sys_days{year{2022} / January / 1}
                                  : sys_days{days{start_of_day_2021(options.start_month, options.start_day).day()}};
  const year_month_day begin{first - days{lead_s / 86400}}, end{first + days{options.days - 1}};
  nlohmann::json period = nlohmann::json::object();
  if (model.contains("RunPeriod") && !model["RunPeriod"].empty()) period = model["RunPeriod"].begin().value();
  period.erase("day_of_week_for_start_day");
  period["begin_year"] = static_cast<int>(begin.year());
  period["begin_month"] = static_cast<unsigned>(begin.month());
  period["begin_day_of_month"] = static_cast<unsigned>(begin.day());
  period["end_year"] = static_cast<int>(end.year());
  period["end_month"] = static_cast<unsigned>(end.month());
  period["end_day_of_month"] = static_cast<unsigned>(end.day());
  period["use_weather_file_daylight_saving_period"] = "No";
  model["RunPeriod"] = {{"Run Period", period}};
  model["Timestep"] = {{"Time Step", {{"number_of_timesteps_per_hour", 60 / options.step_min}}}};
  nlohmann::json limits = nlohmann::json::object();
  if (options.own && model.contains("ConvergenceLimits") && !model["ConvergenceLimits"].empty())
    limits = model["ConvergenceLimits"].begin().value();
  limits["minimum_system_timestep"] = options.step_min;
  model["ConvergenceLimits"] = {{"Convergence Limits", limits}};
}

/// `#` of a schedule's name replaced by a place.
std::string schedule_at(std::string name, std::size_t place) {
  const std::size_t at = name.find('#');
  return at == std::string::npos ? name : name.replace(at, 1, std::to_string(place));
}

}  // namespace

CivilTime start_of_day_2021(int month, int day) {
  using namespace std::chrono;
  const year_month_day date{year{2021}, std::chrono::month{static_cast<unsigned>(std::clamp(month, 0, 255))},
                            std::chrono::day{static_cast<unsigned>(std::clamp(day, 0, 255))}};
  expect(date.ok(), "start date", "month " + std::to_string(month) + ", day " + std::to_string(day),
         "a date of the year 2021");
  return CivilTime{static_cast<std::int64_t>(sys_days{date}.time_since_epoch().count()) * 86400};
}

namespace {

/// An IDF begins with a comment or its version, whatever the file is called.
bool begins_like_an_idf(const std::filesystem::path& file) {
  std::string word;
  std::ifstream(file) >> word;
  return word.starts_with('!') || engine_case(word).starts_with("VERSION,");
}

}  // namespace

nlohmann::json read_model(const std::filesystem::path& file) {
  const std::string ending = engine_case(file.extension().string());
  if (ending != ".IDF" && ending != ".IMF" && !begins_like_an_idf(file)) return read_json(file);
  const std::filesystem::path converted = std::filesystem::path(file.filename()).replace_extension(".epJSON");
  const std::string engine = have_energyplus() ? (find_energyplus().folder / "energyplus").string() : "energyplus";
  throw hal::InputError(file.string(), "an IDF, the engine's older text format", "the same model in epJSON",
                        "convert it with the engine's own program, \"" + engine + " --convert-only " + file.string() +
                            "\", and give the file " + converted.string() + " that it writes where it runs");
}

std::vector<hal::InputError> missing_names(const nlohmann::json& model, const ModelNames& names,
                                           const std::string& place) {
  std::vector<hal::InputError> missing;
  const ModelIndex has(model);
  const std::string remedy = "rename the model's own to it, or add it as sim/models/twin.epJSON has it";
  const auto need = [&](const char* type, const std::string& name, const char* what) {
    if (has.object(type, name)) return;
    missing.emplace_back(place + ": " + type, "no '" + name + "'", std::string("it, ") + what, remedy);
  };
  const auto need_each = [&](const std::string& schedule, std::size_t count, const char* what) {
    for (std::size_t i = 1; i <= count; ++i) need("Schedule:Constant", schedule_at(schedule, i), what);
  };
  const std::size_t vavs = names.interior_zones.size(), fcus = names.perimeter_zones.size();
  for (const std::string& zone : names.interior_zones) need("Zone", zone, "the zone of a VAV box");
  for (const std::string& zone : names.perimeter_zones) need("Zone", zone, "the zone of a fan coil unit");
  need("Schedule:Constant", names.supply_setpoint_schedule, "the schedule that holds the supply-air setpoint");
  need_each(names.vav_on_schedule, vavs, "a schedule that switches a VAV box");
  need_each(names.vav_damper_schedule, vavs, "a schedule that sets a damper");
  need_each(names.fcu_on_schedule, fcus, "a schedule that switches a fan coil unit");
  need_each(names.interior_occupancy_schedule, vavs, "a schedule of people");
  need_each(names.perimeter_occupancy_schedule, fcus, "a schedule of people");
  for (const std::string& node : {names.supply_air_node, names.mau_outlet_node}) {
    if (has.text(node)) continue;
    missing.emplace_back(place + ": nodes", "no object that names the node '" + node + "'",
                         "a node of the AHU's air loop, whose temperature is read", remedy);
  }
  return missing;
}

nlohmann::json compose_model(const EnergyPlusOptions& options, const std::filesystem::path& schema) {
  check(options);
  const std::filesystem::path file = options.model.empty() ? find_models() / "twin.epJSON" : options.model;
  nlohmann::json model = read_model(file);
  std::string place = file.string();
  for (const auto& patch : options.patches) {
    if (options.lint) lint_epjson(patch.content, schema, {patch.name, LintScope::patch});
    model = merge_patched(std::move(model), patch.content, patch.name);
    place += " + " + patch.name;
  }
  if (options.own && model.is_object()) prepare_own_model(model, place);
  if (!model.is_object()) model = merge_patched(std::move(model), nlohmann::json::object(), place);
  set_dates(model, options);
  if (options.lint) lint_epjson(model, schema, {place, LintScope::whole});
  return model;
}

}  // namespace airside::sim
