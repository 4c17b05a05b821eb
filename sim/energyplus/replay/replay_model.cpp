#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/replay/own_outputs.hpp"
#include "sim/energyplus/replay/replay_files.hpp"

namespace airside::sim {
namespace {

using nlohmann::json;

constexpr const char* ems = "EnergyManagementSystem:";

/// The one object of a group that has at most one, made if absent.
json& only_object(json& model, const char* group, const char* name) {
  json& objects = model[group];
  if (!objects.is_object() || objects.empty()) objects = {{name, json::object()}};
  return objects.begin().value();
}

std::string fcu_schedule(const ModelNames& names, std::size_t place) {
  std::string name = names.fcu_on_schedule;
  if (const auto mark = name.find('#'); mark != std::string::npos) name.replace(mark, 1, std::to_string(place));
  return name;
}

[[noreturn]] void refuse_schedule(const std::string& name) {
  throw hal::InputError("EnergyPlus replay", "no Schedule:Constant named '" + name + "' in the model",
                        "the schedules that a replay commands", "compare the model with ModelNames");
}

/// "Run period", time steps and what is simulated; what else the model says of them stays.
void set_replay_dates(json& model, const ReplayDays& days, bool own) {
  const std::int64_t year_s = civil_midnight(days.year, 1, 1).seconds;
  const CivilTime first{year_s + static_cast<std::int64_t>(days.first_step) * days.step_s};
  const std::string begin = text_of(first), end = text_of({first.seconds + (days.days - 1) * 86400LL});
  json& period = only_object(model, "RunPeriod", "Run Period");
  period.erase("day_of_week_for_start_day");
  for (const auto& [date, which] : {std::pair(begin, "begin"), std::pair(end, "end")}) {
    period[std::string(which) + "_year"] = std::stoi(date.substr(0, 4));
    period[std::string(which) + "_month"] = std::stoi(date.substr(5, 2));
    period[std::string(which) + "_day_of_month"] = std::stoi(date.substr(8, 2));
  }
  period["use_weather_file_daylight_saving_period"] = "No";
  period["use_weather_file_rain_indicators"] = "Yes";
  model["RunPeriod"] = {{"Run Period", json(period)}};
  model["Timestep"] = {{"Time Step", {{"number_of_timesteps_per_hour", 3600 / days.step_s}}}};
  json& limits = only_object(model, "ConvergenceLimits", "Convergence Limits");
  if (!own) limits = json::object();
  limits["minimum_system_timestep"] = days.step_s / 60;
  model["ConvergenceLimits"] = {{"Convergence Limits", json(limits)}};
  only_object(model, "Building", "Building")["minimum_number_of_warmup_days"] = 1;
  json& control = only_object(model, "SimulationControl", "Simulation Control");
  control["run_simulation_for_sizing_periods"] = "No";
  control["run_simulation_for_weather_file_run_periods"] = "Yes";
}

/// The table's outputs, the weather as the engine saw it, and no others: they would only cost time.
void set_replay_outputs(json& model, const EnergyPlusTwin& twin, bool thermostats) {
  const ModelNames& names = twin.names;
  for (auto it = model.begin(); it != model.end();) it = it.key().starts_with("Output:") ? model.erase(it) : ++it;
  json& variables = model["Output:Variable"] = json::object();
  const auto add = [&variables](const std::string& key, const char* variable) {
    variables[fmt::format("Replay {:02}", variables.size() + 1)] = {
        {"key_value", key}, {"variable_name", variable}, {"reporting_frequency", "Timestep"}};
  };
  json& meters = model["Output:Meter"] = json::object();
  const auto meter = [&meters](const std::string& name) {
    meters["Replay " + name] = {{"key_name", name}, {"reporting_frequency", "Timestep"}};
  };
  if (twin.own) {
    for (const ChannelOutput& output : own_outputs(twin)) {
      if (output.kind == ChannelOutput::Kind::meter)
        meter(output.key);
      else
        add(output.key, output.variable.c_str());
    }
  } else {
    for (const auto& zone : names.interior_zones) add(zone, "Zone Mean Air Temperature");
    for (const auto& zone : names.perimeter_zones) add(zone, "Zone Mean Air Temperature");
    add(names.supply_air_node, "System Node Temperature");
    add(names.mau_outlet_node, "System Node Temperature");
    for (const char* name : {"Electricity:HVAC", "Electricity:Plant"}) meter(name);
  }
  add("Environment", "Site Outdoor Air Drybulb Temperature");
  add("Environment", "Site Rain Status");
  add("Environment", "Site Direct Solar Radiation Rate per Area");
  add("Environment", "Site Diffuse Solar Radiation Rate per Area");
  for (std::size_t i = 1; thermostats && i <= names.perimeter_zones.size(); ++i)
    add(fcu_schedule(names, i), "Schedule Value");
  const bool named = model.contains("OutputControl:Files") && !model["OutputControl:Files"].empty();
  json& files = only_object(model, "OutputControl:Files", "Output Files");
  if (!named) {
    for (const char* file : {"csv", "mtr", "eio", "tabular", "sqlite", "json", "audit", "bnd", "rdd", "mdd", "mtd",
                             "shd", "dxf", "zone_sizing", "system_sizing"})
      files[std::string("output_") + file] = "No";
  }
  files["output_eso"] = "Yes";
}

/// Heat of unknown origin, two objects a zone that has columns for it: 1 kW into the air and 1 kW out of it, times the
/// column.
void add_unknown_heat(json& model, const ModelNames& names, const ReplayCommands& commands) {
  const std::size_t vavs = names.interior_zones.size();
  for (const auto& [prefix, watts] : {std::pair(heat_schedule_prefix, 1000), std::pair(cold_schedule_prefix, -1000)}) {
    for (std::size_t z = 0; z < vavs + names.perimeter_zones.size(); ++z) {
      const std::string schedule = prefix + std::to_string(z + 1);
      if (std::find(commands.schedules.begin(), commands.schedules.end(), schedule) == commands.schedules.end()) return;
      const std::string& zone = z < vavs ? names.interior_zones[z] : names.perimeter_zones[z - vavs];
      model["Schedule:Constant"][schedule] = {{"hourly_value", 0}};
      model["OtherEquipment"][schedule] = {{"fuel_type", "None"},
                                           {"zone_or_zonelist_or_space_or_spacelist_name", zone},
                                           {"schedule_name", schedule},
                                           {"design_level_calculation_method", "EquipmentLevel"},
                                           {"design_level", watts}};
    }
  }
}

void expect_schedules(const json& model, const ReplayCommands& commands) {
  const auto constants = model.find("Schedule:Constant");
  for (const auto& name : commands.schedules)
    if (constants == model.end() || !constants->contains(name)) refuse_schedule(name);
}

/// The fan coils' thermostats as a program of the engine: on above setpoint + band, off below setpoint - band, off
/// outside hours.  It runs once a step, before the zones' heat balance, on the temperatures of the step before.
void add_thermostats(json& model, const RoomLoopOptions& loops, const ModelNames& names) {
  json lines = json::array();
  const auto say = [&lines](const std::string& line) { lines.push_back({{"program_line", line}}); };
  // CurrentTime is the step's end; its middle decides, so that rounding cannot.
  say("SET Replay_Hour = CurrentTime - 0.5 * ZoneTimeStep");
  for (std::size_t i = 1; i <= names.perimeter_zones.size(); ++i) {
    const std::string schedule = fcu_schedule(names, i);
    if (!model["Schedule:Constant"].is_object() || !model["Schedule:Constant"].contains(schedule))
      refuse_schedule(schedule);
    const std::string temp = fmt::format("Replay_Temp_{}", i), on = fmt::format("Replay_FCU_{}", i);
    model[std::string(ems) + "Sensor"][temp] = {
        {"output_variable_or_output_meter_index_key_name", names.perimeter_zones[i - 1]},
        {"output_variable_or_output_meter_name", "Zone Mean Air Temperature"}};
    model[std::string(ems) + "Actuator"][on] = {{"actuated_component_unique_name", schedule},
                                                {"actuated_component_type", "Schedule:Constant"},
                                                {"actuated_component_control_type", "Schedule Value"}};
    say(fmt::format("IF (Replay_Hour < {}) || (Replay_Hour > {})", loops.fcu_from_hour, loops.fcu_to_hour));
    say(fmt::format("SET {} = 0", on));
    say(fmt::format("ELSEIF {} > 0.5", on));
    say(fmt::format("IF {} < {}", temp, loops.fcu_setpoint_degc - loops.fcu_band_k));
    say(fmt::format("SET {} = 0", on));
    say("ENDIF");
    say(fmt::format("ELSEIF {} > {}", temp, loops.fcu_setpoint_degc + loops.fcu_band_k));
    say(fmt::format("SET {} = 1", on));
    say("ENDIF");
  }
  model[std::string(ems) + "Program"]["Replay_Thermostats"] = {{"lines", std::move(lines)}};
  model[std::string(ems) + "ProgramCallingManager"]["Replay Thermostats"] = {
      {"energyplus_model_calling_point", "BeginZoneTimestepBeforeInitHeatBalance"},
      {"programs", json::array({json{{"program_name", "Replay_Thermostats"}}})}};
}

constexpr const char* day_limits = "Replay Commands";

/// Schedules of a model that follow columns of values, one a step of the replayed days.
class DaySchedules {
 public:
  DaySchedules(json& model, const ReplayDays& days) : model_(model), days_(days) {
    // A schedule has room for 53 parts of the year: days, or if they are more, weeks.
    constexpr int most_parts = 53;
    part_ = days.days <= most_parts ? 1 : 7;
  }

