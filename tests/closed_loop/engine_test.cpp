// On EnergyPlus, too, the daemon over Modbus and the simulation in one process write the same log.

#include <gtest/gtest.h>

#include "sim/energyplus/install.hpp"
#include "support/bench.hpp"

namespace airside::closed_loop {
namespace {

TEST(ClosedLoopOnEnergyPlus, DaemonDecidesAsTheSimulationToTheBit) {
  if (!sim::have_energyplus()) {
    GTEST_SKIP() << "\n*** EnergyPlus is not installed: run tools/setup, or set AIRSIDE_VENV or AIRSIDE_ENERGYPLUS. "
                    "This test checked nothing. ***";
  }
  tools::PlantChoice room = rc_room("401");
  room.kind = "energyplus";
  Bench bench({.name = "engine", .plant = room, .expert_days = 1, .days = from_environment("AIRSIDE_ENGINE_DAYS", 4)});
  bench.start_server();
  const auto daemon = bench.start_daemon();
  const LogText& expected = bench.expected();  // beside the daemon's run, on another core
  ASSERT_EQ(expected.rows.size(), bench.rows());
  ASSERT_EQ(daemon->wait(600), 0) << daemon->said();
  expect_same_rows(bench.log(), expected);
}

}  // namespace
}  // namespace airside::closed_loop
