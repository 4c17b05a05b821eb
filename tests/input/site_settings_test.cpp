// Site file and point map must not contradict one another.

#include "hal/site/site_settings.hpp"

#include "airside/forecast/room_head.hpp"
#include "airside/supervision/schedule.hpp"
#include "support/complaint.hpp"

namespace airside::hal {
namespace {

SiteFile site_of(const std::string& more) {
  return parse_site_text("[site]\nname = \"Room\"\ntopology = \"5vav-5fcu-2power\"\n" + more, "site.toml",
                         site_rules());
}

PointMap map_of(const std::string& setpoint) {
  return PointMap::parse(
      replaced(default_point_map(5, 5, 2), "int16,big,big,0.01,0,8,32,,,0x8000,on-change,6,18,self", setpoint),
      "points.csv");
}

constexpr const char* usual = "int16,big,big,0.01,0,8,32,,,0x8000,on-change,6,18,self";

TEST(SiteSettings, UsualOnesAreInOrder) {
  EXPECT_NO_THROW(refuse_contradiction(site_of(""), map_of(usual)));
  EXPECT_NO_THROW(refuse_contradiction(site_of("[controller.override]\nwrites_per_day = 20\n"), map_of(usual)));
  EXPECT_NO_THROW(refuse_contradiction(site_of(""), map_of("int16,big,big,0.01,0,8,32,,,0x8000,refresh,6,18,self")));
  EXPECT_NO_THROW(refuse_contradiction(site_of("[setpoint]\nmin_degc = 20.4\nmax_degc = 24.6\n"),
                                       map_of("int16,big,big,1,0,8,32,,,0x8000,on-change,6,18,self")));
}

TEST(SiteSettings, ABudgetOfWritesAndARefreshedRegisterAreRefused) {
  expect_complaint({"points.csv:", "refresh", "writes_per_day = 20", "write on change"}, [] {
    refuse_contradiction(site_of("[controller.override]\nwrites_per_day = 20\n"),
                         map_of("int16,big,big,0.01,0,8,32,,,0x8000,refresh,6,18,self"));
  });
}

TEST(SiteSettings, ARegisterThatIsTooCoarseForTheLimitsIsRefused) {
  for (const char* limits :
       {"min_degc = 20.4\nmax_degc = 24.6\n", "min_degc = 20\nmax_degc = 24\nmax_change_k = 9\n"}) {
    expect_complaint({"points.csv:", "steps of 10 K", "at least two values", "scale and offset"}, [limits] {
      refuse_contradiction(site_of(std::string("[setpoint]\n") + limits),
                           map_of("int16,big,big,10,0,0,40,,,0x8000,on-change,6,20,self"));
    });
  }
  expect_complaint({": scale", "steps of 1 K", "at most 0.5 K a cycle", "widen [setpoint]"}, [] {
    refuse_contradiction(site_of("[setpoint]\nmax_change_k = 0.5\n"),
                         map_of("int16,big,big,1,0,8,32,,,0x8000,on-change,6,18,self"));
  });
}

TEST(SiteSettings, SetpointsOutsideTheLimitsOfTheirRowAreRefused) {
  for (const char* key : {"[setpoint] max_degc", "[expert] work_degc", "[expert] off_degc"}) {
    const std::string words(key);
    const std::string section = words.substr(0, words.find(' ')), name = words.substr(words.find(' ') + 1);
    expect_complaint(
        {words.c_str(), "36 degC", "8 to 32 degC, the limits of setpoint on line", "min and max of that row"},
        [&] { refuse_contradiction(site_of(section + "\n" + name + " = 36\n"), map_of(usual)); });
  }
  expect_complaint({"[setpoint] min_degc", "20 degC", "21 to 32 degC", "correct it"}, [] {
    refuse_contradiction(site_of(""), map_of("int16,big,big,0.01,0,21,32,,,0x8000,on-change,6,22,self"));
  });
  EXPECT_NO_THROW(refuse_contradiction(site_of("[setpoint]\nmax_degc = 32\n[expert]\noff_degc = 32\n"), map_of(usual)));
}

TEST(SiteSettings, AClockOfASimulatedAhuNeedsItsPoints) {
  const std::string plant = "[clock]\nsource = \"plant\"\n";
  EXPECT_NO_THROW(refuse_contradiction(site_of(plant), map_of(usual)));
  for (const char* name : {"clock_s", "clock_advance_s"}) {
    std::string rows = default_point_map(5, 5, 2);
    const std::size_t at = rows.find(std::string("\n") + name + ",");
    ASSERT_NE(at, std::string::npos) << name;
    rows.erase(at, rows.find('\n', at + 1) - at);
    const PointMap map = PointMap::parse(rows, "points.csv");
    expect_complaint({"site.toml: [clock] source", name, "airside serve", "source = \"system\""},
                     [&] { refuse_contradiction(site_of(plant), map); });
    EXPECT_NO_THROW(refuse_contradiction(site_of(""), map));
  }
}

TEST(SiteSettings, TheControlCycleIsSixToTwentyFourMinutesInRows) {
  EXPECT_EQ(controller_settings(site_of("")).cycle_min, 18);
  for (const int minutes : {6, 12, 18, 24}) {
    const SiteFile site = site_of("[controller]\ncycle_min = " + std::to_string(minutes) + "\n");
    EXPECT_EQ(control_cycle(controller_settings(site)).minutes(), minutes);
  }
  const auto refuse = [](const std::string& value, const Complaint& want, const std::string& more = "") {
    expect_complaint(want, [&] { (void)site_of("[controller]\n" + more + "cycle_min = " + value + "\n"); });
  };
  refuse("10", {"site.toml:5:1: controller.cycle_min", "10", "6, 12, 18 or 24 min", "whole rows"});
  refuse("30", {"controller.cycle_min", "30", "6 to 24", "18"});
  refuse("\"18\"", {"controller.cycle_min", "\"18\"", "whole number", ""});
  refuse("12", {"site.toml:6:1: controller.cycle_min", "12 beside objective = \"band\"", "18", "leave cycle_min out"},
         "objective = \"band\"\n");
  EXPECT_NO_THROW(site_of("[controller]\nobjective = \"band\"\ncycle_min = 18\n"));
  expect_complaint({"override.cycle_min", "cycle_min", "key of their own", "cycle_min in [controller]"},
                   [] { (void)site_of("[controller.override]\ncycle_min = 12\n"); });
}

TEST(SiteSettings, DaysOffHaveAProfileOfTheirOwnUnlessOverridden) {
  EXPECT_EQ(day_types_of(controller_settings(site_of(""))), 2);
  const std::string days_off = "[target]\nweekday_only = true\n";
  EXPECT_EQ(day_types_of(controller_settings(site_of(days_off))), 2);
  EXPECT_EQ(day_types_of(controller_settings(site_of(days_off + "[controller.override]\nhead_day_types = 1\n"))), 1);
  EXPECT_EQ(day_types_of(controller_settings(site_of("[controller.override]\nhead_day_types = 2\n"))), 2);
}

TEST(SiteSettings, BeginWithThePresetThatTheSiteNames) {
  EXPECT_EQ(preset_names(), (std::vector<std::string>{"product", "paper", "paper-repaired"}));
  for (const std::string& name : preset_names()) {
    const SiteFile site = site_of("[controller]\npreset = \"" + name + "\"\n");
    EXPECT_EQ(site.preset, preset_named(name));
    EXPECT_EQ(name_of(site.preset), name);
  }
  const ControllerSettings printed = controller_settings(site_of("[controller]\npreset = \"paper\"\n"));
  const ControllerSettings repaired = controller_settings(site_of("[controller]\npreset = \"paper-repaired\"\n"));
  EXPECT_EQ(printed.confidence_full, 1.0);
  EXPECT_EQ(repaired.confidence_full, 0.1);
  EXPECT_EQ(printed.gamma, 0.5);
  EXPECT_EQ(repaired.gamma, 0.0);
  EXPECT_EQ(printed.label_vav, 1.0);
  EXPECT_EQ(repaired.label_vav, -1.0);
  EXPECT_EQ(repaired.refine_step_k, 0.01);
  EXPECT_EQ(repaired.batch, 128);
  EXPECT_EQ(repaired.recent_in_batch, 32);
  EXPECT_EQ(repaired.head, 0) << "the published network alone";
  EXPECT_EQ(controller_settings(site_of("")).head, 1) << "product";
}

TEST(SiteSettings, TheFanRunsAlwaysUnlessTheSiteSaysWhen) {
  constexpr CivilTime monday_8{1'627'862'400 + 8 * 3600};  // 2021-08-02
  const CivilTime night{monday_8.seconds + 14 * 3600}, saturday_8{monday_8.seconds + 5 * 86400};
  const ControllerSettings always = controller_settings(site_of(""));
  const ControllerSettings office =
      controller_settings(site_of("[ahu]\nfan_start = \"06:00\"\nfan_end = \"20:00\"\nweekday_only = true\n"));
  for (const CivilTime t : {monday_8, night, saturday_8}) EXPECT_TRUE(air_flows(always, t, std::nan("")));
  EXPECT_TRUE(air_flows(office, monday_8, std::nan("")));
  EXPECT_FALSE(air_flows(office, night, std::nan("")));
  EXPECT_FALSE(air_flows(office, saturday_8, std::nan("")));
  EXPECT_TRUE(air_flows(office, night, 1)) << "a point goes before the schedule";
  EXPECT_FALSE(air_flows(office, monday_8, 0));
  expect_complaint({"ahu.fan_end", "06:00", "fan_start before fan_end", "ahu_on"},
                   [] { (void)site_of("[ahu]\nfan_start = \"06:00\"\nfan_end = \"06:00\"\n"); });
}

TEST(SiteSettings, ASetpointOutsideTheLimitsIsMovedInStepsUnlessTheSiteSaysJump) {
  EXPECT_EQ(controller_settings(site_of("")).outside_jump, 0);
  EXPECT_EQ(controller_settings(site_of("[setpoint]\noutside = \"jump\"\n")).outside_jump, 1);
  expect_complaint({"setpoint.outside", "leap", "one of step, jump", ""},
                   [] { (void)site_of("[setpoint]\noutside = \"leap\"\n"); });
}

TEST(SiteSettings, TakeTheRegistersStepsFromThePointMap) {
  const SiteFile site = site_of("");
  EXPECT_EQ(controller_settings(site, map_of(usual)).register_step_k, 0.01);
  EXPECT_EQ(controller_settings(site, map_of(usual)).readback_step_k, 0.01);
  EXPECT_EQ(
      controller_settings(site, map_of("int16,big,big,-0.5,40,8,32,,,0x8000,on-change,6,18,self")).register_step_k,
      0.5);
  const std::string map =
      replaced(default_point_map(5, 5, 2), "setpoint,degc,3,0,int16,big,big,0.01,0,8,32,,,0x8000,on-change,6",
               "setpoint,degc,3,8,float32,big,big,1,0,8,32,,,,on-change,16");
  EXPECT_EQ(controller_settings(site, PointMap::parse(map, "points.csv")).register_step_k, 0) << "a float holds any";
  EXPECT_EQ(controller_settings(site).register_step_k, 0) << "any value, where there is no map";
}

}  // namespace
}  // namespace airside::hal
