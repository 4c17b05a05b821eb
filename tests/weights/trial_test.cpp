// Pushed weights are taken in one commit and kept on trial for a day; what acts wildly is taken back by itself. Every
// row of the loop is the daemon's own code.

#include "support/default_cycle.hpp"
#include "weights/trial_rig.hpp"

namespace airside::weights {
namespace {

TEST_F(Trial, Row49WithoutItSoundWeightsAreConfirmedAfterADay) {
  const float before = first_weight();
  push(other(1));
  EXPECT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::on_trial);
  EXPECT_NE(first_weight(), before);
  rows(rows_per_day - 1);
  EXPECT_EQ(record.state, TrialState::on_trial);
  rows(2);
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
}

TEST_F(Trial, WithoutAPushNothingChanges) {
  ControllerRig undisturbed;
  undisturbed.cycles(6);
  for (int i = 0; i < 100; ++i) {
    row();
    undisturbed.row();
    ASSERT_EQ(rig.setpoint, undisturbed.setpoint) << i;
  }
  EXPECT_EQ(record.state, TrialState::none);
}

TEST_F(Trial, Row49AHeadThatForetellsTheRoomsBadlyIsTakenBack) {
  const typename RoomHead<T>::State before = rig.controller->learning().head.theta();
  while (starts_cycle(rig.now)) rig.row();
  // Within what a room could do, and so sure of itself that it does not learn better.
  push(signed_by(blob_of<T>(*rig.controller,
                            [](auto& p) {
                              for (int i = RoomHead<T>::regressors; i < RoomHead<T>::states; ++i) p.head_theta(i) = 3;
                              for (double& c : p.head_covariance) c *= 1e-6;
                            }),
                 key, 1));
  ASSERT_TRUE(row()) << text_of(record.refusal) << ' ' << record.refusal_field.data();
  EXPECT_EQ(record.took_head, 1u);
  int rows_on_trial = 0;
  for (; record.state == TrialState::on_trial && rows_on_trial < rows_per_day; ++rows_on_trial) row();
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_LE(rows_on_trial, 12 * rows_per_cycle);
  const typename RoomHead<T>::State after = rig.controller->learning().head.theta();
  EXPECT_LT((after - before).cwiseAbs().maxCoeff(), 0.5) << "the head from before the push";
}

TEST_F(Trial, Row49WithoutAYoungRoomItsOwnHeadStaysWhateverTheBlobHolds) {
  inside(*rig.controller).learning.head.set_updates(cycles_per_day);
  while (starts_cycle(rig.now)) rig.row();
  const typename RoomHead<T>::State before = rig.controller->learning().head.theta();
  push(signed_by(blob_of<T>(*rig.controller, [](auto& p) { p.head_theta(RoomHead<T>::regressors + 5) = 50; }), key, 1));
  ASSERT_TRUE(row()) << text_of(record.refusal);
  EXPECT_EQ(rig.controller->learning().head.theta(), before);
  EXPECT_EQ(record.took_head, 0u);
}

TEST_F(Trial, Row49WeightsThatDoWorseThanTheScheduleAreTakenBack) {
  rig.now = {1'627'862'400 + 8 * 3600};
  rig.cycles(6);
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  const ControllerSettings& s = rig.controller->settings();
  int rows_on_trial = 0;
  while (record.state == TrialState::on_trial && rows_on_trial < 60) {
    // From the second cycle on: what the first row judges is still of the weights before.
    for (int k = 0; k < 40; ++k) inside(*rig.controller).cycle.shadow.cycle(s, s.target_degc + 1, 22, 20.5, 0.6);
    row();
    ++rows_on_trial;
  }
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_LE(rows_on_trial, 15) << "within a few cycles";
  EXPECT_TRUE(rig.same_weights(before)) << "those from before the push";
}

TEST_F(Trial, NewWeightsDoNotAnswerForWhatThoseBeforeThemDid) {
  rig.now = {1'627'862'400 + 8 * 3600};
  rig.cycles(6);
  const ControllerSettings& s = rig.controller->settings();
  auto& cycle = inside(*rig.controller).cycle;
  for (int k = 0; k < 40; ++k) cycle.shadow.cycle(s, s.target_degc + 1, 22, 20.5, 0.6);
  rig.cycles(1);
  ASSERT_EQ(rig.decision().reason, Reason::worse_than_schedule);
  cycle.mode_arbiter.hold(Reason::worse_for_long, rig.now, 86400);
  push(other(1));
  ASSERT_TRUE(row()) << "and the standing decision is still that of the weights before";
  rows(rows_per_day / 2);
  EXPECT_EQ(record.state, TrialState::on_trial);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn) << "they act, else a trial shows nothing";
  rows(rows_per_day / 2 + 2);
  EXPECT_EQ(record.state, TrialState::confirmed);
}

TEST_F(Trial, WeightsThatForetellTheRoomsBadlyAreTakenBackThoughTheHeadControlsWell) {
  ASSERT_EQ(rig.controller->settings().head_weight, 1.0);
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  int rows_on_trial = 0;
  for (; record.state == TrialState::on_trial && rows_on_trial < rows_per_day; ++rows_on_trial) {
    inside(*rig.controller).cycle.network_expected_degc += 1.5;
    row();
  }
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_LE(rows_on_trial, 12 * rows_per_cycle);
  EXPECT_TRUE(rig.same_weights(before));
}

TEST_F(Trial, ADayOnTheScheduleConfirmsNothing) {
  push(other(1));
  ASSERT_TRUE(row());
  rig.controller->hold(Reason::crash_loop, rig.now, 2 * 86400);
  rows(rows_per_day + 10);
  EXPECT_EQ(record.state, TrialState::on_trial);
  EXPECT_EQ(record.tried_cycles, 0u);
  rows(rows_per_day + 50 * rows_per_cycle);
  EXPECT_EQ(record.state, TrialState::confirmed);
}

TEST_F(Trial, FirstWeightsAreOnTrialTooAndTheWayBackIsTheSchedule) {
  inside(*rig.controller).cycle.has_weights = 0;
  rig.cycles(2);
  ASSERT_EQ(rig.decision().reason, Reason::no_weights);
  push(other(1));
  ASSERT_TRUE(row());
  EXPECT_EQ(record.state, TrialState::on_trial);
  rig.cycles(2);
  EXPECT_LT(rig.decision().mode, ControlMode::expert);
  wish("rollback");
  EXPECT_TRUE(row());
  rig.cycles(2);
  EXPECT_EQ(rig.decision().reason, Reason::no_weights);
}

TEST_F(Trial, MemoriesKeepTheirMeaningUnderAnotherScaler) {
  const Scaler<T> old = rig.controller->learning().scaler;
  push(signed_by(blob_of<T>(*rig.controller,
                            [](auto& p) {
                              p.scaler.mean(0) += 1;
                              p.scaler.scale(0) *= 2;
                              for (int i = 0; i < Layout<T>::rooms; ++i) {
                                p.scaler.mean(i) = p.scaler.mean(0);
                                p.scaler.scale(i) = p.scaler.scale(0);
                              }
                              for (float& w : p.weights) w *= 0.5F;
                            }),
                 key, 1));
  while (starts_cycle(rig.now)) rig.row();
  const auto newest = rig.controller->replay().newest(0);
  ASSERT_TRUE(row()) << text_of(record.refusal);
  const Scaler<T>& now = rig.controller->learning().scaler;
  const auto& after = rig.controller->replay().newest(0);
  EXPECT_NE(after[0], newest[0]);
  EXPECT_NEAR(static_cast<double>(after[0]) * now.scale(0) + now.mean(0),
              static_cast<double>(newest[0]) * old.scale(0) + old.mean(0), 1e-4);
}

TEST_F(Trial, Row49WeightsThatForetellNothingAreTakenBackAtOnce) {
  while (starts_cycle(rig.now)) rig.row();
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  push(other(1));
  ASSERT_TRUE(row());
  auto& learning = inside(*rig.controller).learning;
  learning.weights.values.fill(std::nanf(""));
  learning.head.theta().setConstant(std::nan(""));
  rig.controller->prepare();
  for (int i = 0; i < rows_per_cycle && record.state == TrialState::on_trial; ++i) row();
  EXPECT_EQ(record.state, TrialState::rolled_back);
  EXPECT_TRUE(rig.same_weights(before));
}

TEST_F(Trial, Row49WeightsUnderWhichTheGainTurnsRoundAreTakenBackAtOnce) {
  const auto turn_round = [this] {
    RoomHead<T>& head = inside(*rig.controller).learning.head;
    constexpr int gain = HeadFeatures::setpoint_change;
    head.theta()(gain) = -3;
    head.covariance().row(gain).setZero();
    head.covariance().col(gain).setZero();
    head.covariance()(gain, gain) = 1e-6;
  };
  push(other(1));
  ASSERT_TRUE(row());
  turn_round();
  for (int i = 0; i < 2 * rows_per_cycle && record.state == TrialState::on_trial; ++i) row();
  EXPECT_EQ(record.state, TrialState::rolled_back);
  // One that had turned round before is not held against weights that come.
  record = {};
  turn_round();
  rig.cycles(2);
  ASSERT_EQ(rig.decision().reason, Reason::gain_reversed);
  inside(*rig.controller).learning.head.set_updates(cycles_per_day);
  push(other(2));
  ASSERT_TRUE(row()) << record.refusal_field.data();
  turn_round();
  rows(3 * rows_per_cycle);
  ASSERT_EQ(rig.decision().reason, Reason::gain_reversed);
  EXPECT_EQ(record.state, TrialState::on_trial);
}

TEST_F(Trial, NoWorseThanThoseBeforeIsGoodEnough) {
  inside(*rig.controller).cycle.network_error_k2 = 9;
  push(other(1));
  ASSERT_TRUE(row());
  for (int i = 0; i < 15 * rows_per_cycle; ++i) {
    inside(*rig.controller).cycle.network_expected_degc += 0.6;  // three times a cycle
    row();
  }
  EXPECT_GT(record.error_sum_k2 / record.tried_cycles, 1.0);
  EXPECT_EQ(record.state, TrialState::on_trial);
}

TEST_F(Trial, AScheduleThatHasTakenOverSpeaksAgainstTheWeights) {
  push(other(1));
  ASSERT_TRUE(row());
  rig.controller->hold(Reason::worse_for_long, rig.now, 86400);
  rows(5 * rows_per_cycle);
  EXPECT_EQ(record.state, TrialState::rolled_back);
}

TEST_F(Trial, AHeadIsOnTrialOnlyWhereItCameAndForetold) {
  push(other(1));
  ASSERT_TRUE(row());
  for (int i = 0; i < 6 * rows_per_cycle; ++i) {
    inside(*rig.controller).cycle.head_expected_degc = std::nan("");
    row();
  }
  EXPECT_EQ(record.took_head, 1u);
  EXPECT_GT(record.tried_cycles, 3u);
  EXPECT_EQ(record.head_error_sum_k2, 0.0) << "no forecast is no error";
  wish("rollback");
  ASSERT_TRUE(row());
  inside(*rig.controller).learning.head.set_updates(cycles_per_day);
  push(other(2));
  ASSERT_TRUE(row());
  for (int i = 0; i < 15 * rows_per_cycle; ++i) {
    inside(*rig.controller).cycle.head_expected_degc += 1.5;
    row();
  }
  EXPECT_EQ(record.took_head, 0u);
  EXPECT_EQ(record.state, TrialState::on_trial) << "that was the room's own";
}

TEST_F(Trial, MailOfRowsWithoutACommitIsFinishedByTheNextOne) {
  wish("rollback");
  push(other(1));
  for (int i = 0; i < 2; ++i) {
    rig.row();
    (void)trial->row({rig.now.seconds - row_s}, *rig.controller, record);
  }
  EXPECT_TRUE(std::filesystem::exists(folder.file("inbox") / "rollback"));
  trial->committed();
  EXPECT_FALSE(std::filesystem::exists(folder.file("inbox") / "rollback"));
}

TEST(TrialStates, HaveWords) {
  EXPECT_STREQ(edge::text_of(TrialState::none), "none");
  EXPECT_STREQ(edge::text_of(TrialState::confirmed), "confirmed");
  EXPECT_STREQ(edge::text_of(TrialState::rolled_back), "rolled back");
  EXPECT_STREQ(edge::text_of(static_cast<TrialState>(9)), "unknown");
}

TEST_F(Trial, WishesReachTheLadder) {
  wish("release");
  row();
  rig.cycles(2);
  EXPECT_EQ(rig.decision().reason, Reason::released_by_hand);
  wish("hand-back");
  row();
  rig.cycles(2);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
}

}  // namespace
}  // namespace airside::weights
