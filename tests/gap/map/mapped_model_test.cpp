// What a mapping makes of a model, without the engine: names as the model spells them, outputs of each channel, and
// schedules that are free for commands.

#include "tools/gap/map/mapped_model.hpp"

#include <gtest/gtest.h>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/replay/own_outputs.hpp"
#include "tools/gap/model/energyplus_engine.hpp"
#include "tools/gap/run/detectable.hpp"

namespace airside::tools::gap {
namespace {

using nlohmann::json;

json small_model() {
  return {{"Zone", {{"Core_ZN", json::object()}, {"Attic", json::object()}}},
          {"AirTerminal:SingleDuct:VAV:NoReheat", {{"Core box", json::object()}}},
          {"Schedule:Compact", {{"Fan Schedule", {{"schedule_type_limits_name", "On/Off"}, {"data", json::array()}}}}},
          {"Schedule:Constant", {{"Setpoint", {{"hourly_value", 14}}}}},
          {"Coil:Heating:Electric", {{"Coil", {{"air_outlet_node_name", "Node 4"}}}}}};
}

constexpr const char* small_map = R"([model]
file = "a.idf"
zones = ["attic"]
[weather]
file = "a.epw"
[log]
step_min = 60
[[channel]]
column = "T"
zone = "core_zn"
output = "Zone Operative Temperature"
noise_floor = 0.2
[[channel]]
column = "S"
kind = "supply_temperature"
key = "Node 4"
[[channel]]
column = "M"
kind = "preheated_temperature"
key = "Node 4"
[[channel]]
column = "O"
kind = "outdoor_temperature"
[[channel]]
column = "E"
kind = "power"
meter = "Electricity:HVAC"
unit = "kWh"
[[channel]]
column = "F"
kind = "power"
output = "Fan Electricity Energy"
key = "Fan"
[[channel]]
column = "B"
kind = "damper"
zone = "core_zn"
key = "CORE BOX"
[[command]]
column = "fan"
schedule = "fan schedule"
[[command]]
column = "SAT"
schedule = "setpoint"
kind = "supply_setpoint"
)";

std::string replaced(std::string text, const std::string& old, const std::string& now) {
  return text.replace(text.find(old), old.size(), now);
}

TEST(MappedNames, AreSpelledAsInTheModel) {
  const sim::OwnNames own = own_names_of(parse_mapping(small_map, "map.toml"), small_model());
  EXPECT_EQ(own.zones, (std::vector<std::string>{"Core_ZN", "Attic"}));
  EXPECT_EQ(own.terminals, (std::vector<std::string>{"Core box", ""}));
  EXPECT_EQ(own.supply_setpoint_schedule, "Setpoint");
  EXPECT_EQ(own.commands, (std::vector<std::string>{"Fan Schedule"}));
  EXPECT_EQ(own.powers, (std::vector<std::string>{"Electricity:HVAC", ""}));
  EXPECT_EQ(own.supply_air_node, "Node 4");
  EXPECT_EQ(own.mau_outlet_node, "Node 4");
  EXPECT_TRUE(own.every_air_loop);
  EXPECT_TRUE(own.outdoor_measured);
}

TEST(MappedNames, OfSeveralAirLoopsAreSpelledAsInTheModelToo) {
  json model = small_model();
  model["AirLoopHVAC"] = {{"VAV North", json::object()}, {"VAV South", json::object()}, {"Kitchen", json::object()}};
  const std::string two = replaced(small_map, "zones = [", "air_loops = [\"vav south\", \"VAV north\"]\nzones = [");
  const sim::OwnNames own = own_names_of(parse_mapping(two, "map.toml"), model);
  EXPECT_EQ(own.air_loops, (std::vector<std::string>{"VAV South", "VAV North"}));
  EXPECT_FALSE(own.every_air_loop);
  const std::string wrong = replaced(small_map, "zones = [", "air_loops = [\"VAV East\"]\nzones = [");
  EXPECT_THROW(own_names_of(parse_mapping(wrong, "map.toml"), model), hal::InputError);
}

TEST(MappedNames, ThatAreNotThereAreRefusedWithTheNearest) {
  const auto said = [](const char* old, const char* now) -> std::string {
    try {
      own_names_of(parse_mapping(replaced(small_map, old, now), "map.toml"), small_model());
    } catch (const hal::InputError& e) {
      return e.what();
    }
    return "";
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_TRUE(has(said("attic", "atic"), "map.toml:1:1: model.zones: found no \"atic\"")) << said("attic", "atic");
  EXPECT_TRUE(has(said("attic", "xyz"), "it has \"Attic\", \"Core_ZN\"")) << said("attic", "xyz");
  EXPECT_TRUE(has(said("Node 4", "Node 5"), "channel[2].key: found no \"Node 5\"")) << said("Node 4", "Node 5");
  EXPECT_TRUE(has(said("CORE BOX", "Core vox"), "\"Core box\"")) << said("CORE BOX", "Core vox");
  EXPECT_TRUE(has(said("fan schedule", "fan schedul"), "\"Fan Schedule\"")) << said("fan schedule", "fan schedul");
  const std::string one_loop = replaced(small_map, "zones = [", "air_loops = [\"none\"]\nzones = [");
  const std::string no_supply =
      replaced(one_loop, "[[channel]]\ncolumn = \"S\"\nkind = \"supply_temperature\"\nkey = \"Node 4\"\n", "");
  EXPECT_THROW(own_names_of(parse_mapping(no_supply, "map.toml"), small_model()), hal::InputError);
}

TEST(MappedNames, GiveEachChannelItsOutputAndItsGrain) {
  sim::EnergyPlusTwin twin;
  twin.model = small_model();
  twin.own = own_names_of(parse_mapping(small_map, "map.toml"), twin.model);
  twin.names.interior_zones = twin.own->zones;
  twin.names.perimeter_zones.clear();
  twin.names.supply_setpoint_schedule = twin.own->supply_setpoint_schedule;
  twin.step_s = 360;
  const sim::Channels at = sim::channels_of(twin);
  EXPECT_EQ(at.powers, 2);
  EXPECT_EQ(at.dampers, 2);
  const auto grain = [&at](int column) { return at.grain[static_cast<std::size_t>(column)]; };
  EXPECT_EQ(grain(at.power()).step_min, 60);
  EXPECT_FALSE(grain(at.power()).instants);
  for (const int column : {0, at.supply_temp(), at.mau_temp(), at.damper()}) {
    EXPECT_EQ(grain(column).step_min, 60) << at.name(column);
    EXPECT_TRUE(grain(column).instants) << at.name(column);
  }
  EXPECT_EQ(grain(1).step_min, 0) << "a room that the log does not show";
  EXPECT_EQ(grain(0).floor, 0.2);
  EXPECT_EQ(grain(0).title, "T");
  std::map<int, std::string> series;
  std::map<int, double> factor;
  for (const sim::ChannelOutput& output : sim::own_outputs(twin)) {
    series[output.column] = output.series();
    factor[output.column] = output.factor;
  }
  EXPECT_EQ(series[0], "core_zn,Zone Operative Temperature");
  EXPECT_EQ(series[1], "Attic,Zone Mean Air Temperature");
  EXPECT_EQ(series[at.power()], "Electricity:HVAC");
  EXPECT_EQ(series[at.power() + 1], "Fan,Fan Electricity Energy");
  EXPECT_DOUBLE_EQ(factor[at.power() + 1], 1 / 360000.0);
  EXPECT_EQ(series[at.damper()], "Core box,Zone Air Terminal VAV Damper Position");
  twin.own->power_outputs[1].variable = "Fan Electricity Rate";
  for (const sim::ChannelOutput& output : sim::own_outputs(twin)) factor[output.column] = output.factor;
  EXPECT_DOUBLE_EQ(factor[at.power() + 1], 1e-3);
  const EnergyPlusEngine engine(twin, "small", "", false);
  EXPECT_EQ(own_control_text(engine).rfind("What is played of the record: the supply setpoint, Fan Schedule.", 0), 0U);
  twin.names.supply_setpoint_schedule.clear();
  twin.own->commands.clear();
  EXPECT_EQ(own_control_text(EnergyPlusEngine(twin, "small", "", false)).rfind("No recorded command", 0), 0U);
}

TEST(CommandSchedules, BecomeConstantsThatAReplayLetsFollow) {
  json model = small_model();
  sim::OwnNames names;
  names.supply_setpoint_schedule = "Setpoint";
  names.commands = {"FAN SCHEDULE", "absent"};
  sim::free_command_schedules(model, names);
  EXPECT_FALSE(model.contains("Schedule:Compact"));
  EXPECT_EQ(model["Schedule:Constant"]["Fan Schedule"]["schedule_type_limits_name"], "On/Off");
  EXPECT_EQ(model["Schedule:Constant"]["Setpoint"]["hourly_value"], 14);
  EXPECT_EQ(model["Schedule:Constant"].size(), 2U);
}

}  // namespace
}  // namespace airside::tools::gap
