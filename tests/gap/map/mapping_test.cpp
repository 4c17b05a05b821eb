// A mapping file: what it says, and every complaint about what it cannot say.

#include "tools/gap/map/mapping.hpp"

#include <gtest/gtest.h>

#include <string>

#include "hal/text/input_error.hpp"

namespace airside::tools::gap {
namespace {

const std::string whole = R"([model]
file = "office.idf"
patches = ["twin.patch.json"]
zones = ["Perimeter_ZN_2"]
[weather]
file = "/weather/site.epw"
[log]
time = "Timestamp"
step_min = 60
[[channel]]
column = "T core"
zone = "Core_ZN"
unit = "degF"
noise_floor = 0.2
[[channel]]
column = "T supply"
kind = "supply_temperature"
key = "Node 4"
[[channel]]
column = "Meter"
kind = "power"
meter = "Electricity:Facility"
unit = "kWh"
counter = true
[[channel]]
column = "Box"
kind = "damper"
zone = "Core_ZN"
key = "Core box"
unit = "%"
[[command]]
column = "fan"
schedule = "Fan schedule"
[[command]]
column = "SAT"
schedule = "Setpoint"
kind = "supply_setpoint"
unit = "K"
)";

std::string changed_text(std::string text, const std::string& old, const std::string& now) {
  const auto at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), now);
}

std::string complaint(const std::string& text) {
  try {
    parse_mapping(text, "m/map.toml");
  } catch (const hal::InputError& e) {
    return e.what();
  }
  return "";
}

std::string complaint_with(const std::string& old, const std::string& now) {
  return complaint(changed_text(whole, old, now));
}

TEST(Mapping, SaysWhichColumnIsWhat) {
  const Mapping m = parse_mapping(whole, "m/map.toml");
  EXPECT_EQ(m.model, "m/office.idf");
  EXPECT_EQ(m.patches, (std::vector<std::string>{"m/twin.patch.json"}));
  EXPECT_EQ(m.weather, "/weather/site.epw");
  EXPECT_EQ(m.zones, (std::vector<std::string>{"Core_ZN", "Perimeter_ZN_2"}));
  ASSERT_EQ(m.channels.size(), 4U);
  EXPECT_EQ(m.channels[0].key, "Core_ZN");
  EXPECT_NEAR(77 * m.channels[0].unit.factor + m.channels[0].unit.offset, 25, 1e-9);
  EXPECT_FALSE(m.channels[0].mean);
  EXPECT_TRUE(m.channels[2].mean) << "power is a mean of its row";
  EXPECT_TRUE(m.channels[2].counter);
  EXPECT_EQ(m.place_of(m.channels[3]), 0U);
  ASSERT_NE(m.supply_setpoint(), nullptr);
  EXPECT_EQ(m.supply_setpoint()->column, "SAT");
  ASSERT_EQ(m.further_commands().size(), 1U);
  EXPECT_EQ(m.further_commands()[0]->schedule, "Fan schedule");
  const hal::TopologyCounts counts = counts_of(m);
  EXPECT_EQ(counts.name, "2vav-0fcu-1power");
  ASSERT_EQ(counts.sides.size(), 1U);
  EXPECT_EQ(counts.sides[0].place, 1);
  EXPECT_EQ(counts.stand_in(2), 1.0) << "boxes are not commanded";
  EXPECT_EQ(counts.stand_in(0), std::nullopt);
  const auto lines = lines_of(m);
  EXPECT_EQ(lines[0], "room 1: column \"T core\", zone Core_ZN");
  EXPECT_EQ(lines[2], "power 1: column \"Meter\", meter Electricity:Facility");
  EXPECT_EQ(lines[4], "command: column \"fan\", schedule Fan schedule");
  EXPECT_EQ(json_of(m)["channels"][3]["object"], "zone Core_ZN, Core box");
}

TEST(Mapping, SumsMeters) {
  const Mapping m = parse_mapping(
      changed_text(whole, "meter = \"Electricity:Facility\"", "meters = [\"Fans:Electricity\", \"Pumps:Electricity\"]"),
      "m/map.toml");
  EXPECT_EQ(m.channels[2].summed, (std::vector<std::string>{"Fans:Electricity", "Pumps:Electricity"}));
  EXPECT_EQ(m.channels[2].meter, "airside sum 3") << "a meter that the model gets";
  EXPECT_EQ(lines_of(m)[2], "power 1: column \"Meter\", meters Fans:Electricity + Pumps:Electricity");
}

