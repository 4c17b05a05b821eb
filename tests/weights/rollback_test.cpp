// The way back from pushed weights: to those before or to the schedule, by itself or by a person's wish, whatever the
// disk does meanwhile.

#include <thread>

#include "hal/storage/state_copy.hpp"
#include "support/default_cycle.hpp"
#include "weights/trial_rig.hpp"

namespace airside::weights {
namespace {

using WayBack = Trial;

TEST(CopyOfTheState, IsNotBlockedByAFolderThatIsGone) {
  // Of which the state itself complains.
  EXPECT_TRUE(hal::StateCopy("no/such/folder", 7, hal::Sync::none).blocked());
}

TEST_F(WayBack, WeightsThatNobodyPushedAreNotTakenBack) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> standing = rig.controller->learning().weights;
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.state, TrialState::none);
  EXPECT_TRUE(rig.same_weights(standing));
  rig.cycles(2);
  EXPECT_LT(rig.decision().mode, ControlMode::expert);
}

TEST_F(WayBack, AnotherPushDuringATrialKeepsTheWayBackThatWasProven) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  push(other(2, 0.8F));
  ASSERT_TRUE(row());
  wish("rollback");
  ASSERT_TRUE(row());
  EXPECT_TRUE(rig.same_weights(before));
}

TEST_F(WayBack, NothingIsLearnedFromACycleBegunInOtherUnits) {
  while (starts_cycle(rig.now)) rig.row();
  push(other(1));
  ASSERT_TRUE(row());
  rig.cycles(1);
  ASSERT_NE(rig.controller->cycle().has_features, 0);
  wish("rollback");
  ASSERT_TRUE(row());
  EXPECT_EQ(rig.controller->cycle().has_features, 0);
}

TEST_F(WayBack, AfterAWayBackTheBarIsThatOfTheWeightsInUse) {
  inside(*rig.controller).cycle.network_error_k2 = 0.04;
  push(other(1));
  ASSERT_TRUE(row());
  inside(*rig.controller).cycle.network_error_k2 = 3.6;  // what bad weights leave
  wish("rollback");
  ASSERT_TRUE(row());
  EXPECT_EQ(rig.controller->cycle().network_error_k2, record.before_error_k2);
  EXPECT_LT(record.before_error_k2, 1.0);
}

TEST_F(WayBack, TheScheduleIsAWayBackThatNeedsNoCopy) {
  inside(*rig.controller).cycle.has_weights = 0;
  push(other(1));
  ASSERT_TRUE(row());
  std::filesystem::remove(folder.file("state") / "previous");
  wish("rollback");
  EXPECT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::rolled_back);
  rig.cycles(2);
  EXPECT_EQ(rig.decision().reason, Reason::no_weights);
}

TEST_F(WayBack, WhereTheWayBackCannotBeWrittenThePushWaitsInTheInbox) {
  std::filesystem::create_directories(folder.file("state") / "previous.new");
  push(other(1));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(row());
  EXPECT_EQ(record.refusal, Fault::state_invalid);
  EXPECT_TRUE(std::filesystem::exists(folder.file("inbox") / "weights.blob"));
  EXPECT_EQ(record.state, TrialState::none);
  std::filesystem::remove(folder.file("state") / "previous.new");
  EXPECT_TRUE(row());
  EXPECT_EQ(record.refusal, Fault::none);
  EXPECT_TRUE(std::filesystem::is_empty(folder.file("inbox")));
}

TEST_F(WayBack, AnOperatorMayTakeThemBackAndARestartInBetweenChangesNothing) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  open();  // the daemon was restarted: the way back lies on the disk
  rows(10);
  wish("rollback");
  EXPECT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_TRUE(rig.same_weights(before));
}

TEST_F(WayBack, AWayBackThatCannotBeReadOnceIsReadByTheNextRow) {
  const auto previous = folder.file("state") / "previous", away = folder.file("state") / "away";
  for (const bool comes_back : {true, false}) {
    while (starts_cycle(rig.now)) row();
    const NetworkWeights<T, float> before = rig.controller->learning().weights;
    push(other(comes_back ? 1 : 2));
    ASSERT_TRUE(row());
    std::filesystem::rename(previous, away);
    std::filesystem::create_directory(previous);  // which cannot be read
    wish("rollback");
    EXPECT_TRUE(row());
    EXPECT_EQ(record.state, TrialState::on_trial);
    EXPECT_EQ(rig.controller->cycle().has_weights, 0) << "meanwhile nobody asks those that go";
    if (comes_back) {
      std::filesystem::remove(previous);
      std::filesystem::rename(away, previous);
      wish("rollback");  // asked again in the row that succeeds
      EXPECT_TRUE(row());
    }
    if (!comes_back) rows(3);
    EXPECT_EQ(record.state, TrialState::rolled_back);
    EXPECT_EQ(record.tries_back, 0u);
    EXPECT_EQ(rig.controller->cycle().has_weights, comes_back ? 1 : 0);
    EXPECT_EQ(rig.same_weights(before), comes_back);
  }
}

