// Kills a real process that commits and logs in a loop, at random instants, and looks at what it left.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <new>
#include <thread>

#include "airside/splitmix64.hpp"
#include "hal/log/row_log.hpp"
#include "power_loss/state_script.hpp"
#include "support/test_folder.hpp"

namespace airside::hal {
namespace {

const TopologyCounts counts = counts_of<ThreeVav>();

LogRow row_of_step(std::uint64_t step) {
  LogRow row = make_log_row(counts);
  row.time = {1625097600 + static_cast<std::int64_t>(step) * row_s};
  for (std::size_t j = 0; j < row.value.size(); ++j) row.value[j] = j >= 3 && j < 6 ? 1.0 : 20.0;
  row.value.back() = 0;
  row.setpoint_degc = static_cast<double>(200000 + step % 60000) / 1e4;
  row.controller.mode = "learn";
  return row;
}

/// Restores, goes on as the daemon does, and tells after each commit how far it came; never returns.
[[noreturn]] void run_child(const StoreLayout& layout, const TestFolder& folder, Sync sync,
                            std::atomic<std::uint64_t>& committed) {
  auto store = DurableStore::open(folder.file("state").c_str(), layout, sync);
  auto log = RowLog::open(folder.file("log").c_str(), counts, {.max_files = 4000}, sync);
  StateScript script(layout, 10000000);
  if (!store || !log) std::_Exit(2);
  const auto loaded = store->load(script.buffers());
  if (!loaded) std::_Exit(3);
  if (loaded->outcome != LoadOutcome::none) {
    if (loaded->outcome != LoadOutcome::newest || !script.is_whole(loaded->replay_count)) std::_Exit(4);
    script.resume(loaded->replay_count);
    if (!log->resume(loaded->log)) std::_Exit(5);
  }
  while (true) {
    script.advance();
    const auto appended = log->append(row_of_step(script.step));
    // Before the first commit there is no position to resume from: the row already stands there.
    if (!appended && !(script.step == 1 && appended.error().fault == StoreFault::out_of_order)) std::_Exit(6);
    if (!log->sync()) std::_Exit(7);
    StoredState state = script.stored();
    state.log = log->position();
    if (!store->commit(state)) std::_Exit(8);
    committed.store(script.step);
  }
}

/// On a slow machine few children would get to a commit: every second one is given the time for one.
void wait_for_a_commit(const std::atomic<std::uint64_t>& committed, pid_t child) {
  const std::uint64_t before = committed.load();
  for (int ms = 0; ms < 30000 && committed.load() == before; ++ms) {
    ASSERT_EQ(::waitpid(child, nullptr, WNOHANG), 0) << "the restarted process gave up";
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void kill_and_look(const StoreLayout& layout, Sync sync, int kills, int longest_us) {
  const TestFolder folder("kill");
  void* shared =
      ::mmap(nullptr, sizeof(std::atomic<std::uint64_t>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  auto& committed = *new (shared) std::atomic<std::uint64_t>(0);
  SplitMix64 random(99);
  for (int kill_number = 0; kill_number < kills; ++kill_number) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) run_child(layout, folder, sync, committed);
    if (kill_number % 2 == 1) wait_for_a_commit(committed, child);
    std::this_thread::sleep_for(std::chrono::microseconds(200 + random.below(static_cast<std::uint32_t>(longest_us))));
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the restarted process gave up with code " << WEXITSTATUS(status);

    const std::uint64_t promised = committed.load();
    auto store = DurableStore::open(folder.file("state").c_str(), layout, sync);
    ASSERT_TRUE(store.has_value()) << describe(store.error());
    StateScript script(layout, 10000000);
    const auto loaded = store->load(script.buffers());
    ASSERT_TRUE(loaded.has_value());
    if (loaded->outcome == LoadOutcome::none) {
      ASSERT_EQ(promised, 0u);
      continue;
    }
    ASSERT_TRUE(script.is_whole(loaded->replay_count)) << "kill " << kill_number;
    const std::uint64_t step = script.step_in_row();
    ASSERT_TRUE(step == promised || step == promised + 1) << step << " after " << promised;
    // The reader sees every committed row once; what the killed process wrote beyond it is cut at the next start.
    auto log = RowLog::open(folder.file("log").c_str(), counts, {.max_files = 4000}, sync);
    ASSERT_TRUE(log.has_value());
    ASSERT_TRUE(log->resume(loaded->log).has_value());
    ASSERT_EQ(log->last_time(), row_of_step(step).time);
  }
  ASSERT_GE(committed.load(), static_cast<std::uint64_t>(kills) / 2) << "the child hardly ran";
  const Log log = read_log(folder.file("log").string(), counts);
  ASSERT_TRUE(log.summary.gaps.empty());
  for (std::size_t i = 0; i < log.rows.size(); ++i) {
    const LogRow want = row_of_step(i + 1);
    ASSERT_EQ(log.rows[i].time, want.time);
    ASSERT_EQ(log.rows[i].setpoint_degc, want.setpoint_degc);
  }
  testing::Test::RecordProperty("commits", static_cast<int>(committed.load()));
  ::munmap(shared, sizeof(std::atomic<std::uint64_t>));
}

int wanted_kills(int otherwise) {
  const char* text = std::getenv("AIRSIDE_KILLS");
  return text != nullptr ? std::atoi(text) : otherwise;
}

TEST(KillNine, ManySmallCommitsLoseNoRowAndDoubleNone) {
  kill_and_look({.learning_bytes = 200, .row_bytes = 64, .transition_bytes = 24, .ring_capacity = 50, .meaning = 3},
                Sync::none, wanted_kills(60), 6000);
}

TEST(KillNine, CommitsOfTheSizeOfARealRoomSurvive) {
  kill_and_look(
      {.learning_bytes = 650000, .row_bytes = 3000, .transition_bytes = 204, .ring_capacity = 1000, .meaning = 4},
      Sync::full, wanted_kills(25), 20000);
}

TEST(KillNine, ASecondProcessIsTurnedAwayAndAKilledOneLeavesNoLock) {
  const TestFolder folder("lock");
  const StoreLayout layout{
      .learning_bytes = 8, .row_bytes = 8, .transition_bytes = 8, .ring_capacity = 2, .meaning = 5};
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const auto store = DurableStore::open(folder.c_str(), layout);
    (void)!::write(ready[1], "x", 1);
    while (store) ::pause();
    std::_Exit(1);
  }
  char c = 0;
  ASSERT_EQ(::read(ready[0], &c, 1), 1);
  const auto second = DurableStore::open(folder.c_str(), layout);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().fault, StoreFault::locked);
  EXPECT_NE(describe(second.error()).find("another process uses it"), std::string::npos);
  EXPECT_NE(describe(second.error()).find("stop the other process"), std::string::npos);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(DurableStore::open(folder.c_str(), layout).has_value());
}

}  // namespace
}  // namespace airside::hal
