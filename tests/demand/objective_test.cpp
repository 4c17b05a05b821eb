// A site that asks for an objective which its points do not carry is refused.

#include <gtest/gtest.h>

#include <string>

#include "hal/site/objective.hpp"
#include "hal/site/site_file.hpp"
#include "hal/site/site_settings.hpp"
#include "support/complaint.hpp"

namespace {

using namespace airside;
using namespace airside::hal;

/// A room of three boxes, with so many dampers and zone setpoints.
PointMap map_with(int dampers, int setpoints, int powers = 1) {
  std::string csv = default_point_map(3, 0, powers);
  int addr = 900;
  const auto add = [&](const std::string& name, const std::string& unit, const std::string& range) {
    csv += name + "," + unit + ",4," + std::to_string(addr++) + ",int16,big,big,0.01,0," + range + ",,1200,,,,,\n";
  };
  for (int i = 1; i <= dampers; ++i) add("damper_" + std::to_string(i), "", "0,1");
  for (int i = 1; i <= setpoints; ++i) add("zone_setpoint_" + std::to_string(i), "degc", "5,45");
  return PointMap::parse(csv, "points.csv");
}

/// The example of a site file with another objective, and overrides.
SiteFile site_with(const std::string& objective, const std::string& overrides = "") {
  std::string text = example_site_text("3vav-0fcu-1power");
  text = replaced(text, "objective = \"mean\"", "objective = \"" + objective + "\"");
  text = replaced(text, "# move_penalty = 0.1\n", overrides);
  return parse_site_text(text, "site.toml", site_rules());
}

TEST(SiteObjective, IsMeanUnlessTheFileSaysBand) {
  EXPECT_EQ(SiteFile{}.objective, Objective::mean);
  EXPECT_EQ(site_with("mean").objective, Objective::mean);
  EXPECT_EQ(controller_settings(site_with("band")).objective, Objective::band);
  expect_complaint({"objective", "energy", "band", ""}, [] { (void)site_with("energy"); });
}

TEST(SiteObjective, ItsNumbersAreOverridesLikeAnyOther) {
  const SiteFile site = site_with("band", "band_k = 1.0\nband_fan_meter = 2\n");
  EXPECT_EQ(controller_settings(site).demand.band_k, 1.0);
  EXPECT_EQ(controller_settings(site).demand.fan_meter, 2);
  expect_complaint({"band_k", "9", "", ""}, [] { (void)site_with("band", "band_k = 9.0\n"); });
}

TEST(SiteObjective, ASiteFileThatAsksForItIsRefusedByTheSameRuleAsItsRegisters) {
  expect_complaint({"site.toml: [controller] objective", "damper_1", "a damper and a zone setpoint a room", "\"mean\""},
                   [] { refuse_contradiction(site_with("band"), map_with(0, 3)); });
  EXPECT_NO_THROW(refuse_contradiction(site_with("band"), map_with(3, 3)));
}

TEST(SiteObjective, BandIsTakenWhereEveryRoomShowsDamperAndSetpoint) {
  EXPECT_NO_THROW(refuse_objective(Objective::band, map_with(3, 3), 3, "site.toml: objective"));
}

TEST(SiteObjective, BandIsRefusedWithEveryMissingPoint) {
  expect_complaint({"site.toml: objective", "damper_3", "a damper and a zone setpoint a room", "objective = \"mean\""},
                   [] { refuse_objective(Objective::band, map_with(2, 3), 3, "site.toml: objective"); });
  expect_complaint({"site.toml: objective", "zone_setpoint_1, zone_setpoint_2, zone_setpoint_3", "zone setpoint",
                    "keep the AHU's own reset"},
                   [] { refuse_objective(Objective::band, map_with(3, 0), 3, "site.toml: objective"); });
}

TEST(SiteObjective, MeanNeedsNoneOfThem) {
  EXPECT_NO_THROW(refuse_objective(Objective::mean, map_with(0, 0), 3, "site.toml: objective"));
}

}  // namespace
