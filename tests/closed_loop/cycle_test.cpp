// Sites whose control cycle is not 18 min: the room is held, the setpoint moves once a cycle, and the daemon does as
// the simulation.

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include "hal/text/input_error.hpp"
#include "support/bench.hpp"
#include "tools/run/training/pretraining.hpp"
#include "tools/run/training/transfer.hpp"

namespace airside::closed_loop {
namespace {

tools::Site site_of(int cycle_min) {
  tools::Site site = tools::built_in_site();
  site.settings.cycle_min = site.file.cycle_min = cycle_min;
  return site;
}

tools::BlobBytes pretrained(const tools::Site& site, int days) {
  const tools::PlantChoice twin = rc_room("301", "2021-07-01");
  const auto model = tools::make_plant(twin, site, days);
  return tools::pretrain(site, *model, {tools::start_of(twin).seconds + days * seconds_per_day}, {}).blob;
}

class OtherCycles : public ::testing::TestWithParam<int> {
 protected:
  tools::Site site_ = site_of(GetParam());
  ControlCycle cycle_ = control_cycle(site_.settings);
};

TEST_P(OtherCycles, TheRoomIsHeldByASetpointThatMovesOnceACycle) {
  tools::Trial trial{site_, rc_room("301-real"), 5, 3};
  const auto blob = pretrained(site_, 5);
  tools::Prepared prepared = tools::prepare(trial);
  const auto run = tools::run_controller(site_, *prepared.model, blob, prepared.history, prepared.until, 1);
  const tools::Metrics ours = tools::metrics_of(site_, run);
  tools::Prepared again = tools::prepare(trial);
  const tools::Metrics schedule = tools::metrics_of(site_, tools::run_method(trial, again, "expert"));
  std::printf("%d min: DAE %.3f, schedule %.3f degC\n", GetParam(), ours.dae_degc, schedule.dae_degc);
  EXPECT_LT(ours.dae_degc, 0.3);
  EXPECT_LT(ours.dae_degc, 0.3 * schedule.dae_degc);
  ASSERT_EQ(run.cycles.size(), 3U * static_cast<std::size_t>(cycle_.per_day()));
  EXPECT_NEAR(ours.days[0].samples, cycle_.per_day() / 2, 1);
  int moves = 0;
  double last_degc = run.rows.front().setpoint_degc;
  for (const hal::LogRow& row : run.rows) {
    if (row.setpoint_degc == last_degc) continue;
    EXPECT_TRUE(cycle_.starts(row.time)) << "between two decisions";
    EXPECT_EQ(row.controller.mode, "learn");
    last_degc = row.setpoint_degc;
    ++moves;
  }
  EXPECT_GT(moves, cycle_.per_day());
}

TEST_P(OtherCycles, PeersDecideOnceACycleAndHoldTheRoom) {
  for (const char* name : {"integral-5", "arx-rls", "mpc", "g36-site-i1", "floor-full"}) {
    tools::Trial trial{site_, rc_room("301-real"), 5, 2};
    tools::Prepared prepared = tools::prepare(trial);
    const auto run = tools::run_method(trial, prepared, name);
    const bool by_rows = std::string(name).starts_with("g36");
    for (std::size_t i = 1; i < run.rows.size(); ++i) {
      if (run.rows[i].setpoint_degc == run.rows[i - 1].setpoint_degc) continue;
      EXPECT_TRUE(by_rows || cycle_.starts(run.rows[i].time)) << name;
    }
    const double dae_degc = tools::metrics_of(site_, run).dae_degc;
    std::printf("%d min: %s %.3f degC\n", GetParam(), name, dae_degc);
    EXPECT_LT(dae_degc, by_rows ? 1.5 : 0.5) << name;
  }
}

TEST_P(OtherCycles, WeightsOfTheUsualCycleAreRefusedWithBothLengths) {
  const tools::Site usual = site_of(18);
  const auto of_usual = pretrained(usual, 2), of_other = pretrained(site_, 2);
  const auto complaint = [](const tools::Site& site, const tools::BlobBytes& blob) -> std::string {
    try {
      (void)tools::transfer(site, blob, {}, {});
    } catch (const hal::InputError& e) {
      return e.what();
    }
    return "";
  };
  const std::string own = std::to_string(GetParam()) + " min";
  const std::string said = complaint(site_, of_usual), turned = complaint(usual, of_other);
  for (const std::string& part : {std::string("cycle_min"), std::string("18 min"), own}) {
    EXPECT_NE(said.find(part), std::string::npos) << said;
    EXPECT_NE(turned.find(part), std::string::npos) << turned;
  }
}

TEST_P(OtherCycles, DaemonOverTcpDecidesAsTheSimulationToTheBit) {
  Bench bench({.name = "cycle", .plant = rc_room(), .expert_days = 2, .days = 2, .cycle_min = GetParam()});
  const LogText& expected = bench.expected();
  ASSERT_EQ(bench.run().cycles.size(), 2U * static_cast<std::size_t>(cycle_.per_day()));
  bench.start_server();
  const auto daemon = bench.start_daemon();
  ASSERT_EQ(daemon->wait(300), 0) << daemon->said();
  expect_same_rows(bench.log(), expected);
}

INSTANTIATE_TEST_SUITE_P(Minutes, OtherCycles, ::testing::Values(6, 12, 24));

TEST(OtherCycles, ADaemonDoesNotGoOnFromTheStateOfAnotherCycle) {
  Bench bench({.name = "cycle_state", .plant = rc_room(), .expert_days = 1, .days = 1, .cycle_min = 18});
  bench.start_server();
  ASSERT_EQ(bench.start_daemon(false, {"--until", "2021-08-02 06:00"})->wait(100), 0);
  std::ifstream in(bench.file("site.toml"));
  std::string text((std::istreambuf_iterator<char>(in)), {});
  in.close();
  const std::size_t at = text.find("cycle_min = 18");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 14, "cycle_min = 12");
  text.replace(text.find("[weights]\nblob = \"weights.blob\"\n"), 32, "");
  std::ofstream(bench.file("site.toml")) << text;
  const auto daemon = bench.start_daemon();
  ASSERT_EQ(daemon->wait(100), 0) << daemon->said();
  EXPECT_NE(daemon->said().find("state of another topology, control cycle or build"), std::string::npos)
      << daemon->said();
}

}  // namespace
}  // namespace airside::closed_loop
