// Two effects that a log cannot tell apart: the proposed test must, on a room that is not the model.
#include "tools/gap/explain/experiment.hpp"
#include "tools/gap/inference/null_blocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "sim/rc/rc_plant.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/blind/blind.hpp"
#include "tools/gap/model/log_window.hpp"

namespace airside::tools::gap {
namespace {

const std::vector<sim::Effect>& all_effects() {
  static const std::vector<sim::Effect> list = sim::load_effects(sim::find_effects());
  return list;
}

const sim::Effect& effect(const std::string& name) {
  const auto& list = all_effects();
  const auto found = std::find_if(list.begin(), list.end(), [&](const sim::Effect& e) { return e.name == name; });
  if (found == list.end()) throw std::runtime_error("no effect " + name);
  return *found;
}

/// Enough of the library to be honest about what is uncertain, little enough for a test.
Library small_library(const Engine& engine, const std::vector<std::string>& candidates) {
  const auto one_of = [](const std::vector<std::string>& names) {
    return [&names](const sim::EffectAt& at) {
      return std::find(names.begin(), names.end(), at.effect->name) == names.end();
    };
  };
  static const std::vector<std::string> parameters = {
      "gain_base",      "gain_occupied", "occupancy_shift", "infiltration", "envelope_u",
      "neighbour_heat", "solar_gain",    "thermal_mass",    "vav_flow",     "supply_sensor_offset"};
  Library library = library_of(engine, all_effects());
  std::erase_if(library.parameters, one_of(parameters));
  std::erase_if(library.candidates, one_of(candidates));
  return library;
}

/// A room in which one of two effects is hidden, the window that cannot tell which, and the model's view of it.
struct AlikeCase {
  sim::RcRoom room;
  std::shared_ptr<const sim::Weather> weather;
  RcEngine engine;
  Library library;
  Window reference, test;
  Responses at_reference, at_test;
  ReferenceFit fit;
  Nuisance nuisance;
  Changes fitted;
  std::vector<sim::EffectChange> members;  ///< the hidden one first
  double gain_hidden = 0, gain_other = 0;

  AlikeCase(std::uint64_t seed, const Hidden& hidden, const sim::EffectAt& other, bool feedback)
      : room(measured_room(sim::make_room(), seed, feedback)),
        weather(sim::synthetic_weather(seed)),
        engine(sim::make_room()),
        library(small_library(engine, {hidden.effect, other.effect->name})) {
    MeasuredRun run;
    run.start = sim::civil_midnight(2023, 7, 3);
    run.days = 8;
    run.seed = seed;
    run.feedback = feedback;
    const auto window = [&](const sim::RcRoom& lived, const MeasuredRun& how) {
      return window_of(measure(lived, weather, how), engine.channels(), weather, "test");
    };
    reference = window(room, run);
    run.start.seconds += run.days * seconds_per_day;
    ++run.seed;
    room = hide(room, {hidden}, all_effects());
    test = window(room, run);
    at_reference = simulate_responses(engine, library, reference.recording, true, 1);
    at_test = simulate_responses(engine, library, test.recording, true, 1);
    fit = fit_reference(engine, at_reference, reference);
    fitted = fit.changes();
    nuisance = null_blocks(fit, at_reference, reference).nuisance;
    for (const sim::EffectAt& at : {sim::EffectAt{&effect(hidden.effect), hidden.place}, other}) fit_member(at);
  }

  void fit_member(const sim::EffectAt& at) {
    const auto kept = counted_bins(test.measured.rows());
    const Metric metric(nuisance_directions(fit, at_test, kept, test.measured, nuisance));
    const auto whiten = [&](const Eigen::MatrixXd& x) { return fit.noise.whiten(x, kept, test.measured); };
    const Eigen::MatrixXd base = binned(engine.simulate(fitted, test.recording), engine.channels());
    const Eigen::MatrixXd residual = test.measured - base - fit.structural(at_test);
    double best = -1, magnitude = 0;
    for (const Candidate& c : at_test.candidates) {
      if (c.at.id() != at.id()) continue;
      double m = c.probe;
      for (int i = 0; i < 2; ++i) {
        Changes changes = fitted;
        changes.push_back({at, m});
        const Eigen::VectorXd z = whiten(binned(engine.simulate(changes, test.recording), engine.channels()) - base),
                              r = whiten(residual);
        const double zz = metric.dot(z, z), zr = metric.dot(z, r), log_likelihood_ratio = zr > 0 ? zr * zr / zz : 0;
        if (log_likelihood_ratio > best) {
          best = log_likelihood_ratio;
          magnitude = std::clamp(at.effect->null_value + zr / zz * (m - at.effect->null_value), at.effect->low,
                                 at.effect->high);
        }
        if (zr > 0) m = magnitude;
      }
    }
    (members.empty() ? gain_hidden : gain_other) = best;
    members.push_back({at, magnitude});
  }