  void follow(const std::string& name, const std::vector<double>& values) {
    json& constants = model_["Schedule:Constant"];
    const json before = constants[name];
    if (std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end()) {
      constants[name]["hourly_value"] = values.front();
      return;
    }
    require_weeks_without_holidays();
    constants.erase(name);
    json parts = json::array();
    for (int day = 0; day < days_.days; day += part_) {
      const std::string week = week_of(values, day);
      if (parts.empty() || parts.back()["schedule_week_name"] != week || part_ > 1) {
        parts.push_back({{"schedule_week_name", week}});
        set_date(parts.back(), "start", day);
      }
      set_date(parts.back(), "end", std::min(day + part_, days_.days) - 1);
    }
    // The rest of the year is never simulated, but a schedule must have it.
    parts.front().update({{"start_month", 1}, {"start_day", 1}});
    parts.back().update({{"end_month", 12}, {"end_day", 31}});
    json year = {{"schedule_weeks", std::move(parts)}};
    if (before.contains("schedule_type_limits_name"))
      year["schedule_type_limits_name"] = before["schedule_type_limits_name"];
    model_["Schedule:Year"][name] = std::move(year);
  }

 private:
  void require_weeks_without_holidays() const {
    const auto holidays = model_.find("RunPeriodControl:SpecialDays");
    if (part_ > 1 && holidays != model_.end() && !holidays->empty()) {
      throw hal::InputError("EnergyPlus replay", std::to_string(days_.days) + " days, and holidays in the model",
                            "at most 53 days with holidays", "choose a shorter stretch, or remove the holidays");
    }
  }

