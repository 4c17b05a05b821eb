// The medium itself: full, limited, not writable; and the promise that a running store takes no heap.
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <functional>

#include "hal/log/row_log.hpp"
#include "power_loss/allocation_count.hpp"
#include "power_loss/state_script.hpp"
#include "support/test_folder.hpp"

namespace airside::hal {
namespace {

const StoreLayout layout{.learning_bytes = 4000,
                         .row_bytes = 300,
                         .transition_bytes = 40,
                         .ring_capacity = 20,
                         .spare_slots = 8,
                         .meaning = 6};
const TopologyCounts counts = counts_of<ThreeVav>();
constexpr int not_possible_here = 77;

/// Runs `body` in a process of its own, since it changes limits, mounts or users; its result is the exit code.
int in_child(const std::function<int()>& body) {
  const pid_t child = ::fork();
  if (child == 0) std::_Exit(body());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

#define CHECK_IN_CHILD(condition)                                                    \
  do {                                                                               \
    if (!(condition)) {                                                              \
      std::fprintf(stderr, "%s:%d: not true: %s\n", __FILE__, __LINE__, #condition); \
      return 1;                                                                      \
    }                                                                                \
  } while (false)

LogRow row_at(int i) {
  LogRow row = make_log_row(counts);
  row.time = {1625097600 + std::int64_t{row_s} * i};
  for (double& value : row.value) value = 0.5;
  row.setpoint_degc = 21;
  return row;
}

bool set_file_limit(rlim_t bytes) {
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{bytes, RLIM_INFINITY};
  return ::setrlimit(RLIMIT_FSIZE, &limit) == 0;
}

TEST(Medium, AFileSizeLimitIsADiskFullAndTheLogGoesOnAfterwards) {
  const TestFolder folder("limit");
  const int result = in_child([&] {
    auto log = RowLog::open(folder.c_str(), counts);
    CHECK_IN_CHILD(log.has_value());
    for (int i = 0; i < 3; ++i) CHECK_IN_CHILD(log->append(row_at(i)).has_value());
    const LogPosition before = log->position();
    CHECK_IN_CHILD(set_file_limit(before.bytes + 20));
    for (int i = 0; i < 3; ++i) {
      const auto done = log->append(row_at(3));
      CHECK_IN_CHILD(!done.has_value() && done.error().fault == StoreFault::no_space);
      CHECK_IN_CHILD(log->position() == before);
    }
    CHECK_IN_CHILD(std::filesystem::file_size(folder.file("airside-2021-07-01.csv")) == before.bytes);
    CHECK_IN_CHILD(set_file_limit(RLIM_INFINITY));
    CHECK_IN_CHILD(log->append(row_at(3)).has_value());
    return 0;
  });
  ASSERT_EQ(result, 0);
}

TEST(Medium, AStoreThatFindsNoRoomSaysSoAndCommitsAsSoonAsThereIsSome) {
  const TestFolder folder("no_room");
  const int result = in_child([&] {
    CHECK_IN_CHILD(set_file_limit(1000));
    auto store = DurableStore::open(folder.c_str(), layout);
    CHECK_IN_CHILD(store.has_value() && !store->ready() && store->ready().error().fault == StoreFault::no_space);
    StateScript script(layout);
    CHECK_IN_CHILD(store->load(script.buffers()).has_value());
    script.advance();
    const auto done = store->commit(script.stored());
    CHECK_IN_CHILD(!done.has_value() && done.error().fault == StoreFault::no_space);
    CHECK_IN_CHILD(set_file_limit(RLIM_INFINITY));
    CHECK_IN_CHILD(store->commit(script.stored()).has_value() && store->ready().has_value());
    StateScript again(layout);
    CHECK_IN_CHILD(store->load(again.buffers()).has_value() && again.step_in_row() == 1);
    return 0;
  });
  ASSERT_EQ(result, 0);
}

TEST(Medium, OnAFullDiskAnOpenStoreGoesOnCommittingAndTheLogSaysSo) {
  const TestFolder folder("full");
  const int result = in_child([&] {
    if (::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        ::mount("tmpfs", folder.c_str(), "tmpfs", 0, "size=256k") != 0) {
      return not_possible_here;
    }
    auto store = DurableStore::open(folder.file("state").c_str(), layout);
    auto log = RowLog::open(folder.file("log").c_str(), counts);
    CHECK_IN_CHILD(store.has_value() && log.has_value());
    std::FILE* filler = std::fopen(folder.file("filler").c_str(), "wb");
    CHECK_IN_CHILD(filler != nullptr);
    const std::vector<char> block(4096, 'x');
    while (std::fwrite(block.data(), 1, block.size(), filler) == block.size() && std::fflush(filler) == 0) {
    }
    StateScript script(layout);
    for (int i = 0; i < 40; ++i) {
      script.advance();
      CHECK_IN_CHILD(store->commit(script.stored()).has_value());  // its space was reserved when it opened
    }
    const auto done = log->append(row_at(0));
    CHECK_IN_CHILD(!done.has_value() && done.error().fault == StoreFault::no_space);
    std::fclose(filler);
    std::filesystem::remove(folder.file("filler"));
    CHECK_IN_CHILD(log->append(row_at(0)).has_value());
    return 0;
  });
  if (result == not_possible_here) GTEST_SKIP() << "this machine does not let tests mount a small disk";
  ASSERT_EQ(result, 0);
}

TEST(Medium, AFolderThatMayNotBeWrittenIsNamedAtTheDoor) {
  const TestFolder folder("read_only");
  ASSERT_EQ(::chmod(folder.c_str(), 0555), 0);
  const int result = in_child([&] {
    if (::geteuid() == 0 && ::setuid(65534) != 0) return not_possible_here;  // root may write everywhere
    const auto store = DurableStore::open(folder.c_str(), layout);
    CHECK_IN_CHILD(store.has_value() && !store->ready() && store->ready().error().fault == StoreFault::read_only);
    CHECK_IN_CHILD(describe(store->ready().error()).find("make the folder writable") != std::string::npos);
    const auto log = RowLog::open(folder.c_str(), counts);
    CHECK_IN_CHILD(!log.has_value() && log.error().fault == StoreFault::read_only);
    return 0;
  });
  ::chmod(folder.c_str(), 0755);
  if (result == not_possible_here) GTEST_SKIP() << "cannot become an ordinary user";
  ASSERT_EQ(result, 0);
}

TEST(Medium, AFolderWhoseParentIsMissingIsNamedAsNotFound) {
  const TestFolder folder("missing");
  const auto store = DurableStore::open(folder.file("no/state").c_str(), layout);
  ASSERT_TRUE(store.has_value());
  ASSERT_FALSE(store->ready().has_value());
  EXPECT_EQ(store->ready().error().fault, StoreFault::not_found);
  const auto log = RowLog::open(folder.file("no/log").c_str(), counts);
  ASSERT_FALSE(log.has_value());
  EXPECT_EQ(log.error().fault, StoreFault::not_found);
}

TEST(Medium, NothingIsAllocatedAfterOpening) {
  if (!counts_allocations()) GTEST_SKIP() << "a sanitizer owns the heap";
  const TestFolder folder("heap");
  auto store = DurableStore::open(folder.file("state").c_str(), layout);
  auto log = RowLog::open(folder.file("log").c_str(), counts, {.max_files = 3, .max_file_bytes = 20000});
  ASSERT_TRUE(store.has_value() && log.has_value());
  StateScript script(layout);
  LogRow row = make_log_row(counts);
  const std::uint64_t before = allocations();
  for (int i = 0; i < 1000; ++i) {  // four midnights, full files and removals included
    script.advance();
    row.time = {1625097600 + std::int64_t{row_s} * i};
    for (double& value : row.value) value = 20.0 + 1.0 / (i + 1);
    row.controller.mode = i % 2 == 0 ? "learn" : "expert";
    row.controller.fault = "a fault with a text of more than 15 letters";
    ASSERT_TRUE(log->append(row).has_value());
    ASSERT_TRUE(log->sync().has_value());
    ASSERT_TRUE(store->commit(script.stored()).has_value());
  }
  EXPECT_EQ(allocations(), before);
  const std::vector<int> proof(100);  // the counter does count
  EXPECT_GT(allocations(), before) << proof.size();
}

}  // namespace
}  // namespace airside::hal
