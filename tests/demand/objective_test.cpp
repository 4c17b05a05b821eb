// A site that asks for an objective which its points do not carry is refused.

#include <gtest/gtest.h>

#include <string>

#include "hal/site/objective.hpp"
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
  for (int i = 1; i <= dampers; ++i) add("damper_" + std::to_string(i), "1", "0,1");
  for (int i = 1; i <= setpoints; ++i) add("zone_setpoint_" + std::to_string(i), "degc", "5,45");
  return PointMap::parse(csv, "points.csv");
}

TEST(SiteObjective, IsMeanOrBandAndNothingElse) {
  EXPECT_EQ(parse_objective("mean", "site.toml"), Objective::mean);
  EXPECT_EQ(parse_objective("band", "site.toml"), Objective::band);
  expect_complaint({"site.toml:12: objective", "\"energy\"", "\"mean\" or \"band\"", "where boxes modulate"},
                   [] { (void)parse_objective("energy", "site.toml:12: objective"); });
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
