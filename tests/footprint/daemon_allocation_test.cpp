// Once it runs, the daemon asks nothing of the heap: not for rows, learning, durable commits, the status, weights that
// are pushed, nor for a new day's log.

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "footprint/daemon_here.hpp"
#include "hal/weights/blob_file.hpp"
#include "hal/weights/signature.hpp"
#include "support/allocation_guard.hpp"
#include "support/default_cycle.hpp"
#include "support/program.hpp"

namespace airside::footprint {
namespace {

using closed_loop::Bench;

template <Topology T>
void expect_no_heap(const std::string& name, std::size_t rows, const char* more_site = "") {
  Bench bench({.name = name,
               .topology = T::name,
               .plant = closed_loop::rc_room(),
               .expert_days = 1,
               .days = 3,
               .more_site = more_site});
  std::filesystem::create_directories(bench.file("inbox"));
  DaemonHere here(bench, rows);
  here.daemon().start();
  here.settle(4);
  std::ofstream(bench.file("inbox") / "read-points").close();
  std::ofstream(bench.file("inbox") / "check-write").close();
  const std::size_t before = bench.logged_rows();
  const std::uint64_t pushed = here.daemon().transitions();
  AllocationGuard guard("the daemon's rows");
  const int code = here.daemon().run();
  const HeapEvents events = guard.disarm();
  EXPECT_EQ(code, 0);
  EXPECT_EQ(events.total(), 0U) << "first: " << events.first << " of " << events.first_bytes << " bytes";
  EXPECT_EQ(bench.logged_rows(), rows);
  EXPECT_GT(rows - before, 240U) << "no midnight was crossed";
  EXPECT_GT(here.daemon().transitions(), pushed + 100) << "nothing was learned";
  EXPECT_TRUE(std::filesystem::exists(bench.file("state") / "status.json"));
  EXPECT_TRUE(std::filesystem::exists(bench.file("state") / "weights.blob")) << "none were given out";
  EXPECT_TRUE(std::filesystem::exists(bench.file("state") / "points.json")) << "no points were read";
  EXPECT_FALSE(std::filesystem::exists(bench.file("inbox") / "read-points"));
  EXPECT_FALSE(std::filesystem::exists(bench.file("inbox") / "check-write"));
  const std::string points = text_of_file(bench.file("state") / "points.json");
  EXPECT_NE(points.find("\"write\":{\"time\":"), std::string::npos) << points;
  EXPECT_NE(points.find("\"fault\":\"none\",\"before\":"), std::string::npos) << points;
  std::printf("%s: %zu rows without a heap event\n", T::name, rows - before);
  closed_loop::LogText log = bench.log();
  closed_loop::LogText expected = bench.expected();
  expected.rows.resize(rows);
  closed_loop::expect_same_rows(log, expected);
}

TEST(DaemonHeap, IsNotTouchedByHundredsOfRowsTwoMidnightsAndLearning) { expect_no_heap<FiveZone>("heap5", 640); }

TEST(DaemonHeap, IsNotTouchedInASmallSuite) { expect_no_heap<ThreeVav>("heap3", 360, closed_loop::brief_learning); }

TEST(DaemonHeap, GuardSeesAStart) {
  Bench bench({.name = "heap_start",
               .plant = closed_loop::rc_room(),
               .expert_days = 1,
               .days = 1,
               .more_site = closed_loop::brief_learning});
  DaemonHere here(bench, 240);
  AllocationGuard guard("the daemon's start");
  here.daemon().start();
  EXPECT_GT(guard.disarm().total(), 10U);
}

TEST(DaemonHeap, IsNotTouchedWhileThePlantIsAway) {
  Bench bench({.name = "heap_away",
               .plant = closed_loop::rc_room(),
               .expert_days = 1,
               .days = 1,
               .more_site = closed_loop::brief_learning});
  DaemonHere here(bench, 240);
  here.daemon().start();
  here.settle(4);
  bench.stop_server();
  auto& wired = dynamic_cast<edge::Daemon<FiveZone>&>(here.daemon());
  AllocationGuard guard("a row without a plant");
  const Expected<Reading<FiveZone>> nothing = tl::unexpected(Fault::no_reading);
  for (int i = 0; i < 4; ++i) {
    const CivilTime t{wired.controller().decision().time.seconds + (i + 1) * cycle_s};
    EXPECT_TRUE(wired.row(t, nothing, wired.controller()));
  }
  const HeapEvents events = guard.disarm();
  EXPECT_EQ(events.total(), 0U) << "first: " << events.first << " of " << events.first_bytes << " bytes";
}

TEST(DaemonHeap, IsNotTouchedByPushedWeightsGoodOrBadNorByAWayBack) {
  Bench bench({.name = "heap_push",
               .plant = closed_loop::rc_room(),
               .expert_days = 1,
               .days = 1,
               .more_site = closed_loop::brief_learning});
  for (const char* part : {"keys", "inbox"}) std::filesystem::create_directories(bench.file(part));
  const hal::SecretKey key = hal::make_key("Ann");
  std::ofstream(bench.file("keys") / "ann.pub") << hal::public_key_text(key.open);
  std::ofstream(bench.file("keys") / "spoilt.pub") << "no key";
  std::ofstream(bench.file("keys") / "revoked") << "0011223344556677\n";
  std::vector<std::byte> blob = hal::read_blob_file(bench.file("weights.blob").string());
  hal::write_blob_file(bench.file("unsigned").string(), blob);
  hal::sign_blob(blob, key, 10);
  hal::write_blob_file(bench.file("signed").string(), blob);
  std::ofstream(bench.file("wish")).close();
  DaemonHere here(bench, 240);
  here.daemon().start();
  here.settle(4);
  bench.stop_server();
  auto& wired = dynamic_cast<edge::Daemon<FiveZone>&>(here.daemon());
  const std::string moves[3][2] = {{bench.file("unsigned").string(), bench.file("inbox/a.blob").string()},
                                   {bench.file("signed").string(), bench.file("inbox/b.blob").string()},
                                   {bench.file("wish").string(), bench.file("inbox/rollback").string()}};
  AllocationGuard guard("rows with a push");
  const Expected<Reading<FiveZone>> nothing = tl::unexpected(Fault::no_reading);
  int moved = 0;
  for (int i = 0; i < 6; ++i) {
    if (i % 2 == 0) moved += ::rename(moves[i / 2][0].c_str(), moves[i / 2][1].c_str()) == 0;
    const CivilTime t{wired.controller().decision().time.seconds + (i + 1) * row_s};
    EXPECT_TRUE(wired.row(t, nothing, wired.controller()));
  }
  const HeapEvents events = guard.disarm();
  EXPECT_EQ(moved, 3);
  EXPECT_EQ(events.total(), 0U) << "first: " << events.first << " of " << events.first_bytes << " bytes";
  std::ifstream status(bench.file("state") / "status.json");
  const std::string text{std::istreambuf_iterator<char>(status), {}};
  EXPECT_NE(text.find("\"pushed_weights\":\"rolled back\""), std::string::npos) << text;
  EXPECT_TRUE(std::filesystem::exists(bench.file("inbox") / "refused"));
}

TEST(DaemonHeap, IsNotTouchedByStateThatComesLate) {
  Bench bench({.name = "heap_late",
               .plant = closed_loop::rc_room(),
               .expert_days = 1,
               .days = 1,
               .more_site = closed_loop::brief_learning});
  DaemonHere here(bench, 240);
  here.daemon().start();
  here.settle(4);
  bench.stop_server();
  const std::string state = bench.file("state").string(), kept = bench.file("kept").string(),
                    away = bench.file("away").string();
  std::filesystem::copy(state, kept, std::filesystem::copy_options::recursive);
  auto& wired = dynamic_cast<edge::Daemon<FiveZone>&>(here.daemon());
  const Expected<Reading<FiveZone>> nothing = tl::unexpected(Fault::no_reading);
  ::testing::internal::CaptureStderr();
  AllocationGuard guard("rows around a state that comes");
  const bool moved = ::rename(state.c_str(), away.c_str()) == 0 && ::rename(kept.c_str(), state.c_str()) == 0;
  for (int i = 0; i < 4; ++i) {
    const CivilTime t{wired.controller().decision().time.seconds + (i + 1) * row_s};
    EXPECT_TRUE(wired.row(t, nothing, wired.controller()));
  }
  const HeapEvents events = guard.disarm();
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_TRUE(moved);
  EXPECT_NE(said.find("resuming after row"), std::string::npos) << said;
  EXPECT_EQ(events.total(), 0U) << "first: " << events.first << " of " << events.first_bytes << " bytes";
}

}  // namespace
}  // namespace airside::footprint
