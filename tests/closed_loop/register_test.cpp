// A register that holds few setpoints: each one written is its own, within the site's limits, and the AHU is not
// blamed.

#include <fmt/format.h>

#include <cmath>

#include "hal/log/log_csv.hpp"
#include "support/bench.hpp"

namespace airside::closed_loop {
namespace {

struct Register {
  const char* name;
  double step_k, offset_degc;
};

class CoarseRegister : public ::testing::TestWithParam<Register> {};

TEST_P(CoarseRegister, HoldsEachSetpointOfTheDaemonAsOfTheSimulationWithinTheLimits) {
  const auto& [name, step_k, offset_degc] = GetParam();
  Bench bench{{.name = name,
               .plant = rc_room(),
               .expert_days = 1,
               .days = 1,
               .setpoint_point = fmt::format("setpoint,degc,3,0,int16,big,big,{},{},8,40,,,0x8000,on-change,6,18,self",
                                             step_k, offset_degc),
               .more_site = "[setpoint]\nmin_degc = 20.4\nmax_degc = 24.6\n"}};
  const LogText expected = bench.expected();
  bench.start_server();
  const auto daemon = bench.start_daemon();
  ASSERT_EQ(daemon->wait(100), 0) << daemon->said();
  expect_same_rows(bench.log(), expected);
  int altered = 0, moves = 0;
  double last = bench.run().rows.front().setpoint_degc;
  for (const hal::LogRow& row : bench.run().rows) {
    EXPECT_GE(row.setpoint_degc, 20.4 - 1e-9);
    EXPECT_LE(row.setpoint_degc, 24.6 + 1e-9);
    const double n = (row.setpoint_degc - offset_degc) / step_k;
    EXPECT_NEAR(n, std::round(n), 1e-6);
    altered += row.controller.reason == "setpoint altered" ? 1 : 0;
    moves += row.setpoint_degc != last ? 1 : 0;
    last = row.setpoint_degc;
  }
  EXPECT_EQ(altered, 0);
  EXPECT_GT(moves, 3) << "it is controlled all the same";
  EXPECT_EQ(daemon->said().find("another setpoint"), std::string::npos) << daemon->said();
}

INSTANTIATE_TEST_SUITE_P(OfAnAhu, CoarseRegister,
                         ::testing::Values(Register{"whole_degc", 1, 0}, Register{"half_degc", 0.5, 0},
                                           Register{"whole_degf", 0.5555556, -17.777778}),
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace airside::closed_loop
