// What verdict is drawn from how probable each explanation is.

#include "tools/gap/verdict/decision.hpp"

#include <gtest/gtest.h>

namespace airside::tools::gap {
namespace {

sim::Effect decided_effect(const char* name) {
  sim::Effect e;
  e.name = name;
  return e;
}

const sim::Effect a_leak = decided_effect("leak"), the_sun = decided_effect("sun");

/// Of a leak and of the sun; nothing and something else share the rest as `nothing` says.
Posterior answered(double of_leak, double of_sun, double nothing, std::vector<std::string> set) {
  Posterior p;
  p.effects = {{{&a_leak, 0}, of_leak, false, 0}, {{&the_sun, 0}, of_sun, false, 1}};
  if (of_sun > of_leak) std::swap(p.effects[0], p.effects[1]);
  p.nothing = nothing;
  p.other = 1 - of_leak - of_sun - nothing;
  p.set = std::move(set);
  p.sure = p.likeliest() > 0.95;
  return p;
}

Alternatives both_tried() {
  Alternatives all;
  for (const sim::Effect* effect : {&a_leak, &the_sun}) {
    Alternative a;
    a.at = {effect, 0};
    a.log_likelihood_ratio = effect == &a_leak ? 120 : 60;
    a.simulated = true;
    all.list.push_back(a);
  }
  return all;
}

Finding told(const Posterior& p) {
  Finding f;
  f.at = {&a_leak, 0};
  f.log_likelihood_ratio = 120;
  tell(f, p, both_tried());
  return f;
}

TEST(Decision, NamesWhatIsSureAndSaysWhatElseIsProbable) {
  const Posterior sure = answered(0.98, 0.01, 0, {"leak"});
  const Finding named = told(sure);
  EXPECT_TRUE(named.why_not.empty());
  EXPECT_DOUBLE_EQ(named.margin, 2);
  EXPECT_TRUE(named.cannot_tell_from.empty());
  EXPECT_EQ(decision_of({named}, {sure}, false).kind, VerdictKind::named);

  const Posterior open = answered(0.7, 0.25, 0.02, {"leak", "sun"});
  const Finding unsure = told(open);
  EXPECT_EQ(unsure.why_not, "not sure: leak 70 %, sun 25 %");
  ASSERT_EQ(unsure.cannot_tell_from.size(), 1U);
  EXPECT_EQ(unsure.cannot_tell_from[0].id(), "sun");
  EXPECT_EQ(decision_of({unsure}, {open}, false).kind, VerdictKind::ambiguous);
  EXPECT_EQ(decision_of({unsure, named}, {open, sure}, false).kind, VerdictKind::named) << "beside an unsure one";
}

TEST(Decision, SomethingElseIsUnknownAndNothingIsNoGap) {
  const Posterior strange = answered(0.2, 0.1, 0, {"other", "leak"});
  const Decision unknown = decision_of({told(strange)}, {strange}, false);
  EXPECT_EQ(unknown.kind, VerdictKind::unknown);
  EXPECT_EQ(unknown.reason, "no effect explains it well: something else 70 %, leak 20 %");
  const Posterior quiet = answered(0.1, 0.05, 0.84, {"nothing", "leak"});
  EXPECT_EQ(decision_of({}, {quiet}, false).kind, VerdictKind::none);
  EXPECT_EQ(decision_of({}, {quiet}, false).reason, "no gap above the floor (nothing 84 %, leak 10 %)");
  const Posterior sure = answered(0.98, 0.01, 0, {"leak"});
  EXPECT_EQ(decision_of({told(sure)}, {sure}, true).kind, VerdictKind::unknown) << "another would still gain";
}

TEST(Decision, LockedDaysThatContradictAreTheReason) {
  Posterior p = answered(0.98, 0.01, 0, {"leak"});
  p.effects[0].vetoed = true;
  p.sure = false;
  EXPECT_EQ(told(p).why_not, "the locked days contradict it");
}

TEST(Decision, WhatIsLikelierTakesAFindingsPlace) {
  Finding f;
  f.at = {&a_leak, 0};
  EXPECT_EQ(instead_of(&f, answered(0.98, 0.01, 0, {"leak"})), Instead::nothing_else);
  EXPECT_EQ(instead_of(&f, answered(0.6, 0.3, 0, {"leak", "sun"})), Instead::nothing_else);
  EXPECT_EQ(instead_of(&f, answered(0.01, 0.98, 0, {"sun"})), Instead::another);
  EXPECT_EQ(instead_of(&f, answered(0.2, 0.1, 0.6, {"nothing", "leak"})), Instead::nobody);
  EXPECT_EQ(instead_of(nullptr, answered(0.98, 0.01, 0, {"leak"})), Instead::another);
  EXPECT_EQ(instead_of(nullptr, answered(0.5, 0.1, 0.35, {"leak", "nothing"})), Instead::another);
  EXPECT_EQ(instead_of(nullptr, answered(0.3, 0.25, 0.4, {"nothing", "leak", "sun"})), Instead::nothing_else);
  EXPECT_EQ(instead_of(nullptr, answered(0.3, 0.25, 0.05, {"other", "leak", "sun"})), Instead::nothing_else);
  EXPECT_EQ(instead_of(nullptr, Posterior{}), Instead::nothing_else);
}

}  // namespace
}  // namespace airside::tools::gap
