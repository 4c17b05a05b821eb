// Static pretraining, a peer of the method (docs/method.md 7.3, open point 27): the same days of the same twin under
// schedules that were fixed beforehand, with as many transitions and optimiser steps as the agent has.

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "support/program.hpp"
#include "tools/run/control_run.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/training/pretraining.hpp"

namespace airside::tools {
namespace {

using nlohmann::json;

Pretraining pretrained(Pretrainer who, hal::ControllerPreset preset, int days, std::uint64_t seed = 1) {
  const Site site = built_in_site("5vav-5fcu-2power", preset);
  PlantChoice twin;
  twin.kind = "rc";
  const auto model = make_plant(twin, site, days);
  PretrainOptions options;
  options.seed = seed;
  options.updates_per_cycle = 1;
  options.pretrainer = who;
  return pretrain(site, *model, {start_of(twin).seconds + days * std::int64_t{86400}}, options);
}

/// Day 1: a transition from every row but those before a change at 7:12 and 19:12 and the last three; then one a cycle,
/// the first when the second day's first cycle is over.
constexpr std::uint64_t transitions_of(int days) {
  return (240 - 3 - 2 * 2) + 79 + 80 * (static_cast<unsigned>(days) - 2);
}

class StaticPretraining : public ::testing::TestWithParam<hal::ControllerPreset> {};

TEST_P(StaticPretraining, HasAsManyTransitionsAndOptimiserStepsAsTheAgent) {
  for (const int days : {2, 4}) {
    const Pretraining agent = pretrained(Pretrainer::agent, GetParam(), days);
    EXPECT_EQ(agent.transitions, transitions_of(days)) << days;
    EXPECT_EQ(agent.run.optimiser_steps, 80 * (static_cast<unsigned>(days) - 1) - 1) << days;
    for (const Pretrainer who : {Pretrainer::drawn_schedules, Pretrainer::expert_schedule}) {
      const Pretraining fixed = pretrained(who, GetParam(), days);
      EXPECT_EQ(fixed.transitions, agent.transitions) << days;
      EXPECT_EQ(fixed.run.optimiser_steps, agent.run.optimiser_steps) << days;
      EXPECT_EQ(fixed.run.rows.size(), agent.run.rows.size()) << days;
      EXPECT_EQ(fixed.blob.size(), agent.blob.size());
      EXPECT_NE(fixed.blob, agent.blob);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Preset, StaticPretraining,
                         ::testing::Values(hal::ControllerPreset::product, hal::ControllerPreset::paper),
                         [](const auto& which) {
                           return which.param == hal::ControllerPreset::paper ? "paper" : "product";
                         });

/// The working setpoint of each day, from its first cycle to its last; a cycle that is not its day's, or the night's
/// 25, fails.
std::vector<double> working_setpoints(const ControlRun& run) {
  std::vector<double> days;
  const std::int64_t first = run.cycles.front().time.day();
  for (const CycleSample& c : run.cycles) {
    const double hour = static_cast<double>(c.time.second_of_day()) / 3600.0;
    if (hour < 7 || hour >= 19) {
      EXPECT_EQ(c.setpoint_degc, 25.0) << "day " << c.time.day() - first << " at " << hour << " h";
      continue;
    }
    const auto day = static_cast<std::size_t>(c.time.day() - first);
    if (day == days.size()) days.push_back(c.setpoint_degc);
    EXPECT_EQ(c.setpoint_degc, days.at(day)) << "day " << day << " at " << hour << " h";
  }
  return days;
}

TEST(StaticSchedules, DrawEachDaysWorkingSetpointFromFiveAndKeepTheNight) {
  const std::set<double> allowed = {19.5, 20.0, 20.5, 21.0, 21.5};
  const auto days = working_setpoints(pretrained(Pretrainer::drawn_schedules, hal::ControllerPreset::product, 31).run);
  ASSERT_EQ(days.size(), 31U);
  for (const double setpoint : days) EXPECT_EQ(allowed.count(setpoint), 1U) << setpoint;
  // Each is drawn: that one of five is missing in 31 fair draws has a chance of 0.5 %, and the seed is fixed.
  EXPECT_EQ(std::set<double>(days.begin(), days.end()), allowed);
  const auto few = working_setpoints(pretrained(Pretrainer::drawn_schedules, hal::ControllerPreset::product, 8).run);
  EXPECT_TRUE(std::equal(few.begin(), few.end(), days.begin()))
      << "fixed beforehand: the days do not depend on the run";
  EXPECT_NE(few, working_setpoints(pretrained(Pretrainer::drawn_schedules, hal::ControllerPreset::product, 8, 2).run));
}

TEST(StaticSchedules, AreTheExpertsWhereAskedFor) {
  const auto run = pretrained(Pretrainer::expert_schedule, hal::ControllerPreset::product, 4).run;
  EXPECT_EQ(working_setpoints(run), std::vector<double>(4, 20.5));
}

TEST(StaticPretrainingCommand, SaysCountsAndTakesBothSchedules) {
  const TemporaryFolder folder, scratch;
  const auto run = [&](const std::vector<std::string>& words) {
    std::vector<std::string> all = {"pretrain", "--plant", "rc", "--days", "2", "--updates", "1", "--json"};
    all.insert(all.end(), words.begin(), words.end());
    return run_program("airside", all, folder.path(), scratch.path());
  };
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {}, {"--static"}, {"--static", "-o", "a.blob"}, {"--static", "drawn"}, {"--static", "expert"}}) {
    const Outcome o = run(words);
    ASSERT_EQ(o.code, 0) << o.err;
    const json j = json::parse(o.out);
    EXPECT_EQ(j["transitions"], transitions_of(2)) << o.out;
    EXPECT_EQ(j["optimiser_steps"], 79) << o.out;
  }
  const Outcome expert = run({"--static", "expert"}), drawn = run({"--static", "drawn"}), plain = run({"--static"});
  EXPECT_EQ(json::parse(plain.out)["daily_dae_degc"], json::parse(drawn.out)["daily_dae_degc"]);
  EXPECT_NE(json::parse(expert.out)["daily_dae_degc"], json::parse(drawn.out)["daily_dae_degc"]);
  const Outcome other = run({"--static", "best"});
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.err.find("drawn"), std::string::npos) << other.err;
}

}  // namespace
}  // namespace airside::tools
