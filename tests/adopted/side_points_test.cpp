// Signals beside the network's inputs, from a plant's sensors to a reading; no engine takes part.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim/side_points.hpp"
#include "sim/simulated_plant.hpp"

namespace airside::sim {
namespace {

hal::PointMap map_with(const std::string& rows) {
  return hal::PointMap::parse(hal::default_point_map(3, 0, 1) + rows, "points.csv");
}

constexpr const char* side_rows =
    "damper_1,,4,200,uint16,big,big,0.001,0,0,1,,,0xFFFF,,,,\n"
    "damper_3,,4,201,uint16,big,big,0.001,0,0,1,,,0xFFFF,,,,\n"
    "zone_setpoint_2,degc,4,202,uint16,big,big,0.01,0,0,60,,,0xFFFF,,,,\n"
    "occupied,,4,203,uint16,big,big,1,0,0,1,,,0xFFFF,,,,\n"
    "supply_flow,m3/s,4,204,uint16,big,big,0.001,0,0,60,,,0xFFFF,,,,\n"
    "ahu_on,,3,205,uint16,big,big,1,0,0,1,,,0xFFFF,on-change,6,1,self\n";

TEST(SidePoints, PassThroughTheirRegisters) {
  const hal::PointMap map = map_with(side_rows);
  Sensors s;
  s.damper = {0.30049, not_shown, 1.5};
  s.zone_setpoint_degc = {24, 26.699, 24};
  s.occupied = 1;
  s.supply_flow_m3s = 2.34567;
  s.ahu_on = 0;
  Reading<ThreeVav> reading;
  SidePoints<ThreeVav>(map).fill(s, reading);
  EXPECT_NEAR(reading.damper(0), 0.3, 1e-12);
  EXPECT_TRUE(std::isnan(reading.damper(1))) << "the map has no such point";
  EXPECT_TRUE(std::isnan(reading.damper(2))) << "more than open is no position";
  EXPECT_TRUE(std::isnan(reading.zone_setpoint_degc(0)));
  EXPECT_NEAR(reading.zone_setpoint_degc(1), 26.7, 1e-12);
  EXPECT_EQ(reading.occupied, 1);
  EXPECT_NEAR(reading.supply_flow_m3s, 2.346, 1e-12);
  EXPECT_EQ(reading.flows, 0);
}

TEST(SidePoints, ShowTheRegistersFirstContentWhereThePlantOffersNothing) {
  const hal::PointMap map = map_with(side_rows);
  Reading<ThreeVav> reading;
  SidePoints<ThreeVav>(map).fill(Sensors{}, reading);
  EXPECT_EQ(reading.flows, 1) << "the default of the point";
  EXPECT_TRUE(std::isnan(reading.occupied));
  EXPECT_TRUE(std::isnan(reading.supply_flow_m3s));
  EXPECT_TRUE(std::isnan(reading.damper(0)));
}

TEST(PointValue, KnowsEveryPointThatASensorHas) {
  Sensors s;
  s.room_temp_degc = {20, 21, 22};
  s.power_kw = {3};
  s.damper = {0.5, not_shown};
  s.supply_temp_degc = 14;
  s.occupied = 1;
  EXPECT_EQ(point_value(s, "room_temp_3"), 22);
  EXPECT_EQ(point_value(s, "room_temp_2b"), 21) << "one of a zone's several sensors";
  EXPECT_TRUE(std::isnan(point_value(s, "room_temp_4").value_or(0))) << "an input that the plant lacks is no value";
  EXPECT_EQ(point_value(s, "power_1"), 3);
  EXPECT_EQ(point_value(s, "damper_1"), 0.5);
  EXPECT_EQ(point_value(s, "damper_2"), std::nullopt);
  EXPECT_EQ(point_value(s, "damper_1b"), std::nullopt);
  EXPECT_EQ(point_value(s, "supply_temp"), 14);
  EXPECT_EQ(point_value(s, "occupied"), 1);
  EXPECT_EQ(point_value(s, "ahu_on"), std::nullopt);
  EXPECT_EQ(point_value(s, "heartbeat"), std::nullopt);
}

}  // namespace
}  // namespace airside::sim
