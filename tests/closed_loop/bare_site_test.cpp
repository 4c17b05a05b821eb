// A site with room temperatures, setpoint and outdoor temperature alone is controlled, over Modbus as in one process.

#include "support/bench.hpp"

namespace airside::closed_loop {
namespace {

hal::StandIns all_but_outdoor_temp() {
  hal::StandIns in;
  in.set("rain", 0);
  in.set("mau_temp", 18);
  in.set("power", 4);
  in.set("vav_on", 1);
  in.set("fcu_temp", 25);
  in.set("fcu_on", 0);
  return in;
}

TEST(BareSite, IsControlledByTheDaemonAsInTheSimulationAndItsLogSaysWhatIsNotMeasured) {
  Bench bench{{.name = "bare",
               .plant = rc_room(),
               .expert_days = 1,
               .days = 1,
               .stand_ins = all_but_outdoor_temp(),
               .more_points = "ahu_on,,3,40,uint16,big,big,1,0,0,1,,,0xFFFF,,,,\n",
               .more_site = brief_learning}};
  const LogText expected = bench.expected();
  EXPECT_NE(expected.header.find(",power_1_kw_stand_in,power_2_kw_stand_in,mau_temp_degc_stand_in,outdoor_temp_degc,"
                                 "rain_stand_in,"),
            std::string::npos)
      << expected.header;
  EXPECT_NE(expected.header.find(",supply_temp_degc,ahu_on,mode,"), std::string::npos) << expected.header;
  bench.start_server();
  const auto daemon = bench.start_daemon();
  ASSERT_EQ(daemon->wait(200), 0) << daemon->said();
  EXPECT_EQ(bench.log().header, expected.header);
  expect_same_rows(bench.log(), expected);
  int controlled = 0;
  for (const hal::LogRow& row : bench.run().rows) controlled += row.controller.mode == "learn" ? 1 : 0;
  EXPECT_GT(controlled, rows_per_day - 20);
  EXPECT_GT(tools::metrics_of(bench.trial().site, bench.run()).hvac_kwh, 24.0) << "by the plant's own meters";
}

}  // namespace
}  // namespace airside::closed_loop
