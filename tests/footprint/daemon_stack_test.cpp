// The daemon's whole loop stays within its stack budget: sense over Modbus, decide, actuate, learn, log,
// commit, status, a new day's file, and a row in which signed weights are pushed.

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "footprint/daemon_here.hpp"
#include "hal/weights/blob_file.hpp"
#include "hal/weights/signature.hpp"
#include "support/default_cycle.hpp"
#include "support/stack_probe.hpp"

namespace airside::footprint {
namespace {

using closed_loop::Bench;

constexpr std::size_t row_budget_bytes = 16 * 1024;
constexpr std::size_t push_budget_bytes = 32 * 1024;  ///< a key file is read, a signature checked, a blob decoded

/// `run` on a painted stack; the threads that it starts have stacks of their own.
template <class Run>
void expect_within(std::size_t budget, const char* what, Run&& run) {
  const std::size_t deepest = stack_used(run);
  std::printf("%s: %zu bytes of stack at most, budget %zu\n", what, deepest, budget);
  EXPECT_GT(deepest, 4096U) << "the probe saw nothing";
  EXPECT_LE(deepest, budget);
}

TEST(DaemonStack, HoldsADayOfRowsWithLearningAndAMidnight) {
  Bench bench({.name = "stack", .plant = closed_loop::rc_room(), .expert_days = 1, .days = 2});
  DaemonHere here(bench, 360);
  here.daemon().start();
  here.settle(4);
  const std::uint64_t pushed = here.daemon().transitions();
  int code = -1;
  expect_within(row_budget_bytes, "rows", [&] { code = here.daemon().run(); });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(bench.logged_rows(), 360U);
  EXPECT_GT(here.daemon().transitions(), pushed + 80) << "nothing was learned";
}

TEST(DaemonStack, HoldsARowWithPushedWeights) {
  Bench bench({.name = "stack_push", .plant = closed_loop::rc_room(), .expert_days = 1, .days = 1});
  for (const char* part : {"keys", "inbox"}) std::filesystem::create_directories(bench.file(part));
  const hal::SecretKey key = hal::make_key("Ann");
  std::ofstream(bench.file("keys") / "ann.pub") << hal::public_key_text(key.open);
  std::vector<std::byte> blob = hal::read_blob_file(bench.file("weights.blob").string());
  hal::sign_blob(blob, key, 10);
  DaemonHere here(bench, 240);
  here.daemon().start();
  here.settle(4);
  bench.stop_server();
  hal::write_blob_file(bench.file("inbox/a.blob").string(), blob);
  auto& wired = dynamic_cast<edge::Daemon<FiveZone>&>(here.daemon());
  const Expected<Reading<FiveZone>> nothing = tl::unexpected(Fault::no_reading);
  bool went_on = true;
  expect_within(push_budget_bytes, "a push", [&] {
    for (int i = 1; i <= 3; ++i) {
      const CivilTime t{wired.controller().decision().time.seconds + i * cycle_s};
      went_on = wired.row(t, nothing, wired.controller()) && went_on;
    }
  });
  EXPECT_TRUE(went_on);
  std::ifstream status(bench.file("state") / "status.json");
  const std::string text{std::istreambuf_iterator<char>(status), {}};
  EXPECT_NE(text.find("\"pushed_weights\":\"on trial\""), std::string::npos) << text;
}

}  // namespace
}  // namespace airside::footprint