  void set_date(json& part, const std::string& which, int day) const {
    const std::int64_t year_s = civil_midnight(days_.year, 1, 1).seconds;
    const std::string date =
        text_of({year_s + std::int64_t{days_.first_step} * days_.step_s + std::int64_t{day} * 86400});
    part[which + "_month"] = std::stoi(date.substr(5, 2));
    part[which + "_day"] = std::stoi(date.substr(8, 2));
  }

  /// The name of the week that begins with a replayed day; a day alone is every day of its week.
  std::string week_of(const std::vector<double>& values, int first) {
    static constexpr const char* weekdays[] = {"monday", "tuesday",  "wednesday", "thursday",
                                               "friday", "saturday", "sunday"};
    static constexpr const char* other_days[] = {"holiday", "summerdesignday", "winterdesignday", "customday1",
                                                 "customday2"};
    const CivilTime begin{days_.begin.seconds + std::int64_t{first} * 86400};
    json week;
    std::string name = "Replay Week";
    for (int i = 0; i < 7; ++i) {
      const std::string day = day_of(values, std::min(first + i % part_, days_.days - 1));
      week[weekdays[(begin.weekday() + i) % 7] + std::string("_schedule_day_name")] = day;
      if (i < part_) name += day.substr(day.rfind(' '));
      for (const char* other : other_days) week[other + std::string("_schedule_day_name")] = day;
    }
    model_["Schedule:Week:Daily"][name] = std::move(week);
    return name;
  }

  /// The name of the schedule of a replayed day, which equal days share.
  std::string day_of(const std::vector<double>& values, int day) {
    const auto first = values.begin() + std::ptrdiff_t{day} * days_.steps_per_day();
    const std::vector<double> today(first, first + days_.steps_per_day());
    const auto [known, added] = known_.try_emplace(today, fmt::format("Replay Day {}", known_.size() + 1));
    if (!added) return known->second;
    model_["ScheduleTypeLimits"][day_limits] = json::object();
    json schedule = {{"schedule_type_limits_name", day_limits}, {"interpolate_to_timestep", "No"}};
    std::vector<std::size_t> ends;  // steps at whose end the value changes
    for (std::size_t step = 1; step <= today.size(); ++step)
      if (step == today.size() || today[step] != today[step - 1]) ends.push_back(step);
    // The engine's time goes by the numbers and texts that it reads.
    if (2 * ends.size() > today.size()) {
      json& list = schedule["extensions"] = json::array();
      for (const double value : today) list.push_back({{"value", value}});
      schedule["minutes_per_item"] = days_.step_s / 60;
      model_["Schedule:Day:List"][known->second] = std::move(schedule);
    } else {
      json& until = schedule["data"] = json::array();
      for (const std::size_t end : ends) {
        const std::size_t minute = end * static_cast<std::size_t>(days_.step_s / 60);
        until.push_back(
            {{"time", fmt::format("{:02}:{:02}", minute / 60, minute % 60)}, {"value_until_time", today[end - 1]}});
      }
      model_["Schedule:Day:Interval"][known->second] = std::move(schedule);
    }
    return known->second;
  }

  json& model_;
  const ReplayDays& days_;
  int part_ = 1;
  std::map<std::vector<double>, std::string> known_;
};

}  // namespace

json replay_model(const EnergyPlusTwin& twin, const ReplayDays& days, const ReplayCommands& commands,
                  bool thermostats) {
  json model = twin.model;
  set_replay_dates(model, days, twin.own.has_value());
  set_replay_outputs(model, twin, thermostats);
  add_unknown_heat(model, twin.names, commands);
  expect_schedules(model, commands);
  if (thermostats) add_thermostats(model, twin.loops, twin.names);
  return model;
}

void follow_commands(json& model, const ReplayDays& days, const ReplayCommands& commands) {
  DaySchedules schedules(model, days);
  for (std::size_t i = 0; i < commands.schedules.size(); ++i)
    schedules.follow(commands.schedules[i], commands.values[commands.columns[i]]);
}

}  // namespace airside::sim
