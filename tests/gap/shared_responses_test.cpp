// What cases of one window may share: recordings alike to the bit share to the bit, other weather costs one run, and
// under other commands two stages end at the effect that simulating everything anew would name.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <set>

#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/blind/blind.hpp"
#include "tools/gap/model/log_window.hpp"
#include "tools/gap/verdict/shared_responses.hpp"

namespace airside::tools::gap {
namespace {

const std::vector<sim::Effect>& some_effects() {
  static const std::vector<sim::Effect> effects = [] {
    const std::set<std::string> some{"solar_gain",       "vav_flow",      "gain_zone",      "fcu_degraded",
                                     "room_sensor_lag",  "mau_setpoint",  "chiller_cop",    "fan_power",
                                     "room_sensor_bias", "thermal_mass",  "infiltration",   "fcu_runs_unrecorded",
                                     "gain_occupied",    "coil_capacity", "swapped_sensors"};
    auto all = sim::load_effects(sim::find_effects());
    std::erase_if(all, [&some](const sim::Effect& e) { return !some.contains(e.name); });
    return all;
  }();
  return effects;
}

/// An RC room that counts its runs.
class CountingRoom final : public Engine {
 public:
  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override {
    ++runs;
    return room_.simulate(changes, recording);
  }
  sim::Channels channels() const override { return room_.channels(); }
  std::array<bool, sim::facades> has_facade() const override { return room_.has_facade(); }
  bool can(const sim::Effect& effect) const override { return room_.can(effect); }
  bool only_shows(const sim::Effect& effect) const override { return room_.only_shows(effect); }
  std::string description() const override { return room_.description(); }
  mutable std::atomic<int> runs = 0;

 private:
  RcEngine room_{sim::load_room("301")};
};

/// Cases of one window: one built room, each with something hidden, people and noise of its own.
struct CasesOfAWindow {
  CountingRoom engine;
  Library all = library_of(engine, some_effects());
  std::shared_ptr<const sim::Weather> weather = sim::synthetic_weather(3);
  sim::RcRoom room = measured_room(sim::load_room("301"), 5, true);
  int days = 8;

