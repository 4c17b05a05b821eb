// Media that are full, read-only or rotten under the real daemon, and state of which parts are of different
// generations.
//   AIRSIDE_EVERY_BIT=1   flips every bit of the row records instead of a sample
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "firmware/edge/daemon.hpp"
#include "power_loss/daemon_desk.hpp"

namespace airside::power_loss {
namespace {

namespace fs = std::filesystem;
using closed_loop::from_environment;
using Box = edge::Daemon<FiveZone>;

/// A small disk of its own at the box's folder, for this thread and its children; gone at the end.
class SmallDisk {
 public:
  explicit SmallDisk(const fs::path& at) : at_(at) {
    mounted_ = ::unshare(CLONE_NEWNS) == 0 && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
               ::mount("tmpfs", at_.c_str(), "tmpfs", 0, "size=8m") == 0;
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(at_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool mounted() const { return mounted_; }
  bool read_only(bool on) const {
    return ::mount("tmpfs", at_.c_str(), "tmpfs", MS_REMOUNT | (on ? MS_RDONLY : 0), "size=8m") == 0;
  }
  void fill() const {
    std::ofstream filler(at_ / "filler", std::ios::binary);
    const std::string block(4096, 'x');
    while (filler.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  }
  void empty() const { fs::remove(at_ / "filler"); }

 private:
  fs::path at_;
  bool mounted_ = false;
};

/// Setpoints of an undisturbed daemon for so many rows, started anew where the other one is.
std::map<std::int64_t, double> calm_setpoints(DaemonDesk& desk, std::initializer_list<int> stops) {
  desk.reset();
  for (const int row : stops) EXPECT_EQ(desk.run(row).code, 0) << desk.said();
  EXPECT_NE(desk.status().find("\"storage\":\"ok\""), std::string::npos);
  const auto setpoints = desk.setpoints();
  desk.reset();
  desk.forget_words();
  return setpoints;
}

TEST(FullDisk, Row32OnAFullDiskControlGoesOnWithAnAlarmUntilThereIsRoom) {
  DaemonDesk desk({.name = "disk_full", .days = 1});
  const SmallDisk disk(desk.box());
  if (!disk.mounted()) GTEST_SKIP() << "this machine does not let tests mount a small disk";
  const auto calm = calm_setpoints(desk, {6, 30, 40});
  ASSERT_EQ(desk.run(6).code, 0);
  disk.fill();
  ASSERT_EQ(desk.run(30).code, 0) << desk.said();
  EXPECT_NE(desk.said().find("disk full"), std::string::npos) << desk.said();
  const auto status = nlohmann::json::parse(desk.status(), nullptr, false);
  EXPECT_EQ(status["storage"], "disk full");
  ASSERT_FALSE(status["alarms"].empty()) << desk.status();
  EXPECT_EQ(status["alarms"][0]["reason"], "storage failed");
  EXPECT_EQ(status["generation"], 30) << "the slots' space was reserved: state is written all the same";
  disk.empty();
  ASSERT_EQ(desk.run(40).code, 0);
  EXPECT_NE(desk.status().find("\"storage\":\"ok\""), std::string::npos);
  EXPECT_EQ(desk.setpoints(), calm);
}

TEST(FullDisk, Row32AFirstStartWithoutRoomRunsInMemoryAndWritesStateAsSoonAsItCan) {
  DaemonDesk desk({.name = "disk_none", .days = 1});
  const SmallDisk disk(desk.box());
  if (!disk.mounted()) GTEST_SKIP() << "this machine does not let tests mount a small disk";
  const auto calm = calm_setpoints(desk, {12});
  disk.fill();
  ASSERT_EQ(desk.run(12).code, 0) << desk.said();
  EXPECT_NE(desk.said().find("each row tries again"), std::string::npos) << desk.said();
  EXPECT_EQ(desk.setpoints(), calm) << desk.said() << desk.rows().size();
  disk.empty();
  ASSERT_EQ(desk.run(20).code, 0);
  EXPECT_NE(desk.status().find("\"storage\":\"ok\""), std::string::npos);
}

TEST(ReadOnlyDisk, Row33AReadOnlyMediumStillGivesItsStateAndControlGoesOn) {
  DaemonDesk desk({.name = "disk_ro", .days = 1});
  const SmallDisk disk(desk.box());
  if (!disk.mounted()) GTEST_SKIP() << "this machine does not let tests mount a small disk";
  auto calm = calm_setpoints(desk, {6, 30});
  ASSERT_EQ(desk.run(6).code, 0);
  ASSERT_TRUE(disk.read_only(true));
  ASSERT_EQ(desk.run(30).code, 0) << desk.said();
  EXPECT_NE(desk.said().find("not writable"), std::string::npos) << desk.said();
  EXPECT_NE(desk.said().find("resuming after row"), std::string::npos) << desk.said();
  EXPECT_EQ(desk.setpoints(), calm);
  EXPECT_EQ(desk.rows().size(), 6u) << "the old state and log stand";
  ASSERT_TRUE(disk.read_only(false));
  ASSERT_EQ(desk.run(40).code, 0);
  EXPECT_NE(desk.status().find("\"storage\":\"ok\""), std::string::npos);
}

TEST(ReadOnlyDisk, Row33WithoutAFaultTheSmallDiskIsLikeAnyOther) {
  DaemonDesk desk({.name = "disk_calm", .days = 1});
  const auto anywhere = calm_setpoints(desk, {6, 30});
  const SmallDisk disk(desk.box());
  if (!disk.mounted()) GTEST_SKIP() << "this machine does not let tests mount a small disk";
  EXPECT_EQ(calm_setpoints(desk, {6, 30}), anywhere);
}

/// What a generation's parts are.
struct Parts {
  std::uint64_t row = 0, learning = 0, replay = 0;
  bool operator==(const Parts&) const = default;
};

/// A box of twenty rows, with every generation's parts, and its folder as it was after some of them.
class RottenBox : public ::testing::Test {
 protected:
  RottenBox() {
    desk.run(11);
    for (int until = 12; until <= 20; ++until) {
      EXPECT_EQ(desk.run(until).code, 0) << desk.said();
      const auto loaded = load();
      parts[loaded->generation] = now();
      if (until == 13) desk.keep("older");
    }
    desk.keep("good");
    desk.forget_words();
  }
  hal::StoreResult<hal::LoadedState> load() {
    auto store = hal::DurableStore::open((desk.box() / "state").c_str(), layout, hal::Sync::none);
    EXPECT_TRUE(store.has_value());
    auto loaded = store->load({learning, row, replay});
    // Beyond its count load() leaves the ring as it is.
    const std::size_t used = loaded ? static_cast<std::size_t>(loaded->replay_count) * layout.transition_bytes : 0;
    std::fill(replay.begin() + static_cast<std::ptrdiff_t>(used), replay.end(), std::byte{0});
    return loaded;
  }
  Parts now() const { return {hal::digest64(row), hal::digest64(learning), hal::digest64(replay)}; }
  /// Whatever was found is one generation, whole.
  void expect_one(const hal::StoreResult<hal::LoadedState>& loaded, const std::string& where) {
    ASSERT_TRUE(loaded.has_value()) << where;
    ASSERT_NE(loaded->outcome, hal::LoadOutcome::none) << where;
    const auto found = parts.find(loaded->generation);
    ASSERT_NE(found, parts.end()) << where << ": generation " << loaded->generation;
    ASSERT_EQ(hal::digest64(row), found->second.row) << where;
    ASSERT_EQ(hal::digest64(learning), found->second.learning) << where;
    if (loaded->outcome == hal::LoadOutcome::replay_incomplete) return;
    ASSERT_EQ(hal::digest64(replay), found->second.replay) << where;
  }
  void flip(const std::string& name, std::size_t bit) const {
    std::fstream file(desk.box() / "state" / name, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(bit / 8));
    const int byte = file.get();
    file.seekp(static_cast<std::streamoff>(bit / 8));
    file.put(static_cast<char>(byte ^ (1 << (bit % 8))));
  }

  DaemonDesk desk{{.name = "rot", .days = 1}};
  const hal::StoreLayout layout = edge::DaemonState<FiveZone>::layout(capacity_of<FiveZone>());
  std::vector<std::byte> learning = std::vector<std::byte>(layout.learning_bytes);
  std::vector<std::byte> row = std::vector<std::byte>(layout.row_bytes);
  std::vector<std::byte> replay = std::vector<std::byte>(layout.transition_bytes * layout.ring_capacity);
  std::map<std::uint64_t, Parts> parts;
};

TEST_F(RottenBox, Row36AnyRottenBitLeavesAWholeGeneration) {
  const bool every = from_environment("AIRSIDE_EVERY_BIT", 0) != 0;
  SplitMix64 draw(36);
  std::map<hal::LoadOutcome, int> outcomes;
  int flips = 0;
  for (const char* name : {"row.a", "row.b", "learning.a", "learning.b", "replay.a", "replay.b"}) {
    const std::size_t bits = fs::file_size(desk.box() / "state" / name) * 8;
    const bool is_row = std::string(name).starts_with("row");
    const std::size_t tries = is_row && every ? bits : every ? 5000 : 150;
    for (std::size_t i = 0; i < tries; ++i) {
      const std::size_t bit = is_row && every ? i : draw.below(static_cast<std::uint32_t>(bits));
      flip(name, bit);
      const auto loaded = load();
      expect_one(loaded, std::string(name) + " bit " + std::to_string(bit));
      if (HasFatalFailure()) return;
      ++outcomes[loaded->outcome];
      flip(name, bit);
      ++flips;
    }
  }
  EXPECT_GT(outcomes[hal::LoadOutcome::newest], 0);
  EXPECT_GT(outcomes[hal::LoadOutcome::older], 0);
  std::printf("%d bits flipped: newest %d, older %d, replay incomplete %d\n", flips, outcomes[hal::LoadOutcome::newest],
              outcomes[hal::LoadOutcome::older], outcomes[hal::LoadOutcome::replay_incomplete]);
}

TEST_F(RottenBox, Row36WithoutRotTheNewestIsLoaded) {
  const auto loaded = load();
  ASSERT_TRUE(loaded.has_value());
  EXPECT_EQ(loaded->outcome, hal::LoadOutcome::newest);
  EXPECT_EQ(loaded->generation, 20u);
  EXPECT_EQ(loaded->damaged_records, 0u);
  EXPECT_EQ(now(), parts.at(20));
}

TEST_F(RottenBox, Row37WithAllSlotsRottenTheScheduleRunsWithAnAlarm) {
  for (const char* name : {"row.a", "row.b", "learning.a", "learning.b"}) flip(name, 5000);
  ASSERT_EQ(desk.run(23).code, 0);
  EXPECT_NE(desk.said().find("no saved generation is whole"), std::string::npos) << desk.said();
  EXPECT_NE(desk.said().find("starting from"), std::string::npos) << "the shipped weights";
  const auto status = nlohmann::json::parse(desk.status(), nullptr, false);
  EXPECT_EQ(status["state"], "expert") << status.dump();
  EXPECT_EQ(status["reason"], text_of(Reason::state_lost)) << status.dump();
}

TEST_F(RottenBox, Row37WithoutRotItResumes) {
  ASSERT_EQ(desk.run(23).code, 0);
  const auto status = nlohmann::json::parse(desk.status(), nullptr, false);
  EXPECT_EQ(status["state"], "learn") << status.dump();
  EXPECT_TRUE(status["alarms"].empty()) << status.dump();
}

TEST_F(RottenBox, StateOfAnotherVersionIsKeptAsideAndTheScheduleRunsWithAnAlarm) {
  hal::StoreLayout other = layout;
  other.meaning ^= 1;
  fs::remove_all(desk.box() / "state");
  {
    auto store = hal::DurableStore::open((desk.box() / "state").c_str(), other, hal::Sync::none);
    ASSERT_TRUE(store.has_value());
    ASSERT_TRUE(store->load({learning, row, replay}).has_value());
    ASSERT_TRUE(store->commit({.learning = learning, .row = row, .replay = replay, .log = {}}).has_value());
  }
  ASSERT_EQ(desk.run(23).code, 0);
  EXPECT_NE(desk.said().find("kept there as other-*"), std::string::npos) << desk.said();
  const auto status = nlohmann::json::parse(desk.status(), nullptr, false);
  EXPECT_EQ(status["state"], "expert") << status.dump();
  EXPECT_EQ(status["reason"], text_of(Reason::state_lost)) << status.dump();
  EXPECT_EQ(status["storage"], "ok") << status.dump();
  EXPECT_EQ(fs::file_size(desk.box() / "state" / "other-learning.a"),
            fs::file_size(desk.box() / "state" / "learning.a"));
  EXPECT_TRUE(load().has_value()) << "and what was learned since is saved";
  // A start that was cut off before its first row leaves kept files and nothing else: still an alarm.
  for (const char* name : {"row.a", "row.b", "learning.a", "learning.b"}) fs::remove(desk.box() / "state" / name);
  ASSERT_EQ(desk.run(26).code, 0);
  EXPECT_EQ(nlohmann::json::parse(desk.status(), nullptr, false)["reason"], text_of(Reason::state_lost));
}

TEST_F(RottenBox, Row38AnyMixtureOfOlderAndNewerFilesIsLoadedAsOneGeneration) {
  const char* names[6] = {"row.a", "row.b", "learning.a", "learning.b", "replay.a", "replay.b"};
  int none = 0;
  for (unsigned mask = 0; mask < 64; ++mask) {
    for (unsigned i = 0; i < 6; ++i) {
      const fs::path from = desk.file((mask >> i & 1) != 0 ? "older" : "good") / "state" / names[i];
      fs::copy_file(from, desk.box() / "state" / names[i], fs::copy_options::overwrite_existing);
    }
    const auto loaded = load();
    ASSERT_TRUE(loaded.has_value());
    if (loaded->outcome == hal::LoadOutcome::none) {
      ++none;
      continue;
    }
    expect_one(loaded, "mixture " + std::to_string(mask));
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(none, 0) << "a learning record brings its own row along";
}

TEST_F(RottenBox, Row38WithoutAMixtureTheOlderFolderIsItsOwnGeneration) {
  fs::remove_all(desk.box());
  fs::copy(desk.file("older"), desk.box(), fs::copy_options::recursive);
  const auto loaded = load();
  ASSERT_TRUE(loaded.has_value());
  EXPECT_EQ(loaded->outcome, hal::LoadOutcome::newest);
  EXPECT_EQ(loaded->generation, 13u);
  EXPECT_EQ(now(), parts.at(13));
}

}  // namespace
}  // namespace airside::power_loss