TEST(Mapping, ComplaintsNameTheLineAndTheNearest) {
  EXPECT_NE(complaint_with("[log]", "[logs]").find("did you mean `log`?"), std::string::npos);
  EXPECT_NE(complaint_with("kind = \"supply_temperature\"", "kind = \"suply_temperature\"")
                .find("did you mean \"supply_temperature\"?"),
            std::string::npos);
  const std::string unit = complaint_with("unit = \"degF\"", "unit = \"F\"");
  EXPECT_EQ(unit.rfind("m/map.toml:13:1: channel[1].unit", 0), 0U) << unit;
  EXPECT_NE(unit.find("degC, degF, K"), std::string::npos) << unit;
  EXPECT_NE(complaint_with("noise_floor", "noise_flor").find("did you mean `noise_floor`?"), std::string::npos);
  EXPECT_NE(complaint("[model]\nfile = ").find("not TOML"), std::string::npos);
  EXPECT_NE(complaint("channel = 3\n[model]\nfile = \"a\"\n[weather]\nfile = \"b\"\n").find("tables [[channel]]"),
            std::string::npos);
}

TEST(Mapping, RefusesWhatCannotBeRead) {
  const std::pair<std::pair<const char*, const char*>, const char*> wrong[] = {
      {{"zone = \"Core_ZN\"\nunit", "unit"}, "no zone"},
      {{"key = \"Node 4\"", ""}, "a node of the air loop"},
      {{"key = \"Core box\"", ""}, "the zone's air terminal"},
      {{"key = \"Node 4\"", "key = \"Node 4\"\nzone = \"Core_ZN\""}, "for room_temperature and damper alone"},
      {{"key = \"Node 4\"", "key = \"Node 4\"\nmeter = \"M\""}, "a meter for power alone"},
      {{"key = \"Node 4\"", "key = \"Node 4\"\noutput = \"O\""}, "this kind has its own"},
      {{"meter = \"Electricity:Facility\"", ""}, "no meter"},
      {{"meter = \"Electricity:Facility\"", "meter = \"A\"\nmeters = [\"B\"]"}, "a meter and a list of meters"},
      {{"meter = \"Electricity:Facility\"", "meters = [\"A\", \"B\", \"A\"]"}, "each meter of the sum once"},
      {{"key = \"Node 4\"", "key = \"Node 4\"\nmeters = [\"A\"]"}, "a meter for power alone"},
      {{"meter = \"Electricity:Facility\"", "meter = \"M\"\nkey = \"K\"\noutput = \"O\""}, "a meter and an output"},
      {{"unit = \"kWh\"", "unit = \"kW\""}, "a counter of kW"},
      {{"counter = true", "mean = false"}, "mean = false for energy"},
      {{"column = \"Box\"", "column = \"Meter\""}, "the column \"Meter\" twice"},
      {{"step_min = 60", "step_min = 45"}, "a multiple of 30"},
      {{"step_min = 60", "separator = \"::\""}, "one character"},
      {{"step_min = 60", "decimal_comma = true"}, "another separator"},
      {{"file = \"office.idf\"", "file = \"office.idf\"\nstep_min = 4"}, "3 or 6 min"},
      {{"schedule = \"Fan schedule\"", "schedule = \"S\"\nkind = \"supply_setpoint\""}, "a second supply setpoint"},
  };
  for (const auto& [change, found] : wrong)
    EXPECT_NE(complaint_with(change.first, change.second).find(found), std::string::npos)
        << found << ": " << complaint_with(change.first, change.second);
  const std::string head = "[model]\nfile = \"a.idf\"\n[weather]\nfile = \"a.epw\"\n";
  const std::string meter = "[[channel]]\ncolumn = \"m\"\nkind = \"power\"\nmeter = \"M\"\n";
  EXPECT_NE(complaint(head + meter).find("add zones"), std::string::npos);
  EXPECT_NE(complaint(head + "[[channel]]\ncolumn = \"o\"\nkind = \"outdoor_temperature\"\n").find("to compare"),
            std::string::npos);
  std::string many = head;
  for (int i = 0; i < 33; ++i)
    many += "[[channel]]\ncolumn = \"c" + std::to_string(i) + "\"\nzone = \"z" + std::to_string(i) + "\"\n";
  EXPECT_NE(complaint(many).find("33 zones"), std::string::npos);
}

}  // namespace
}  // namespace airside::tools::gap