TEST_F(WayBack, ConfirmedWeightsStayWhileTheWayBackCannotBeRead) {
  push(other(1));
  ASSERT_TRUE(row());
  record.state = TrialState::confirmed;
  std::filesystem::remove(folder.file("state") / "previous");
  std::filesystem::create_directory(folder.file("state") / "previous");
  for (std::uint32_t tries = 1; tries <= hal::Mailbox::patience; ++tries) {
    wish("rollback");  // asked again or not, each row tries once
    EXPECT_TRUE(row());
    EXPECT_EQ(record.tries_back, tries);
    EXPECT_EQ(rig.controller->cycle().has_weights, 1);
  }
  EXPECT_FALSE(row());
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_EQ(record.refusal, Fault::no_way_back);
  EXPECT_EQ(rig.controller->cycle().has_weights, 1);
}

TEST_F(WayBack, WhatIsNoFileInPlaceOfTheCopyIsReportedByEachCommitUntilItIsRemoved) {
  rig.row();
  ASSERT_TRUE(trial->committed()) << "a box to which nothing was pushed has no copy";
  for (const char* name : {"previous.new", "previous"}) {
    const auto place = folder.file("state") / name;
    std::filesystem::create_directories(place / "full");
    for (int i = 0; i < 2; ++i) {
      const hal::StoreResult<void> reported = trial->committed();
      ASSERT_FALSE(reported) << name;
      EXPECT_EQ(reported.error().fault, hal::StoreFault::wrong_kind);
    }
    std::filesystem::remove_all(place);
    EXPECT_TRUE(trial->committed()) << name;
  }
}

TEST_F(WayBack, ADamagedCopyIsNoWayBackAndHarmsNothing) {
  push(other(1));
  ASSERT_TRUE(row());
  std::fstream copy(folder.file("state") / "previous", std::ios::in | std::ios::out | std::ios::binary);
  copy.seekp(5000);
  copy.put('x');
  copy.put('y');
  copy.close();
  while (starts_cycle(rig.now)) row();
  const NetworkWeights<T, float> standing = rig.controller->learning().weights;
  record.state = TrialState::confirmed;
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_TRUE(rig.same_weights(standing));
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_EQ(record.refusal, Fault::no_way_back) << "for the status";
  record.state = TrialState::on_trial;
  wish("rollback");
  EXPECT_TRUE(row()) << "what is on trial goes";
  EXPECT_EQ(record.state, TrialState::rolled_back);
  rig.cycles(2);
  EXPECT_EQ(rig.decision().reason, Reason::no_weights) << "the schedule";
}

TEST_F(WayBack, APushThatIsTakenBackBeforeItWasTriedLeavesTheWeightsAlone) {
  push(other(1));
  ASSERT_TRUE(row());
  record.state = TrialState::confirmed;
  while (starts_cycle(rig.now)) row();
  const NetworkWeights<T, float> standing = rig.controller->learning().weights;
  push(other(2, 0.8F));
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_EQ(record.refusal, Fault::blob_taken_back);
  EXPECT_TRUE(rig.same_weights(standing));
  wish("rollback");
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // files' times have the grain of the kernel's clock
  push(other(2, 0.8F));
  EXPECT_TRUE(row()) << "first back, then on with the new ones";
  EXPECT_EQ(record.state, TrialState::on_trial);
}

TEST_F(WayBack, AWayBackIsOneTooWhereTheBlobInUseStillLiesInTheInbox) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  rig.row();
  ASSERT_TRUE(trial->row({rig.now.seconds - row_s}, *rig.controller, record));
  open();  // the daemon ended between the commit and the taking away
  wish("rollback");
  EXPECT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_TRUE(rig.same_weights(before));
}

TEST_F(WayBack, AskedTwiceItGoesBackOnce) {
  push(other(1));
  ASSERT_TRUE(row());
  wish("rollback");
  EXPECT_TRUE(row());
  wish("rollback");
  EXPECT_FALSE(row());
  EXPECT_EQ(record.state, TrialState::rolled_back);
}

TEST_F(WayBack, AWayBackThatHoldsNoNumbersIsTheSchedule) {
  while (starts_cycle(rig.now)) rig.row();
  inside(*rig.controller).learning.weights.values[5] = std::nanf("");
  push(signed_by(blob_of<T>(*rig.controller, [](auto& p) { p.weights[5] = 0; }), key, 1));
  ASSERT_TRUE(row()) << text_of(record.refusal) << ' ' << record.refusal_field.data();
  wish("rollback");
  EXPECT_TRUE(row());
  rig.cycles(1);
  EXPECT_EQ(rig.decision().reason, Reason::no_weights);
}

}  // namespace
}  // namespace airside::weights
