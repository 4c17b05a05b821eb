// Files and folders of a store that are taken away, exchanged or out of reach while it is in use.

#include <gtest/gtest.h>

#include "power_loss/small_store.hpp"

namespace airside::hal {
namespace {

/// What somebody does to the files of a store in use.
class TakenAway : public ::testing::Test {
 protected:
  TakenAway() { advance(3); }
  void advance(int times) {
    for (int i = 0; i < times; ++i) {
      script.advance();
      ASSERT_TRUE(store.commit(script.stored()));
    }
  }
  StoreFault fault_of_commit() {
    script.advance();
    const auto done = store.commit(script.stored());
    return done ? StoreFault::none : done.error().fault;
  }
  /// The newest step that a start finds.
  std::uint64_t found() {
    store = open_store(TestFolder("store_taken_other"));  // releases the lock
    const Recovered r = recover(folder);
    EXPECT_TRUE(r.script.is_whole(r.loaded.replay_count));
    return r.script.step_in_row();
  }

  TestFolder folder{"store_taken"};
  DurableStore store = open_store(folder);
  StateScript script{layout};
};

TEST_F(TakenAway, FilesAreToldAndWrittenAnewWhicheverTheyAre) {
  std::uint64_t step = 3;
  for (const char* name : {"lock", "row.a", "row.b", "learning.a", "learning.b", "replay.a", "replay.b"}) {
    std::filesystem::remove(folder.file(name));
    EXPECT_EQ(fault_of_commit(), StoreFault::removed) << name;
    EXPECT_EQ(fault_of_commit(), StoreFault::none) << name;
    step += 2;
  }
  EXPECT_EQ(found(), step);
}

TEST_F(TakenAway, AFolderIsToldAndMadeAnew) {
  std::filesystem::remove_all(folder.c_str());
  EXPECT_EQ(fault_of_commit(), StoreFault::removed);
  EXPECT_EQ(fault_of_commit(), StoreFault::none);
  EXPECT_EQ(found(), 5u);
}

TEST_F(TakenAway, AFolderThatAnotherDaemonMadeAnewIsIts) {
  std::filesystem::remove_all(folder.c_str());
  const DurableStore other = open_store(folder);
  EXPECT_EQ(fault_of_commit(), StoreFault::removed);
  EXPECT_EQ(fault_of_commit(), StoreFault::locked);
}

TEST_F(TakenAway, StateThatWasPutInItsPlaceIsNotWrittenOver) {
  const TestFolder kept("store_taken_kept");
  std::filesystem::copy(folder.c_str(), kept.c_str(), std::filesystem::copy_options::recursive);
  advance(2);
  const std::string away = std::string(folder.c_str()) + ".away";
  std::filesystem::rename(folder.c_str(), away);
  std::filesystem::create_directory(folder.c_str());
  std::filesystem::copy(kept.c_str(), folder.c_str());
  EXPECT_EQ(fault_of_commit(), StoreFault::removed);
  EXPECT_EQ(fault_of_commit(), StoreFault::unread);
  StateScript loaded(layout);
  ASSERT_TRUE(store.load(loaded.buffers()));
  EXPECT_EQ(loaded.step_in_row(), 3u);
  std::filesystem::remove_all(away);
}

TEST_F(TakenAway, AFolderThatCouldNeverBeWrittenGivesWayToWhatIsPutInItsPlace) {
  store = open_store(TestFolder("store_taken_other"));  // releases the lock
  const std::string medium = std::string(folder.c_str()) + ".medium";
  std::filesystem::rename(folder.c_str(), medium);
  std::filesystem::create_directory(folder.c_str());
  std::filesystem::create_directory(folder.file("row.a"));
  DurableStore late = open_store(folder);
  EXPECT_FALSE(late.commit(script.stored()));
  std::filesystem::remove_all(folder.c_str());
  std::filesystem::rename(medium, folder.c_str());  // as one is mounted over a folder that was read-only
  const auto done = late.commit(script.stored());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, StoreFault::unread);
  StateScript loaded(layout);
  ASSERT_TRUE(late.load(loaded.buffers()));
  EXPECT_EQ(loaded.step_in_row(), 3u);
  EXPECT_TRUE(late.commit(script.stored()));
}

TEST_F(TakenAway, AFolderThatCannotBeLookedAtIsNotCalledAnother) {
  const std::string away = std::string(folder.c_str()) + ".away";
  std::filesystem::rename(folder.c_str(), away);
  std::filesystem::create_symlink(std::filesystem::path(folder.c_str()).filename(), folder.c_str());  // to itself
  EXPECT_EQ(fault_of_commit(), StoreFault::none);
  std::filesystem::remove(folder.c_str());
  std::filesystem::rename(away, folder.c_str());
  EXPECT_EQ(found(), 4u);
}

/// Records that stand on the medium and cannot be opened now.
class OutOfReach : public ::testing::Test {
 protected:
  static constexpr const char* names[4] = {"row.a", "row.b", "learning.a", "learning.b"};
  void hide() const {
    for (const char* name : names) {
      std::filesystem::rename(folder.file(name), folder.file(std::string(name) + ".kept"));
      std::filesystem::create_symlink(name, folder.file(name));  // to itself: neither there nor not there
    }
  }
  void show(bool as_they_were) const {
    for (const char* name : names) {
      std::filesystem::remove(folder.file(name));
      if (as_they_were) std::filesystem::rename(folder.file(std::string(name) + ".kept"), folder.file(name));
    }
  }
  TestFolder folder{"store_hidden"};
};

TEST_F(OutOfReach, AreLoadedBeforeTheyAreWrittenOver) {
  StateScript script(layout);
  script.advance();
  { ASSERT_TRUE(open_store(folder).commit(script.stored())); }
  hide();
  DurableStore store = open_store(folder);
  EXPECT_FALSE(store.ready());
  EXPECT_FALSE(store.commit(script.stored()));
  show(true);
  const auto done = store.commit(script.stored());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, StoreFault::unread);
  StateScript found(layout);
  const auto loaded = store.load(found.buffers());
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->outcome, LoadOutcome::newest);
  EXPECT_EQ(loaded->generation, 1u);
  EXPECT_TRUE(store.commit(script.stored()));
}

TEST_F(OutOfReach, AreNotWrittenOverWhereTheyAreOfAnotherTopologyUntilTheyWereSetAside) {
  StateScript script(layout);
  script.advance();
  { ASSERT_TRUE(open_store(folder).commit(script.stored())); }
  const auto kept = folder.image().at("row.a");
  hide();
  StoreLayout other = layout;
  other.meaning = 2;
  DurableStore store = open_store(folder, other);
  StateScript mine(other);
  mine.advance();
  EXPECT_FALSE(store.commit(mine.stored()));
  show(true);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(store.commit(mine.stored()).error().fault, StoreFault::unread);
  StateScript found(other);
  EXPECT_EQ(store.load(found.buffers()).error().fault, StoreFault::other_layout);
  ASSERT_TRUE(store.archive_foreign_state());
  EXPECT_TRUE(store.commit(mine.stored()));
  EXPECT_EQ(folder.image().at("other-row.a"), kept);
}

TEST_F(OutOfReach, AreWrittenWhereTheyHoldNothing) {
  { const DurableStore first = open_store(folder); }
  hide();
  DurableStore store = open_store(folder);
  StateScript script(layout);
  script.advance();
  EXPECT_FALSE(store.commit(script.stored()));
  show(false);
  EXPECT_TRUE(store.commit(script.stored()));
}

}  // namespace
}  // namespace airside::hal
