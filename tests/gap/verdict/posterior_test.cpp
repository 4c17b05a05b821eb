// What a posterior makes of gains that are made up.

#include "tools/gap/inference/posterior.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace airside::tools::gap {
namespace {

sim::Effect effect_called(const char* name) {
  sim::Effect e;
  e.name = name;
  e.null_value = e.least = 0;
  e.low = -1;
  e.high = 1;
  return e;
}

const sim::Effect leak = effect_called("leak"), sun = effect_called("sun"), mass = effect_called("mass");

Alternative with_gain(const sim::Effect& effect, double gain) {
  Alternative a;
  a.at = {&effect, 0};
  a.magnitude = 0.5;
  a.sd = 0.1;
  a.log_likelihood_ratio = gain;
  a.residual_ratio = 1;
  a.simulated = true;
  return a;
}

Alternatives tried(double of_leak, double of_sun, double of_mass) {
  Alternatives all;
  all.list = {with_gain(leak, of_leak), with_gain(sun, of_sun), with_gain(mass, of_mass)};
  all.residual_ratio = 1;
  all.residual_ratio_chance = 1.5;
  return all;
}

double probability_of(const Posterior& p, const std::string& id) {
  for (const EffectProbability& e : p.effects) {
    if (e.at.id() == id) return e.probability;
  }
  ADD_FAILURE() << id << " has no probability";
  return 0;
}

TEST(Posterior, SumsToOneAndPutsTheBestFirst) {
  for (const double gain : {0.0, 20.0, 300.0, 2e4, 1e7}) {
    const Posterior p = posterior_of(tried(gain / 3, gain, 5));
    const double effects = std::accumulate(p.effects.begin(), p.effects.end(), 0.0,
                                           [](double sum, const EffectProbability& e) { return sum + e.probability; });
    EXPECT_NEAR(effects + p.nothing + p.other, 1, 1e-12) << gain;
    EXPECT_GE(p.effects[0].probability, p.effects[1].probability);
    EXPECT_GE(p.effects[1].probability, p.effects[2].probability);
  }
}

TEST(Posterior, SaysNothingOfSmallGainsAndNamesALargeOne) {
  EXPECT_GT(posterior_of(tried(8, 6, 3)).nothing, 0.5);
  EXPECT_EQ(posterior_of(tried(8, 6, 3)).set.front(), "nothing");
  const Posterior p = posterior_of(tried(20, 400, 30));
  EXPECT_TRUE(p.sure);
  EXPECT_EQ(p.effects.front().at.id(), "sun");
  EXPECT_EQ(p.set, std::vector<std::string>{"sun"});
}

TEST(Posterior, HoldsBothOfTwoThatGainAsMuchHoweverMuchThatIs) {
  for (const double gain : {300.0, 8000.0}) {
    const Posterior p = posterior_of(tried(0.98 * gain, gain, 10));
    EXPECT_FALSE(p.sure);
    EXPECT_EQ(p.set, (std::vector<std::string>{"sun", "leak"})) << gain;
  }
}

TEST(Posterior, DrawnBuildingsNameAtNinetyPercentAndNothingElseDoes) {
  const auto share_of_sun = [](const Posterior& p) { return p.likeliest() / (1 - p.other); };
  int between = 0;
  for (double rival = 0; rival < 400; rival += 0.5) {
    const Alternatives all = tried(rival, 400, 10);
    const double share = share_of_sun(posterior_of(all));
    if (share <= 0.90 || share >= 0.95) continue;
    ++between;
    EXPECT_TRUE(posterior_of(all).sure) << share;
    EXPECT_EQ(posterior_of(all).name_needs, 0.90);
    PosteriorModel strict = PosteriorModel::learned();
    strict.name_probability = PosteriorModel::learned_without_buildings().name_probability;
    EXPECT_FALSE(posterior_of(all, strict).sure) << share;
    EXPECT_EQ(posterior_of(all, strict).name_needs, 0.95);
  }
  EXPECT_GT(between, 3);
  EXPECT_EQ(PosteriorModel::learned_by_surrogate().name_probability, 0.95);
}

TEST(Posterior, GivesWhatIsLeftToSomethingElse) {
  Alternatives right = tried(20, 400, 30), strange = right;
  for (Alternative& a : strange.list) a.residual_ratio = 4;
  EXPECT_GT(posterior_of(strange).other, 5 * posterior_of(right).other);
  EXPECT_LT(probability_of(posterior_of(strange), "sun"), probability_of(posterior_of(right), "sun"));
}

TEST(Posterior, SaysSomethingElseOfWhatNoEffectTouches) {
  const auto untouched = [](double left) {
    Alternatives all = tried(8, 6, 3);
    all.residual_ratio = left;
    for (Alternative& a : all.list) a.residual_ratio = left;
    return posterior_of(all);
  };
  for (const double left : {1.0, 1.2}) EXPECT_GT(untouched(left).nothing, 0.5) << left;
  EXPECT_EQ(untouched(1.8).set.front(), "other") << "chance leaves 1.5 at most";
}

TEST(Posterior, NamesWhatExplainsAlmostAllOfWhatIsManyTimesTheNoise) {
  Alternatives large = tried(170, 3400, 45);
  large.residual_ratio = 19.6;
  for (Alternative& a : large.list) a.residual_ratio = 19;
  large.list[1].residual_ratio = 1.13;
  EXPECT_TRUE(posterior_of(large).sure) << posterior_of(large).other;
  EXPECT_EQ(posterior_of(large).effects.front().at.id(), "sun");
}

TEST(Posterior, IsNotSureOfWhatIsNearerToItsNullThanSuchAnEffectIs) {
  sim::Effect exchanged = sun;
  exchanged.least = 0.9;
  Alternatives small = tried(20, 400, 30);
  ASSERT_TRUE(posterior_of(small).sure);
  small.list[1].at.effect = &exchanged;
  const Posterior p = posterior_of(small);
  EXPECT_FALSE(p.sure);
  EXPECT_EQ(p.effects.front().at.id(), "sun");
}

TEST(Posterior, TakesOffWhatTheReferencesOwnDaysGain) {
  Alternatives noisy = tried(60, 10, 10);
  EXPECT_GT(probability_of(posterior_of(noisy), "leak"), 0.5);
  noisy.list.front().of_reference = 80;
  EXPECT_LT(probability_of(posterior_of(noisy), "leak"), 0.2);
}

TEST(Posterior, IsWiderOverPlacesAndNarrowerWhereASizeIsImprobable) {
  Alternatives many = tried(100, 100, 1), small = many, below = many;
  many.list.front().places = 20;
  small.list.front().magnitude = 0.002;
  sim::Effect swapped = effect_called("leak");
  swapped.least = 0.8;
  below.list.front().at.effect = &swapped;
  for (const Alternatives* tried_at : {&many, &small, &below})
    EXPECT_LT(probability_of(posterior_of(*tried_at), "leak"), probability_of(posterior_of(*tried_at), "sun"));
}

TEST(Posterior, KeepsAPlacedEffectThatTheDataTellApart) {
  Alternatives sharp = tried(500, 60, 20);
  sharp.list.front().places = 20;
  EXPECT_TRUE(posterior_of(sharp).sure);
}

TEST(Posterior, ANameIsContradictedOnlyByDaysThatAreVeryImprobable) {
  Alternatives all = tried(20, 900, 30);
  Alternative& sun_found = all.list[1];
  sun_found.locked = true;
  sun_found.locked_expected = 400;
  for (const double came : {400.0, 150.0}) {
    sun_found.locked_log_likelihood_ratio = came;
    EXPECT_TRUE(posterior_of(all).sure) << came;
  }
  sun_found.locked_log_likelihood_ratio = -300;
  EXPECT_TRUE(locked_days_veto(sun_found));
  EXPECT_FALSE(posterior_of(all).sure);
  sun_found.locked_log_likelihood_ratio = 2000;
  EXPECT_FALSE(locked_days_veto(sun_found)) << "more than predicted is no contradiction";
}

TEST(Posterior, LockedDaysCountAsFurtherEvidence) {
  Alternatives all = tried(100, 100, 10);
  for (Alternative& a : all.list) a.locked = true;
  all.list[0].locked_log_likelihood_ratio = 80;
  EXPECT_GT(probability_of(posterior_of(all), "leak"), 1.5 * probability_of(posterior_of(all), "sun"));
}

}  // namespace
}  // namespace airside::tools::gap
