// The time that a task of several stages still takes, on sequences that were recorded.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

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

/// Largest factor, after the first quarter and until a twentieth is left, by which what was shown is off.
double worst_factor(const std::vector<Shown>& shown) {
  const double all = shown.back().now_s;
  double worst = 1;
  for (const Shown& s : shown) {
    if (s.now_s < 0.25 * all || s.took_s < 0.05 * all) continue;
    worst = std::max({worst, s.left_s / s.took_s, s.took_s / s.left_s});
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
