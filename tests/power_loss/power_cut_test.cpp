// The power goes while the real daemon works: whatever of its unsynced writes reaches the medium, and in whatever
// order, what is loaded afterwards is the old generation or the new one, byte for byte.
//   AIRSIDE_POWER_CUT_STATES=n   distinct states (8000); AIRSIDE_POWER_CUT_JOBS=n threads (1)
//   AIRSIDE_POWER_CUT_SECONDS=n  stops after so long; AIRSIDE_POWER_CUT_DAYS=n: days of the recorded life (1)
//   AIRSIDE_POWER_CUT_RING=1     the recorded life begins with a full ring, so that the journal wraps
#include "power_loss/power_cut.hpp"

#include <gtest/gtest.h>

#include "power_loss/daemon_desk.hpp"
#include "support/test_folder.hpp"

namespace airside::power_loss {
namespace {

using closed_loop::from_environment;

/// A daemon's life: first start, rows, kills at any call, pushed weights, their way back, midnights, a full log folder.
std::shared_ptr<const Trace> recorded_life(const std::string& name, int days, bool full_ring) {
  DaemonDesk desk(
      {.name = name, .days = days + 1, .expert_days = full_ring ? 43 : 1, .max_files = 3, .max_file_mb = 0.1});
  const std::string record = desk.file("writes").string();
  SplitMix64 draw(35);
  int row = 0, pushed = 0;
  const auto rows = [&](int n) {
    row += n;
    const DaemonRun run = desk.run(row, {.record = record}, true);
    EXPECT_EQ(run.code, 0) << desk.said();
  };
  // Killed starts read on where the one before left off; each dies some calls after it began to write.
  const auto kills = [&](int n) {
    for (int i = 0; i < n; ++i) {
      const std::string at = std::to_string(30 + draw.below(90)) + ":" + std::to_string(draw.below(3));
      (void)desk.run(row + 200, {.record = record, .kill = at}, true);
    }
    row += 200;
    const DaemonRun run = desk.run(row, {.record = record}, true);
    EXPECT_EQ(run.code, 0) << desk.said();
    row += 0;
  };
  rows(7);
  for (int day = 0; day < days; ++day) {
    desk.push(++pushed, record);
    rows(5);
    desk.wish("rollback", record);
    rows(4);
    desk.push(++pushed, record);
    kills(12);
    rows(4);
    desk.push(++pushed, record);  // while the one before is on trial
    rows(3);
    const int rest = (day + 1) * rows_per_day + 4 - row;
    if (rest > 0) rows(rest);
  }
  return Trace::read(record);
}

void expect_old_or_new(const CutCounts& counts) {
  for (const std::string& finding : counts.findings) ADD_FAILURE() << finding;
  EXPECT_EQ(counts.all_findings, 0u);
  std::printf(
      "%llu crash points, %llu states made, %llu distinct (%llu exhaustive), %llu of slots and journal alone; old "
      "generation %llu, new %llu, none yet %llu; logs %llu, copies %llu; %.0f s\n",
      static_cast<unsigned long long>(counts.crash_points), static_cast<unsigned long long>(counts.made),
      static_cast<unsigned long long>(counts.distinct), static_cast<unsigned long long>(counts.exhaustive),
      static_cast<unsigned long long>(counts.distinct_store), static_cast<unsigned long long>(counts.old_generation),
      static_cast<unsigned long long>(counts.new_generation), static_cast<unsigned long long>(counts.before_first),
      static_cast<unsigned long long>(counts.logs), static_cast<unsigned long long>(counts.copies), counts.seconds);
}

CutOptions options() {
  CutOptions o;
  o.states = static_cast<std::uint64_t>(from_environment("AIRSIDE_POWER_CUT_STATES", 8000));
  o.jobs = from_environment("AIRSIDE_POWER_CUT_JOBS", 1);
  o.seconds = from_environment("AIRSIDE_POWER_CUT_SECONDS", 100'000);
  o.seed = static_cast<std::uint64_t>(from_environment("AIRSIDE_POWER_CUT_SEED", 1));
  if (o.states < 100'000) {
    o.most_states = o.states;
    o.stride = 7;
    o.most_of_point = 10;
  }
  return o;
}

TEST(PowerCut, Row34Row35WhateverReachedTheMediumIsTheOldGenerationOrTheNew) {
  const auto life = recorded_life("life", from_environment("AIRSIDE_POWER_CUT_DAYS", 1),
                                  from_environment("AIRSIDE_POWER_CUT_RING", 0) != 0);
  const CutCounts counts = cut_power(*life, options());
  expect_old_or_new(counts);
  EXPECT_GT(counts.old_generation, 100u);
  EXPECT_GT(counts.new_generation, 2u);
}

/// Rows in which weights come, are taken back, and come again while others are on trial.
std::shared_ptr<const Trace> recorded_exchanges(const std::string& name) {
  DaemonDesk desk({.name = name, .days = 1, .max_files = 3, .max_file_mb = 0.1});
  const std::string record = desk.file("writes").string();
  const auto rows = [&](int to) { EXPECT_EQ(desk.run(to, {.record = record}, true).code, 0) << desk.said(); };
  rows(3);
  desk.push(1, record);
  rows(4);
  desk.push(2, record);
  rows(5);
  desk.wish("rollback", record);
  rows(6);
  desk.push(3, record);
  rows(7);
  EXPECT_TRUE(std::filesystem::is_empty(desk.box() / "inbox"));
  EXPECT_NE(desk.status().find("\"pushed_weights\":\"on trial\""), std::string::npos) << desk.status();
  return Trace::read(record);
}

TEST(PowerCut, Row50ACutDuringAnExchangeLeavesWeightsAndCounterTogetherAndThePushInTheInboxUntilThen) {
  CutOptions o = options();
  o.stride = 1;
  if (o.most_states == o.states) o.states = o.most_states = 2 * o.states;
  expect_old_or_new(cut_power(*recorded_exchanges("exchange"), o));
}

TEST(PowerCut, Row50WithoutACutWeightsComeAndGoAndTheInboxIsEmpty) { (void)recorded_exchanges("exchange_calm"); }

/// The scripted writer's life: steps of all kinds, and kills.
std::shared_ptr<const Trace> recorded_script(const std::string& name, int steps) {
  const hal::TestFolder folder(name);
  const std::string box = folder.file("box").string(), record = folder.file("writes").string();
  std::filesystem::create_directory(box);
  ::setenv("LD_PRELOAD", (std::string(AIRSIDE_BIN_DIR) + "/libairside_io_probe.so").c_str(), 1);
  ::setenv("AIRSIDE_IO_ROOT", box.c_str(), 1);
  ::setenv("AIRSIDE_IO_LOG", record.c_str(), 1);
  SplitMix64 draw(17);
  for (int done = 0; done < steps; done += 25) {
    const bool killed = done % 50 == 25;
    if (killed) ::setenv("AIRSIDE_IO_KILL", (std::to_string(100 + draw.below(150)) + ":1").c_str(), 1);
    closed_loop::Child writer({std::string(AIRSIDE_BIN_DIR) + "/script_writer", box, "25"}, folder.file("said"));
    const int code = writer.wait(60).value_or(-1);
    EXPECT_TRUE(code == 0 || (killed && code == 128 + SIGKILL)) << code;
    ::unsetenv("AIRSIDE_IO_KILL");
  }
  for (const char* variable : {"LD_PRELOAD", "AIRSIDE_IO_ROOT", "AIRSIDE_IO_LOG"}) ::unsetenv(variable);
  return Trace::read(record);
}

TEST(PowerCut, Row34Row35RecordsOfAFewSectorsInEveryOrder) {
  CutOptions o = options();
  o.scripted = true;
  if (o.most_states == o.states) o.states = o.most_states = 3 * o.states;
  const CutCounts counts = cut_power(*recorded_script("script", o.stride == 1 ? 4000 : 200), o);
  expect_old_or_new(counts);
  EXPECT_GT(counts.new_generation, 2u);
}

TEST(PowerCut, Row34WithoutACutEveryGenerationIsTheNewOne) {
  const auto life = recorded_life("calm", 1, false);
  // The same life, but every write reaches the medium as soon as it is made.
  Trace calm;
  for (const Trace::Op& op : life->ops) {
    calm.ops.push_back(op);
    if (op.kind == IoKind::write || op.kind == IoKind::truncate || op.kind == IoKind::allocate) {
      calm.ops.push_back(
          {.kind = IoKind::sync_file, .name = {}, .to = {}, .inode = op.inode, .offset = 0, .payload = {}});
    }
  }
  CutOptions all = options();
  all.stride = 1;
  all.states = 0;
  const CutCounts counts = cut_power(calm, all);
  for (const std::string& finding : counts.findings) ADD_FAILURE() << finding;
}

/// The same daemon, had it forgotten to sync one kind of file.
CutCounts without_sync_of(const Trace& life, const std::string& prefix) {
  Trace careless;
  std::map<std::uint64_t, bool> forgotten;
  for (const Trace::Op& op : life.ops) {
    if (op.kind == IoKind::create) forgotten[op.inode] = op.name.compare(0, prefix.size(), prefix) == 0;
    if (op.kind == IoKind::sync_file && forgotten[op.inode]) continue;
    careless.ops.push_back(op);
  }
  CutOptions few = options();
  few.states = few.most_states = 8000;  // fewer end before the first push
  few.stride = 7;
  few.until_found = true;
  return cut_power(careless, few);
}

/// The campaign can fail: each kind of file whose sync is left out is noticed.
TEST(PowerCut, ForgottenSyncsAreFound) {
  const auto life = recorded_life("careless", 1, false);
  for (const char* prefix : {"state/row.", "state/learning.", "state/replay.", "state/previous", "log/"}) {
    EXPECT_GT(without_sync_of(*life, prefix).all_findings, 0u) << prefix;
  }
}

}  // namespace
}  // namespace airside::power_loss
