// Table [twin] with names of a model, as a site file has it.

#include "hal/site/site_file.hpp"
#include "support/complaint.hpp"

namespace airside::hal {
namespace {

const std::string own_site = R"([site]
name = "Office"
topology = "3vav-0fcu-1power"
[twin]
model = "model.epJSON"
patches = ["twin.patch.json"]
weather = "x.epw"
control = "own"
step_min = 6
supply_lag_s = 120
[twin.names]
supply_setpoint_schedule = "airside supply setpoint"
supply_air_node = "AHU Out"
mau_outlet_node = "MAU Out"
zones = ["Core_ZN", "Perimeter 1", "Perimeter ä"]
terminals = ["Core VAV", "", "P VAV"]
supply_fan = "AHU Fan"
powers = ["Fans:Electricity"]
occupancy = ["Core_ZN"]
)";

SiteFile parse(const std::string& text) { return parse_site_text(text, "room/site.toml", SiteRules{}); }

TEST(TwinSection, ReadsTheNamesOfAModelWithControlsOfItsOwn) {
  const SiteFile site = parse(own_site);
  ASSERT_TRUE(site.twin && site.twin->names);
  const TwinSection& twin = *site.twin;
  EXPECT_EQ(twin.model, "room/model.epJSON");
  EXPECT_EQ(twin.patches, std::vector<std::string>{"room/twin.patch.json"});
  EXPECT_EQ(twin.control, TwinControl::own);
  EXPECT_EQ(twin.step_min, 6);
  EXPECT_EQ(twin.supply_lag_s, 120);
  EXPECT_EQ(twin.names->supply_setpoint_schedule, "airside supply setpoint");
  EXPECT_EQ(twin.names->supply_air_node, "AHU Out");
  EXPECT_EQ(twin.names->mau_outlet_node, "MAU Out");
  EXPECT_EQ(twin.names->zones, (std::vector<std::string>{"Core_ZN", "Perimeter 1", "Perimeter ä"}));
  EXPECT_EQ(twin.names->terminals, (std::vector<std::string>{"Core VAV", "", "P VAV"}));
  EXPECT_EQ(twin.names->powers, std::vector<std::string>{"Fans:Electricity"});
  EXPECT_EQ(twin.names->occupancy, std::vector<std::string>{"Core_ZN"});
  EXPECT_EQ(twin.names->supply_fan, "AHU Fan");
  EXPECT_TRUE(twin.names->fcu_zones.empty());
}

TEST(TwinSection, NeedsOnlySetpointNodeAndZones) {
  std::string text = own_site;
  for (const char* line : {"mau_outlet_node = \"MAU Out\"\n", "terminals = [\"Core VAV\", \"\", \"P VAV\"]\n",
                           "supply_fan = \"AHU Fan\"\n", "powers = [\"Fans:Electricity\"]\n",
                           "occupancy = [\"Core_ZN\"]\n", "step_min = 6\n", "supply_lag_s = 120\n"})
    text = replaced(text, line, "");
  const SiteFile site = parse(text);
  EXPECT_EQ(site.twin->step_min, 0);
  EXPECT_EQ(site.twin->supply_lag_s, 0);
  EXPECT_TRUE(site.twin->names->powers.empty());
}

TEST(TwinSection, ReadsOtherNamesOfTheProjectsOwnTwin) {
  const SiteFile site = parse(R"([site]
name = "Office"
topology = "3vav-0fcu-1power"
[twin]
model = "model.epJSON"
[twin.names]
interior_zones = ["A", "B", "C"]
perimeter_zones = []
vav_damper_schedule = "Damper # of the box"
powers = ["Electricity:HVAC"]
)");
  EXPECT_EQ(site.twin->control, TwinControl::external);
  EXPECT_EQ(site.twin->names->interior_zones, (std::vector<std::string>{"A", "B", "C"}));
  EXPECT_EQ(site.twin->names->vav_damper_schedule, "Damper # of the box");
  EXPECT_EQ(site.twin->names->fcu_on_schedule, "");
}

TEST(TwinSection, RefusesWhatCannotBeMeant) {
  struct Case {
    const char *from, *to;
    Complaint want;
  };
  const Case cases[] = {
      {"control = \"own\"", "control = \"mine\"", {"twin.control", "mine", "external, own", "choose"}},
      {"control = \"own\"\n", "", {"twin.names.zones", "external", "own", "control"}},
      {"step_min = 6", "step_min = 5", {"twin.step_min", "5", "3 or 6", ""}},
      {"model.epJSON", "rc", {"twin.control", "rc", "epJSON", "leave it out"}},
      {"supply_air_node = \"AHU Out\"\n", "", {"twin.names.supply_air_node", "nothing", "a text", "add"}},
      {"zones = [\"Core_ZN\", \"Perimeter 1\", \"Perimeter ä\"]\n", "", {"twin.names.zones", "nothing", "zones", ""}},
      {"\"Perimeter 1\", ", "", {"twin.names.zones", "a list of 2", "3 names", "topology"}},
      {"\"Perimeter 1\"", "\"Core_ZN\"", {"twin.names.zones", "twice", "each once", ""}},
      {"\"Perimeter 1\"", "\"\"", {"twin.names.zones", "an empty text", "3 names", ""}},
      {"[\"Core VAV\", \"\", \"P VAV\"]", "[\"Core VAV\"]", {"twin.names.terminals", "a list of 1", "3 names", ""}},
      {"[\"Fans:Electricity\"]", "[\"a\", \"b\"]", {"twin.names.powers", "a list of 2", "1 names", "topology"}},
      {"supply_fan", "supply_fans", {"twin.names.supply_fans", "unknown key", "supply_fan", "did you mean"}},
      {"supply_fan", "fcu_on_schedule", {"twin.names.fcu_on_schedule", "unknown key", "zones", ""}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.to);
    expect_complaint(c.want, [&] { parse(replaced(own_site, c.from, c.to)); });
  }
  const std::size_t names = own_site.find("[twin.names]");
  expect_complaint({"twin.control", "no [twin.names]", "names", "adopt"}, [&] { parse(own_site.substr(0, names)); });
}

}  // namespace
}  // namespace airside::hal
