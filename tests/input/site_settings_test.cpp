// Site file and point map must not contradict one another.

#include "hal/site/site_settings.hpp"

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
