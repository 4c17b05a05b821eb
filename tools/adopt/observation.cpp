#include "tools/adopt/observation.hpp"

#include <algorithm>
#include <fstream>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/replay/eso.hpp"
#include "tools/adopt/loop/loop_meters.hpp"
#include "tools/adopt/model/engine_run.hpp"
#include "tools/adopt/model/model_view.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

constexpr double joule_per_kwh = 3.6e6;

/// The one object of a type that has at most one, made if absent.
json& only_object(json& model, const char* type, const char* name) {
  json& objects = model[type];
  if (!objects.is_object() || objects.empty()) objects = {{name, json::object()}};
  return objects.begin().value();
}

int steps_per_hour(const json& model) {
  const auto type = model.find("Timestep");
  if (type == model.end() || !type->is_object() || type->empty()) return 6;
  return type->begin()->value("number_of_timesteps_per_hour", 6);
}

void set_outputs(json& model, const AirLoop& loop) {
  for (auto it = model.begin(); it != model.end();) {
    const std::string& type = it.key();
    const bool drop = type.starts_with("Output:") && type != "Output:EnergyManagementSystem";
    it = drop ? model.erase(it) : ++it;
  }
  json& variables = model["Output:Variable"] = json::object();
  const auto add = [&](const std::string& key, const char* name) {
    variables["airside " + std::to_string(variables.size() + 1)] = {
        {"key_value", key}, {"variable_name", name}, {"reporting_frequency", "Timestep"}};
  };
  for (const LoopTerminal& t : loop.terminals) {
    add(t.zone, "Zone Mean Air Temperature");
    add(t.zone, "Zone People Occupant Count");
    if (t.thermostat) add(t.zone, "Zone Thermostat Cooling Setpoint Temperature");
    if (t.thermostat) add(t.zone, "Zone Thermostat Heating Setpoint Temperature");
    if (t.damper) add(t.name, "Zone Air Terminal VAV Damper Position");
  }
  add(loop.supply_outlet, "System Node Temperature");
  add(loop.supply_outlet, "System Node Setpoint Temperature");
  add(loop.supply_outlet, "System Node Mass Flow Rate");
  add("Environment", "Site Outdoor Air Drybulb Temperature");
  json& meters = model["Output:Meter"] = json::object();
  for (const std::string& meter : candidate_meters())
    meters["airside " + meter] = {{"key_name", meter}, {"reporting_frequency", "Timestep"}};
  json& files = model["OutputControl:Files"] = json::object();
  for (const char* file : {"csv", "mtr", "tabular", "sqlite", "json", "audit", "bnd", "rdd", "mdd", "mtd", "shd", "dxf",
                           "zone_sizing", "system_sizing"})
    files["Output Files"][std::string("output_") + file] = "No";
  files["Output Files"]["output_eso"] = "Yes";
  files["Output Files"]["output_eio"] = "Yes";
}

json composed(const ObservationPlan& plan) {
  json model = *plan.model;
  model.erase("RunPeriodControl:DaylightSavingTime");
  model.erase("RunPeriodControl:SpecialDays");  // 11 October is a holiday in many models: two like days are compared
  set_outputs(model, *plan.loop);
  const int last = plan.first_day + plan.days - 1;
  model["RunPeriod"] = {{"airside days",
                         {{"begin_year", 2021},
                          {"begin_month", plan.month},
                          {"begin_day_of_month", plan.first_day},
                          {"end_year", 2021},
                          {"end_month", plan.month},
                          {"end_day_of_month", last},
                          {"use_weather_file_daylight_saving_period", "No"},
                          {"use_weather_file_holidays_and_special_days", "No"}}}};
  json& control = only_object(model, "SimulationControl", "Simulation Control");
  control["run_simulation_for_sizing_periods"] = "No";
  control["run_simulation_for_weather_file_run_periods"] = "Yes";
  return model;
}

std::vector<double> series(const sim::EsoFile& eso, const std::string& name) {
  const auto found = eso.series().find(engine_upper(name));
  return found == eso.series().end() ? std::vector<double>{} : found->second;
}

Observation read_observation(const sim::EsoFile& eso, const AirLoop& loop, int per_hour) {
  Observation out;
  out.steps_per_day = 24 * per_hour;
  for (const LoopTerminal& t : loop.terminals) {
    out.room_degc.push_back(eso.of(t.zone + ",Zone Mean Air Temperature"));
    out.people.push_back(series(eso, t.zone + ",Zone People Occupant Count"));
    out.cooling_sp.push_back(series(eso, t.zone + ",Zone Thermostat Cooling Setpoint Temperature"));
    out.heating_sp.push_back(series(eso, t.zone + ",Zone Thermostat Heating Setpoint Temperature"));
    out.damper.push_back(t.damper ? series(eso, t.name + ",Zone Air Terminal VAV Damper Position")
                                  : std::vector<double>{});
  }
  out.setpoint_degc = series(eso, loop.supply_outlet + ",System Node Setpoint Temperature");
  out.supply_degc = eso.of(loop.supply_outlet + ",System Node Temperature");
  out.flow_kg_s = eso.of(loop.supply_outlet + ",System Node Mass Flow Rate");
  out.outdoor_degc = eso.of("Environment,Site Outdoor Air Drybulb Temperature");
  for (const std::string& meter : candidate_meters()) {
    std::vector<double> joule = series(eso, meter);
    if (std::all_of(joule.begin(), joule.end(), [](double j) { return j == 0; })) continue;
    for (double& j : joule) j *= per_hour / joule_per_kwh;
    out.meter_kw[meter] = std::move(joule);
  }
  return out;
}

}  // namespace

const std::vector<std::string>& candidate_meters() {
  static const std::vector<std::string> meters = {loop_fans_meter,           loop_cooling_meter,
                                                  loop_heating_meter,        loop_gas_meter,
                                                  "Fans:Electricity",        "Cooling:Electricity",
                                                  "Cooling:DistrictCooling", "Heating:Electricity",
                                                  "Heating:NaturalGas",      "Heating:DistrictHeatingWater",
                                                  "Pumps:Electricity",       "Electricity:HVAC",
                                                  "Electricity:Plant",       "Electricity:Facility"};
  return meters;
}

Observation observe(const ObservationPlan& plan, const sim::EnergyPlusInstall& install,
                    const std::filesystem::path& folder, const std::string& place) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  {
    std::ofstream out(folder / "in.epJSON", std::ios::binary);
    if (!(out << composed(plan).dump()) || !out.flush()) {
      throw hal::InputError(folder.string(), "a folder that cannot be written", "room in TMPDIR",
                            "name another folder in TMPDIR");
    }
  }
  const EngineRun run = run_engine_program(
      install.folder / "energyplus",
      {"-w", std::filesystem::absolute(plan.weather).string(), "-d", folder.string(), "in.epJSON"}, folder);
  if (!run.done) {
    throw hal::InputError(place, "a model that the engine does not run: it " + run.words,
                          "a model that runs for a week", "correct it as the engine says");
  }
  return read_observation(sim::EsoFile(folder / "eplusout.eso", sim::EsoFile::Periods::last), *plan.loop,
                          steps_per_hour(*plan.model));
}

}  // namespace airside::tools
