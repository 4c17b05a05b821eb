// The time that a task of several stages still takes, on sequences that were recorded.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "sim/rc/rc_room_file.hpp"
#include "tools/gap/run/gap_stages.hpp"
#include "tools/run/progress/stage_clock.hpp"
#include "tools/run/progress/staged_progress.hpp"

namespace airside::tools {
namespace {

struct Ran {
  int steps = 0;
  double seconds = 0;
};

/// What was shown at a moment, and what it then took.
struct Shown {
  double now_s = 0, left_s = 0, took_s = 0;
};

/// A stage known better when another begins.
struct Known {
  std::size_t when = 0, stage = 0;
  Stage as;
};

/// Plays a task whose stages ran so, as the plan said before.
std::vector<Shown> played(const std::vector<Stage>& plan, const std::vector<Ran>& ran,
                          const std::vector<Known>& known = {}) {
  double all = 0;
  for (const Ran& r : ran) all += r.seconds;
  StageClock clock(plan);
  std::vector<Shown> shown;
  double now = 0;
  for (std::size_t stage = 0; stage < ran.size(); ++stage) {
    for (const Known& k : known) {
      if (k.when == stage) clock.expect(k.stage, k.as);
    }
    clock.enter(stage, now);
    for (int k = 0; k < ran[stage].steps; ++k) {
      now += ran[stage].seconds / ran[stage].steps;
      clock.advance(1, now);
      shown.push_back({now, clock.left_s(), all - now});
    }
  }
  return shown;
}

/// Largest factor, after the first quarter and until a fifth is left, by which what was shown is off.
double worst_factor(const std::vector<Shown>& shown) {
  const double all = shown.back().now_s;
  double worst = 1;
  for (const Shown& s : shown) {
    if (s.now_s < 0.25 * all || s.took_s < 0.2 * all) continue;
    worst = std::max({worst, s.left_s / s.took_s, s.took_s / s.left_s});
  }
  return worst;
}

/// Largest error in the last fifth, as a share of the whole.
double worst_error_at_the_end(const std::vector<Shown>& shown) {
  const double all = shown.back().now_s;
  double worst = 0;
  for (const Shown& s : shown) {
    if (s.took_s < 0.2 * all) worst = std::max(worst, std::abs(s.left_s - s.took_s) / all);
  }
  return worst;
}

TEST(StageClock, KnowsAllStagesFromTheFirstSteps) {
  const std::vector<Stage> plan{{"many", 100, 0.5}, {"few", 20, 1}, {"long", 30, 2}};
  const std::vector<Shown> shown = played(plan, {{100, 50}, {20, 20}, {30, 60}});
  EXPECT_LT(worst_factor(shown), 1.05);
  EXPECT_NEAR(shown.front().left_s, 129.5, 1) << "not the 50 s of the first stage";
}

TEST(StageClock, LearnsThatAStageIsSlowerThanItsWeight) {
  const std::vector<Stage> plan{{"a", 100, 1}, {"b", 100, 1}};
  const std::vector<Shown> shown = played(plan, {{100, 50}, {100, 100}});
  const auto half_of_b = shown[150];
  EXPECT_LT(half_of_b.took_s / half_of_b.left_s, 1.3);
}

TEST(StageClock, DoesNotJumpWhenAStageIsReplanned) {
  const std::vector<Stage> plan{{"a", 100, 1}, {"b", 10, 1}};
  const std::vector<Shown> shown = played(plan, {{100, 100}, {100, 100}}, {{1, 1, {"b", 100, 1}}});
  for (std::size_t i = 1; i < shown.size(); ++i) {
    if (shown[i].now_s < 25 || shown[i].took_s < 5) continue;
    const double passed = std::max(shown[i - 1].left_s - (shown[i].now_s - shown[i - 1].now_s), 0.5);
    EXPECT_LT(shown[i].left_s / passed, 2) << shown[i].now_s;
    EXPECT_GT(shown[i].left_s / passed, 0.5) << shown[i].now_s;
  }
  EXPECT_LT(shown.back().left_s, 3);
}

/// Runs of `airside gap run` on logs of room 301, 8 days each: seconds of each stage on one core.
struct RecordedRun {
  const char* name;
  double over_limit;
  gap::VerdictKind verdict;
  int searched;                 ///< simulations of the search
  std::vector<double> seconds;  ///< of effects, fit, search, explanation
};

TEST(GapStages, PredictTheTimeOfTheWholeWorkflow) {
  const auto effects = sim::load_effects(sim::find_effects());
  const gap::RcEngine engine(sim::load_room("301"));
  const gap::GapStages stages(engine, gap::library_of(engine, effects), 8, 1);
  const RecordedRun runs[] = {
      {"nothing hidden", 0.2, gap::VerdictKind::none, 8, {4.3, 2.4, 0.1, 0.05}},
      {"one effect, named", 15, gap::VerdictKind::named, 100, {4.3, 2.5, 1.0, 0.05}},
      {"two effects, both named", 147, gap::VerdictKind::named, 280, {4.3, 2.8, 3.0, 0.05}},
      {"one of a class", 11, gap::VerdictKind::ambiguous, 100, {4.3, 2.3, 0.9, 1.4}},
      {"a heater that no effect is", 1.6, gap::VerdictKind::unknown, 100, {4.3, 2.7, 1.0, 2.05}},
  };
  for (const RecordedRun& run : runs) {
    const std::vector<Known> known{{2, 2, stages.search(run.over_limit)},
                                   {2, 3, stages.explanation(run.over_limit)},
                                   {3, 3, stages.explanation(run.verdict)}};
    const std::vector<Stage> plan = stages.stages();
    const auto steps = [](const Stage& stage) { return static_cast<int>(stage.steps); };
    const std::vector<Shown> shown = played(plan,
                                            {{steps(plan[0]), run.seconds[0]},
                                             {steps(plan[1]), run.seconds[1]},
                                             {run.searched, run.seconds[2]},
                                             {steps(stages.explanation(run.verdict)), run.seconds[3]}},
                                            known);
    // What will be found is not known before the search: a run that finds nothing and one that finds much differ
    // by 1.6.
    EXPECT_LT(worst_factor(shown), 2.2) << run.name;
    EXPECT_LT(worst_error_at_the_end(shown), 0.2) << run.name;
    for (std::size_t i = 1; i < shown.size(); ++i) {
      if (shown[i].now_s < 0.1 * shown.back().now_s || shown[i].took_s < 0.2 * shown.back().now_s) continue;
      EXPECT_LT(shown[i].left_s, 2 * shown[i - 1].left_s) << run.name << " at " << shown[i].now_s;
    }
  }
}

TEST(StageClock, EndsWhereAStageOutrunsItsPlan) {
  const std::vector<Shown> shown = played({{"a", 10, 1}}, {{100, 100}});
  for (const Shown& s : shown) EXPECT_GE(s.left_s, 0);
}

TEST(StagedProgress, SaysWhichStageRunsAndIsSilentWithoutAStream) {
  StagedProgress silent(nullptr);
  silent.start("nothing", {{"a", 1, 1}});
  silent.advance();
  silent.finish();

  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  {
    StagedProgress progress(file);
    progress.start("work", {{"first", 2, 1}, {"second", 2, 1}});
    progress.advance(2);
    progress.enter(1);
    progress.advance(2);
    progress.finish();
  }
  std::rewind(file);
  std::string text;
  for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text += static_cast<char>(c);
  std::fclose(file);
  EXPECT_NE(text.find("work: started\n"), std::string::npos) << text;
  EXPECT_NE(text.find("work: done in 0 s\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace airside::tools
