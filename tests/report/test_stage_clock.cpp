// The time that a task of several stages still takes, on sequences that were recorded.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "sim/rc/rc_room_file.hpp"
#include "tools/gap/model/forwarding_engine.hpp"
#include "tools/gap/run/gap_stages.hpp"
#include "tools/gap/surrogate/analyse_dear.hpp"
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

/// A stage known better at a step of another.
struct Known {
  std::size_t when = 0, stage = 0;
  Stage as;
  int step = 0;
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
    const auto learn = [&](int step) {
      for (const Known& k : known) {
        if (k.when == stage && k.step == step) clock.expect(k.stage, k.as);
      }
    };
    learn(0);
    clock.enter(stage, now);
    for (int k = 0; k < ran[stage].steps; ++k) {
      if (k > 0) learn(k);
      now += ran[stage].seconds / ran[stage].steps;
      clock.advance(1, now);
      shown.push_back({now, clock.left_s(), all - now});
    }
  }
  return shown;
}

/// Largest factor, from this moment on and until a fifth is left, by which what was shown is off.
double worst_factor(const std::vector<Shown>& shown, double from_s) {
  const double all = shown.back().now_s;
  double worst = 1;
  for (const Shown& s : shown) {
    if (s.now_s < from_s || s.took_s < 0.2 * all) continue;
    worst = std::max({worst, s.left_s / s.took_s, s.took_s / s.left_s});
  }
  return worst;
}
double worst_factor(const std::vector<Shown>& shown) { return worst_factor(shown, 0.25 * shown.back().now_s); }

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

/// Runs of `airside gap run` on logs of room 301, 8 days each, on one core.
struct RecordedRun {
  const char* name;
  gap::Outlook outlook;  ///< once the reference was fitted
  gap::VerdictKind verdict;
  bool has_rivals;
  int searched;                 ///< simulations of the search
  std::vector<double> seconds;  ///< of effects, fit, search, explanation
};

/// What was shown in such a run.
std::vector<Shown> played(const gap::GapStages& stages, const RecordedRun& run) {
  constexpr int simulated = 394, fitted = 171, fitted_reference = 60;
  const auto explanation = stages.explanation(run.verdict, run.has_rivals);
  const std::vector<Known> known{{1, 2, stages.search(run.outlook), fitted_reference},
                                 {1, 3, stages.explanation(run.outlook), fitted_reference},
                                 {3, 3, explanation}};
  return played(stages.stages(),
                {{simulated, run.seconds[0]},
                 {fitted, run.seconds[1]},
                 {run.searched, run.seconds[2]},
                 {static_cast<int>(explanation.steps), run.seconds[3]}},
                known);
}

TEST(GapStages, PredictTheTimeOfTheWholeWorkflow) {
  const auto effects = sim::load_effects(sim::find_effects());
  const gap::RcEngine engine(sim::load_room("301"));
  const gap::GapStages stages(engine, gap::library_of(engine, effects), 8, 1);
  const gap::Outlook nothing, one{.more = 1}, two{.more = 2}, one_of_two{.more = 1, .alike = true},
      heat{.unknown = true}, three_and_heat{.more = 3, .unknown = true};
  const RecordedRun runs[] = {
      {"nothing hidden", nothing, gap::VerdictKind::none, false, 1, {4.45, 2.34, 0.01, 0.01}},
      {"one effect, named", one, gap::VerdictKind::named, false, 78, {4.48, 2.29, 1.16, 0.02}},
      {"two effects, both named", two, gap::VerdictKind::named, false, 222, {4.33, 2.35, 3.15, 0.02}},
      {"one of a class", one_of_two, gap::VerdictKind::ambiguous, true, 87, {4.45, 2.24, 1.27, 1.08}},
      {"heat that is found by no search", heat, gap::VerdictKind::unknown, false, 1, {4.62, 2.38, 0.01, 2.24}},
      {"three effects, and heat", three_and_heat, gap::VerdictKind::unknown, false, 438, {4.56, 2.30, 6.04, 2.03}},
  };
  for (const RecordedRun& run : runs) {
    const std::vector<Shown> shown = played(stages, run);
    // A run that takes twice as long as one that finds nothing looks like it until the reference is fitted.
    const bool is_long = run.outlook.more == 3;
    const double known_s = is_long ? run.seconds[0] + 0.6 * run.seconds[1] : 0.25 * shown.back().now_s;
    EXPECT_LT(worst_factor(shown, known_s), 2) << run.name;
    EXPECT_LT(worst_factor(shown), is_long ? 4 : 2) << run.name;
    EXPECT_LT(worst_error_at_the_end(shown), 0.2) << run.name;
    for (std::size_t i = 1; i < shown.size(); ++i) {
      if (shown[i].now_s < 0.1 * shown.back().now_s || shown[i].took_s < 0.2 * shown.back().now_s) continue;
      EXPECT_LT(shown[i].left_s, 2 * shown[i - 1].left_s) << run.name << " at " << shown[i].now_s;
    }
  }
}

/// Of one stage.
double weighed(const Stage& stage) { return stage.steps * stage.weight; }

TEST(GapStages, CountRunsOfAModelInWhoseSteadARoomAnswers) {
  auto effects = sim::load_effects(sim::find_effects());
  std::erase_if(effects, [](const sim::Effect& e) {
    return e.name != "fan_heat" && e.name != "chiller_cop" && e.name != "clock_shift" && e.name != "gain_zone";
  });
  const gap::RcEngine engine(sim::load_room("301"));
  const gap::Library library = gap::library_of(engine, effects);
  const auto cheap = gap::GapStages(engine, library, 8, 1).stages(),
             dear = gap::GapStages(engine, library, 8, 1, 0, true).stages();
  const double run = gap::replays_of_dear_run;
  EXPECT_EQ(dear.at(gap::GapStage::responding).steps, cheap.at(gap::GapStage::responding).steps + 2 * run);
  const double more = dear.at(gap::GapStage::fitting).steps - cheap.at(gap::GapStage::fitting).steps;
  // Estimates and where they lead before every round, likely effects after all but the last.
  const double runs =
      gap::dear_rounds * (gap::dear_fits + 1) + (gap::dear_rounds - 1) * gap::dear_effects + gap::dear_sizes;
  EXPECT_GT(more, runs * run);
  EXPECT_LT(more, runs * run + 500) << "replays of the room";
  EXPECT_EQ(dear.at(gap::GapStage::searching).steps, cheap.at(gap::GapStage::searching).steps);
}

TEST(GapStages, CountDrawnBuildingsWhereThereAreSome) {
  const auto effects = sim::load_effects(sim::find_effects());
  const gap::RcEngine engine(sim::load_room("301"));
  const gap::Library library = gap::library_of(engine, effects);
  const Stage none = gap::GapStages(engine, library, 8, 2).stages().at(gap::GapStage::fitting),
              some = gap::GapStages(engine, library, 8, 2, 96).stages().at(gap::GapStage::fitting);
  EXPECT_EQ(some.steps, none.steps + 2 * 96) << "each lives through both periods";
  EXPECT_NEAR(weighed(some), weighed(none) + 96, 1e-9) << "on two threads";

  struct NoBuildings : gap::ForwardingEngine {
    using ForwardingEngine::ForwardingEngine;
    sim::ChannelTable simulate(const gap::Changes& c, const sim::Recording& r) const override {
      return engine().simulate(c, r);
    }
    bool draws_buildings() const override { return false; }
  };
  const NoBuildings other(engine);
  EXPECT_EQ(gap::GapStages(other, library, 8, 2, 96).stages().at(gap::GapStage::fitting).steps, none.steps);
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