  Window window(const std::vector<Hidden>& hidden, std::int64_t after_days, std::uint64_t seed) const {
    const CivilTime start{sim::civil_midnight(2021, 7, 1).seconds + after_days * 86400};
    const MeasuredRun run{start, days, seed, true, 0};
    return window_of(measure(hide(room, hidden, some_effects()), weather, run, hidden), engine.channels(), weather,
                     "case");
  }
  CaseData with(const std::vector<Hidden>& hidden, std::uint64_t seed) const {
    return {window({}, 0, 1), window(hidden, days, seed)};
  }
  WindowResponses all_own(const CaseData& data) const {
    return {simulate_responses(engine, all, data.reference.recording, true, 2),
            simulate_responses(engine, all, data.test.recording, true, 2)};
  }
};

const CasesOfAWindow& cases() {
  static const CasesOfAWindow made;
  return made;
}

void expect_same(const Responses& a, const Responses& b) {
  EXPECT_EQ(a.base, b.base);
  ASSERT_EQ(a.candidates.size(), b.candidates.size());
  for (std::size_t i = 0; i < a.candidates.size(); ++i)
    EXPECT_EQ(a.candidates[i].response, b.candidates[i].response) << a.candidates[i].at.id();
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  for (std::size_t i = 0; i < a.parameters.size(); ++i)
    EXPECT_EQ(a.parameters[i].response, b.parameters[i].response) << a.parameters[i].at.id();
}

TEST(SharedResponses, DigestsTellCommandsFromWeather) {
  const sim::Recording one = cases().window({}, 0, 1).recording;
  sim::Recording other = one;
  EXPECT_EQ(recording_digest(one), recording_digest(other));
  other.rows[100].outdoor_temp_degc += 0.01;
  EXPECT_EQ(command_digest(one), command_digest(other));
  EXPECT_NE(recording_digest(one), recording_digest(other));
  for (int what = 0; what < 4; ++what) {
    other = one;
    sim::RecordedRow& row = other.rows[777];
    if (what == 0) row.vav_on[4] = 1 - row.vav_on[4];
    if (what == 1) row.fcu_on[0] = 1 - row.fcu_on[0];
    if (what == 2) row.setpoint_degc += 0.01;
    if (what == 3) other.from.seconds += 360;
    EXPECT_NE(command_digest(one), command_digest(other)) << what;
  }
}

TEST(SharedResponses, SameCommandsShareToTheBitAndOtherWeatherCostsOneRun) {
  const CountingRoom& engine = cases().engine;
  const sim::Recording recording = cases().window({}, 0, 1).recording;
  const Responses own = simulate_responses(engine, cases().all, recording, true, 2);
  const SharedResponses shared(engine, cases().all, recording, 2);
  const int before = engine.runs;
  const auto same = shared.borrowed(engine, recording);
  EXPECT_EQ(engine.runs, before);
  EXPECT_TRUE(same.own_commands);
  expect_same(same.responses, own);

  sim::Recording warmer = recording;
  for (std::size_t i = 0; i < warmer.rows.size(); ++i) warmer.rows[i].outdoor_temp_degc += i % 2 == 0 ? 0.05 : -0.03;
  const auto borrowed = shared.borrowed(engine, warmer);
  EXPECT_EQ(engine.runs, before + 1);
  EXPECT_TRUE(borrowed.own_commands);
  const Responses anew = simulate_responses(engine, cases().all, warmer, true, 2);
  EXPECT_EQ(borrowed.responses.base, anew.base);
  const int temps = engine.channels().power();
  for (std::size_t i = 0; i < anew.candidates.size(); ++i) {
    const Candidate &a = borrowed.responses.candidates[i], &b = anew.candidates[i];
    if (engine.only_shows(*a.at.effect)) {
      EXPECT_EQ(a.response, b.response) << a.at.id();
    } else {
      EXPECT_LT((a.response - b.response).leftCols(temps).norm(), 0.02 * b.response.leftCols(temps).norm() + 0.05)
          << a.at.id();
    }
  }
}

TEST(SharedResponses, OnlyWhatSensorsShowIsTakenFromTheBase) {
  const CountingRoom& engine = cases().engine;
  const sim::Recording recording = cases().window({}, 0, 1).recording;
  const int before = engine.runs;
  const Responses responses = simulate_responses(engine, cases().all, recording, true, 2);
  int free = 0;
  const Eigen::MatrixXd base = binned(engine.simulate({}, recording), engine.channels());
  for (const Candidate& c : responses.candidates) {
    if (!engine.only_shows(*c.at.effect)) continue;
    ++free;
    EXPECT_EQ(c.response, binned(engine.simulate({{c.at, c.probe}}, recording), engine.channels()) - base) << c.at.id();
  }
  EXPECT_EQ(free, 2 * (5 + 5 + 10)) << "lag, bias, swapped";
  EXPECT_LT(engine.runs - before - free - 1, static_cast<int>(runs_of(cases().all, true)) - free);
}

TEST(SharedResponses, MostUsualCaseIsTheOneBetweenTheOthers) {
  const Window window = cases().window({}, 0, 1);
  std::vector<CaseData> made(3, CaseData{window, window});
  for (std::size_t i = 0; i < 40; ++i) made[0].test.recording.rows[i].setpoint_degc += 2;
  for (std::size_t i = 0; i < 10; ++i) made[1].test.recording.rows[i].setpoint_degc += 1;
  for (std::size_t i = 50; i < 80; ++i) made[2].test.recording.rows[i].fcu_on[1] = 1;
  EXPECT_EQ(most_usual({&made[0], &made[1], &made[2]}), 1U);
  EXPECT_THROW(most_usual({}), std::invalid_argument);
}

/// The usual case has nothing hidden; commands of the others are their own, since control answers what is hidden.
TEST(SharedResponses, TwoStagesEndWhereAllOwnResponsesDo) {
  const CasesOfAWindow& set = cases();
  const SharedWindows shared(set.engine, set.all, set.with({}, 2), 2);
  const std::vector<Hidden> things{{"vav_flow", 2, 0.7}};
  std::uint64_t seed = 10;
  for (const Hidden& hidden : things) {
    const CaseData data = set.with({hidden}, seed++);
    const int before = set.engine.runs;
    const WindowResponses two_stages = shared.of(set.engine, data, {}, 2);
    const int cost = set.engine.runs - before;
    // An engine that does not spare runs has parameters' responses about three models: both fits, and without effects.
    EXPECT_LT(cost, 2 * shortlist_places + 20 + 3 * static_cast<int>(set.all.parameters.size()));
    const WindowResponses own = set.all_own(data);
    const Verdict fast = analyse(set.engine, data, two_stages), slow = analyse(set.engine, data, own);
    ASSERT_FALSE(slow.ranking.empty());
    ASSERT_FALSE(fast.ranking.empty());
    const auto first = [&](const Verdict& v) { return own.test.candidates[v.ranking.front().candidate].at.id(); };
    std::printf("  %-18s two stages: %s, %s, gain %.0f, %d runs; all own: %s, %s, gain %.0f\n", hidden.effect.c_str(),
                text_of(fast.kind), first(fast).c_str(), fast.best_log_likelihood_ratio, cost, text_of(slow.kind),
                first(slow).c_str(), slow.best_log_likelihood_ratio);
    EXPECT_EQ(first(fast), first(slow));
    EXPECT_EQ(first(fast), id_of(hidden, some_effects()));
    EXPECT_EQ(fast.kind, slow.kind);
    ASSERT_EQ(fast.findings.size(), slow.findings.size());
    ASSERT_FALSE(fast.findings.empty());
    const Finding &f = fast.findings.front(), &s = slow.findings.front();
    // What is not on the shortlist keeps borrowed responses, and takes another share of the residual as structure; here
    // even boxes were off at other times.
    EXPECT_NEAR(f.magnitude, s.magnitude, 2 * s.sd + 0.2 * std::abs(s.magnitude - s.at.effect->null_value));
    EXPECT_NEAR(std::log(f.log_likelihood_ratio / s.log_likelihood_ratio), 0, 0.5);
  }
}

}  // namespace
}  // namespace airside::tools::gap