  std::vector<ExperimentProposal> propose() const {
    ExperimentRules rules;
    rules.nuisance = nuisance;
    return propose_experiments(engine, test, fit, at_test, members, fitted, 1, rules);
  }

  /// Does the test on the true room, a week later, and returns the 2 ln likelihood by which the hidden member has
  /// gained on the other since the window.
  double really(const std::string& name, std::uint64_t seed) const {
    const auto plans = test_plans(engine.channels(), members);
    const auto plan = std::find_if(plans.begin(), plans.end(), [&](const TestPlan& p) { return p.name == name; });
    const auto commands = test_recording(test.recording, *plan);
    Window done;
    done.recording = commands->recording;
    done.recording.from.seconds += 7 * 86400;
    const bool own_thermostats = !plan->fcu_command;
    const auto followed = std::make_shared<const sim::Recording>(done.recording);
    sim::RcPlant plant(room, weather, {done.recording.from.seconds - 3 * 86400}, seed);
    plant.follow(followed, own_thermostats);
    const sim::Channels at = engine.channels();
    sim::ChannelTable table(std::ssize(done.recording.rows), at.count());
    while (plant.time() < done.recording.to()) {
      const CivilTime t = plant.time();
      plant.set_setpoint(followed->at(t).setpoint_degc);
      if (!(t < done.recording.from)) {
        const auto i = static_cast<std::size_t>((t.seconds - done.recording.from.seconds) / row_s);
        const sim::Sensors& s = plant.sensors();
        sim::RecordedRow& row = done.recording.rows[i];
        row.vav_on = s.vav_on;
        row.fcu_on = s.fcu_on;
        row.outdoor_temp_degc = s.outdoor_temp_degc;
        row.rain = s.rain;
        Eigen::Index column = 0;
        for (const auto* list : {&s.room_temp_degc, &s.fcu_temp_degc}) {
          for (const double v : *list) table(static_cast<Eigen::Index>(i), column++) = v;
        }
        table(static_cast<Eigen::Index>(i), column++) = s.mau_temp_degc;
        table(static_cast<Eigen::Index>(i), column++) = s.supply_temp_degc;
        for (const double v : s.power_kw) table(static_cast<Eigen::Index>(i), column++) = v;
        for (const double v : s.fcu_on)
          table(static_cast<Eigen::Index>(i), column++) =
              own_thermostats ? v : std::numeric_limits<double>::quiet_NaN();
      }
      plant.advance_to({t.seconds + row_s});
    }
    done.measured = binned(table, engine.channels());
    const Responses at_done = simulate_responses(engine, library, done.recording, true, 1);
    const ExperimentOutcome outcome =
        judge_experiment(engine, test, done, commands->first_row, fit, at_test, at_done, members, fitted, nuisance);
    return outcome.both[0] - outcome.both[1] - (outcome.window[0] - outcome.window[1]);
  }
};

AlikeCase leaky_or_thin(std::uint64_t seed) {
  return {seed, {"infiltration", 0, 0.5}, {&effect("envelope_u"), 0}, false};
}
AlikeCase machines_or_neighbours(std::uint64_t seed) {
  return {seed, {"gain_base", 0, 4}, {&effect("neighbour_heat"), 0}, true};
}

TEST(Experiment, PowerIsThatOfASimulatedDecision) {
  // Two directions at an angle; a decision at 5 % error under b, asked how often it finds a.
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const double size = 12, cosine = 0.97, sine = std::sqrt(1 - cosine * cosine);
  const double separation = size * size * sine * sine;
  const auto draw = [&](bool a) {
    const double along = (a ? size : size * cosine) + normal(random);
    const double beside = (a ? 0 : size * sine) + normal(random);
    const double other = along * cosine + beside * sine;
    return along * along - other * other;
  };
  std::vector<double> under_b(20000);
  for (double& x : under_b) x = draw(false);
  std::nth_element(under_b.begin(), under_b.begin() + 19000, under_b.end());
  const double limit = under_b[19000];
  int found = 0;
  for (int i = 0; i < 20000; ++i) found += draw(true) > limit ? 1 : 0;
  EXPECT_NEAR(found / 20000.0, power_of(separation), 0.02);
  EXPECT_NEAR(power_of(0), 0.05, 1e-6);
}

TEST(Experiment, TestsChangeCommandsInTheirHoursOnly) {
  sim::Recording recording;
  recording.from = sim::civil_midnight(2023, 7, 3);  // a Monday
  recording.rows.assign(8 * rows_per_day, {23, {1, 1}, {0, 0}, 30, 0, {}});
  const sim::Channels channels{2, 2, 1};
  for (const TestPlan& plan : test_plans(channels, {})) {
    const auto test = test_recording(recording, plan);
    ASSERT_TRUE(test) << plan.name;
    EXPECT_GE(test->first_row, 2u * rows_per_day) << plan.name;
    for (std::size_t i = 0; i < test->recording.rows.size(); ++i) {
      const sim::RecordedRow& row = test->recording.rows[i];
      const bool changed = row.setpoint_degc != 23 || row.vav_on[0] != 1 || row.fcu_on[0] != 0;
      const double hour = test->recording.time(i).second_of_day() / 3600.0;
      const bool in_hours =
          plan.to_h > plan.from_h ? hour >= plan.from_h && hour < plan.to_h : hour >= plan.from_h || hour < plan.to_h;
      if (changed) {
        EXPECT_TRUE(in_hours && i >= test->first_row) << plan.name << " at " << hour;
        EXPECT_TRUE(!plan.weekend || test->recording.time(i).weekday() >= 5) << plan.name;
      }
    }
    EXPECT_TRUE(test->changed > 0 || plan.name == "fcu_off") << plan.name;  // they rest anyway
  }
  recording.rows.resize(3 * rows_per_day);
  EXPECT_FALSE(test_recording(recording, test_plans(channels, {}).front()));
}

void proposed_test_decides(const AlikeCase& c, std::uint64_t seed) {
  const auto proposals = c.propose();
  ASSERT_GE(proposals.size(), 5u);
  const ExperimentProposal &best = proposals.front(), &least = proposals.back();
  EXPECT_GT(best.separation, 2 * least.separation);
  EXPECT_FALSE(best.upper_bound);
  EXPECT_GE(best.lowest_room_degc, 18);
  EXPECT_LE(best.highest_room_degc, 30);
  const double really = c.really(best.name, seed);
  EXPECT_GT(really, 0);
  EXPECT_GT(really, c.really(least.name, seed));
}

TEST(Experiment, TellsALeakFromAThinWall) { proposed_test_decides(leaky_or_thin(3), 91); }
TEST(Experiment, TellsMachinesFromNeighbours) { proposed_test_decides(machines_or_neighbours(3), 92); }

TEST(Experiment, SaysWhenNoTestSeparates) {
  // The same effect under two names.
  AlikeCase c = leaky_or_thin(4);
  sim::Effect twin = *c.members[0].at.effect;
  twin.name = "infiltration_again";
  c.members[1] = {{&twin, 0}, c.members[0].magnitude};
  const auto proposals = c.propose();
  ASSERT_FALSE(proposals.empty());
  EXPECT_FALSE(proposals.front().separates);
  EXPECT_LT(proposals.front().power, 0.3);
  EXPECT_NE(sentence_of(proposals).find("no test"), std::string::npos) << sentence_of(proposals);
  EXPECT_TRUE(
      propose_experiments(c.engine, c.test, c.fit, c.at_test, std::span(c.members).first(1), c.fitted, 1).empty());
}

/// Figures for the report: --gtest_also_run_disabled_tests --gtest_filter=*Study*
TEST(Experiment, DISABLED_Study) {
  for (const bool leak : {true, false}) {
    for (std::uint64_t seed = 11; seed < 17; ++seed) {
      const AlikeCase c = leak ? leaky_or_thin(seed) : machines_or_neighbours(seed);
      const auto proposals = c.propose();
      std::printf("%s seed %d: gains %.0f %.0f magnitudes %.2f %.2f\n", leak ? "leak" : "machines",
                  static_cast<int>(seed), c.gain_hidden, c.gain_other, c.members[0].magnitude, c.members[1].magnitude);
      for (std::size_t i = 0; i < proposals.size(); ++i) {
        const ExperimentProposal& p = proposals[i];
        std::printf("  %-18s sep %7.1f power %.2f hours %4.0f %s%s %.1f..%.1f", p.name.c_str(), p.separation, p.power,
                    p.hours, p.comfortable ? "" : "hot ", p.upper_bound ? "bound" : "", p.lowest_room_degc,
                    p.highest_room_degc);
        if (i < 2 || i + 1 == proposals.size()) {
          for (std::uint64_t again = 0; again < 2; ++again) std::printf("  really %.1f", c.really(p.name, 90 + again));
        }
        std::printf("\n");
      }
      std::printf("  %s\n", sentence_of(proposals).c_str());
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace airside::tools::gap
