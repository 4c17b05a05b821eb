#include "adopted/reference_models.hpp"

#include <cstdlib>
#include <fstream>

#include "sim/energyplus/adopted/model_index.hpp"
#include "sim/json/json_file.hpp"
#include "support/program.hpp"

namespace airside::sim {
namespace {

namespace fs = std::filesystem;

EnergyPlusOptions adopted(const std::string& name, const std::string& supply_node) {
  EnergyPlusOptions options;
  options.name = name;
  options.model = reference_model(name);
  options.patches.push_back({"setpoint", setpoint_patch(options.model, supply_node)});
  options.weather = reference_weather("Chicago");
  options.step_min = 6;
  options.rooms.supply_lag_s = 0;
  options.days = 1;
  options.start_day = 6;  // a Tuesday
  options.initial_setpoint_degc = 14;
  options.own.emplace();
  options.own->supply_setpoint_schedule = "airside supply setpoint";
  options.own->supply_air_node = supply_node;
  return options;
}

}  // namespace

fs::path reference_models() {
  const char* named = std::getenv("AIRSIDE_FOREIGN_MODELS");
  if (named != nullptr) return fs::is_directory(named) ? fs::path(named).parent_path() : fs::path();
  if (!have_energyplus()) return {};
  const fs::path packages = find_energyplus().folder.parent_path().parent_path();
  const fs::path data = packages / "pyenergyplus" / "data";
  return fs::is_directory(data / "model") ? data : fs::path();
}

fs::path reference_model(const std::string& name) {
  static const TemporaryFolder folder;
  const fs::path converted = folder.path() / (name + ".epJSON");
  if (fs::exists(converted)) return converted;
  const fs::path idf = folder.path() / (name + ".idf");
  fs::copy_file(reference_models() / "model" / (name + ".idf"), idf);
  const std::string engine = (find_energyplus().folder / "energyplus").string();
  const Outcome outcome = run_program(engine, {"--convert-only", idf.string()}, folder.path(), folder.path());
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  return converted;
}

fs::path reference_weather(const std::string& part) {
  for (const auto& entry : fs::directory_iterator(reference_models() / "weather")) {
    const std::string file = entry.path().filename().string();
    if (file.find(part) != std::string::npos && file.ends_with(".epw")) return entry.path();
  }
  ADD_FAILURE() << "no weather file of " << part;
  return {};
}

nlohmann::json setpoint_patch(const fs::path& model, const std::string& node) {
  const nlohmann::json text = read_json(model);
  const ModelIndex index(text);
  nlohmann::json patch = {{"Schedule:Constant", {{"airside supply setpoint", {{"hourly_value", 14.0}}}}},
                          {"SetpointManager:Scheduled",
                           {{"airside supply setpoint",
                             {{"control_variable", "Temperature"},
                              {"schedule_name", "airside supply setpoint"},
                              {"setpoint_node_or_nodelist_name", node}}}}}};
  for (const ModelObject& manager : index.of_type("SetpointManager:")) {
    if (manager.text("setpoint_node_or_nodelist_name") == node) patch[manager.type][manager.name] = nullptr;
  }
  return patch;
}

EnergyPlusOptions medium_office() {
  EnergyPlusOptions options = adopted("RefBldgMediumOfficeNew2004_Chicago", "VAV_1 Supply Equipment Outlet Node");
  OwnNames& names = *options.own;
  names.zones = {"Core_bottom", "Perimeter_bot_ZN_1", "Perimeter_bot_ZN_2", "Perimeter_bot_ZN_3", "Perimeter_bot_ZN_4"};
  for (const std::string& zone : names.zones) names.terminals.push_back(zone + " VAV Box Component");
  names.mau_outlet_node = "VAV_1_OA-VAV_1_CoolCNode";
  names.supply_fan = "VAV_1_Fan";
  names.powers = {"Fans:Electricity", "Cooling:Electricity", "Heating:Electricity"};
  names.occupancy = names.zones;
  return options;
}

EnergyPlusOptions small_office() {
  EnergyPlusOptions options = adopted("RefBldgSmallOfficeNew2004_Chicago", "PSZ-AC:1 Supply Equipment Outlet Node");
  OwnNames& names = *options.own;
  names.zones = {"Core_ZN"};
  names.terminals = {""};
  names.supply_fan = "PSZ-AC:1_Fan";
  names.powers = {"Electricity:HVAC", ""};
  names.occupancy = {"Core_ZN"};
  return options;
}

EnergyPlusOptions large_hotel() {
  EnergyPlusOptions options = adopted("RefBldgLargeHotelNew2004_Chicago", "FLR_3_DOAS Supply Equipment Outlet Node");
  OwnNames& names = *options.own;
  names.zones = {"Room_1_Flr_3", "Room_2_Flr_3", "Room_3_Mult19_Flr_3"};
  names.fcu_zones = {"Room_1_Flr_3", "Room_2_Flr_3"};
  names.powers = {"Fans:Electricity"};
  return options;
}

}  // namespace airside::sim
