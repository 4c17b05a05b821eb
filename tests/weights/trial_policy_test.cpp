// The policy of trial and rollback by itself, as a port without a file system has it: lib alone, the image in memory.

#include "airside/controller/weight_trial.hpp"

#include "support/controller_rig.hpp"
#include "support/default_cycle.hpp"

namespace airside::weights {
namespace {

using T = FiveZone;

class TrialPolicy : public ::testing::Test {
 protected:
  TrialPolicy() {
    rig.cycles(6);
    while (starts_cycle(rig.now)) rig.row();
    give_payload<T>(*rig.controller, *payload);
    for (float& w : payload->weights) w *= 0.9F;
  }
  /// Takes the payload as whoever keeps the image in memory does.
  void take() {
    ASSERT_EQ(WeightTrial<T>::refusal_of(*rig.controller, *payload, *work).fault, Fault::none);
    if (WeightTrial<T>::needs_image(record)) {
      *image = rig.controller->learning();
      WeightTrial<T>::keep_image(*rig.controller, 1, record);
    }
    WeightTrial<T>::begin(rig.now, *rig.controller, *payload, 7, record);
  }
  TrialVerdict row() {
    rig.row();
    return WeightTrial<T>::row({rig.now.seconds - row_s}, *rig.controller, record);
  }
  Rollback roll_back(bool readable, bool may_pass = false) {
    return WeightTrial<T>::roll_back(*rig.controller, readable ? image.get() : nullptr, may_pass, 3, record);
  }

  ControllerRig rig{brief_learning()};
  WeightTrialRecord record;
  std::unique_ptr<WeightPayload<T>> payload = std::make_unique<WeightPayload<T>>();
  std::unique_ptr<NetworkWeights<T, float>> work = std::make_unique<NetworkWeights<T, float>>();
  std::unique_ptr<LearningState<T, float>> image = std::make_unique<LearningState<T, float>>();
};

TEST_F(TrialPolicy, SoundWeightsAreConfirmedAfterADayAndNotBefore) {
  take();
  for (int i = 0; i < rows_per_day - 1; ++i) ASSERT_EQ(row(), TrialVerdict::goes_on) << i;
  TrialVerdict last = TrialVerdict::goes_on;
  for (int i = 0; i < 3 && last == TrialVerdict::goes_on; ++i) last = row();
  EXPECT_EQ(last, TrialVerdict::confirmed);
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_LT(WeightTrial<T>::error_k(record), 1.0);
}

TEST_F(TrialPolicy, WeightsThatForecastBadlyEndInARollbackToTheImage) {
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  take();
  EXPECT_FALSE(rig.same_weights(before));
  TrialVerdict verdict = TrialVerdict::goes_on;
  for (int i = 0; i < rows_per_day && verdict == TrialVerdict::goes_on; ++i) {
    inside(*rig.controller).cycle.network_expected_degc += 1.5;
    verdict = row();
  }
  EXPECT_EQ(verdict, TrialVerdict::forecasts_are_bad);
  ASSERT_TRUE(ends_in_rollback(verdict));
  EXPECT_EQ(roll_back(true), Rollback::done);
  EXPECT_TRUE(rig.same_weights(before));
  EXPECT_EQ(record.state, TrialState::rolled_back);
}

TEST_F(TrialPolicy, AnImageThatCannotBeReadIsWaitedForAndThenTheScheduleTakesOver) {
  take();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(roll_back(false, true), Rollback::waits);
  EXPECT_EQ(rig.controller->cycle().has_weights, 0) << "those that go are out of use meanwhile";
  EXPECT_EQ(roll_back(false, true), Rollback::image_gone);
  rig.cycles(2);
  EXPECT_EQ(rig.decision().reason, Reason::no_weights);
}

TEST_F(TrialPolicy, ConfirmedWeightsStayWhereTheImageIsGone) {
  take();
  record.state = TrialState::confirmed;
  EXPECT_EQ(roll_back(false), Rollback::impossible);
  EXPECT_EQ(record.state, TrialState::confirmed);
  EXPECT_EQ(rig.controller->cycle().has_weights, 1);
}

TEST_F(TrialPolicy, WildWeightsAreRefused) {
  payload->weights[3] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(WeightTrial<T>::refusal_of(*rig.controller, *payload, *work).fault, Fault::blob_value);
  for (float& w : payload->weights) w = 40;
  EXPECT_EQ(WeightTrial<T>::refusal_of(*rig.controller, *payload, *work).fault, Fault::blob_value);
  EXPECT_EQ(record.state, TrialState::none);
}

TEST(TrialVerdicts, HaveWords) {
  for (int i = 0; i <= static_cast<int>(TrialVerdict::forecasts_are_bad); ++i) {
    EXPECT_STRNE(why_of(static_cast<TrialVerdict>(i)), "unknown");
  }
  EXPECT_STREQ(why_of(static_cast<TrialVerdict>(99)), "unknown");
  EXPECT_FALSE(ends_in_rollback(TrialVerdict::confirmed));
}

}  // namespace
}  // namespace airside::weights
