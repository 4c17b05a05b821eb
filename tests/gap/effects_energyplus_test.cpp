// Effects on the EnergyPlus twin: their patches are what the engine's schema allows, and real replays move the
// channels that they should. AIRSIDE_ALL_EFFECTS=1 (or names with commas between) runs every effect, prints what it
// does beside the RC room, and at which magnitude it shows by 0.1 K or kW (10 minutes; AIRSIDE_EFFECTS_CACHE=DIR keeps
// finished runs).

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <string>
#include <thread>

#include "gap/effects_expected.hpp"
#include "gap/needs_engine.hpp"
#include "sim/energyplus/epjson_lint.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/json/merge_patch.hpp"
#include "sim/weather/epw.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/model/energyplus_engine.hpp"
#include "tools/gap/model/residual.hpp"
#include "tools/gap/model/responses.hpp"

namespace airside::sim {
namespace {

using tools::gap::Changes;
using tools::gap::EnergyPlusEngine;
using tools::gap::RcEngine;
using tools::gap::Task;

const std::vector<Effect>& library() {
  static const std::vector<Effect> effects =
      load_effects(std::filesystem::path(AIRSIDE_SOURCE_DIR) / "sim" / "effects" / "library");
  return effects;
}

const Effect& effect_named(std::string_view name) {
  for (const Effect& e : library()) {
    if (e.name == name) return e;
  }
  throw std::logic_error("no effect " + std::string(name));
}

EnergyPlusEngine engine(bool duties) {
  const char* cache = std::getenv("AIRSIDE_EFFECTS_CACHE");
  return {twin_of(energyplus_room("twin")), "twin", cache == nullptr ? "" : cache, duties};
}

/// Friday and Saturday of a July in Tampa.
const Recording& two_days() {
  static const Recording recording =
      eventful_recording(read_epw(default_weather(find_energyplus()).string()), civil_midnight(2021, 7, 2), 2, 19, 13);
  return recording;
}

int jobs() { return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 8); }

TEST(EffectsOnEnergyPlus, PatchesAreWhatTheSchemaAllows) {
  AIRSIDE_NEEDS_ENGINE();
  const EnergyPlusEngine twin = engine(false);
  const auto schema = find_energyplus().schema;
  for (const Effect& e : library()) {
    if (!e.on_energyplus) continue;
    const auto places = places_of(e, twin.channels(), twin.has_facade());
    ASSERT_FALSE(places.empty()) << e.name;
    for (const EffectAt& at : places) {
      for (const double m : {e.low, e.high, e.probe[0], e.probe[1], e.null_value + e.prior_sd}) {
        const EffectChange change[] = {{at, m}};
        const auto patch = model_patch(twin.twin().model, twin.twin().names, change);
        for (const auto& complaint : epjson_complaints(patch, schema, {at.id(), LintScope::patch}))
          ADD_FAILURE() << "at " << m << ": " << complaint.what();
        // Names that new objects refer to: only a whole model shows that they exist.
        if (at.place != places.back().place || m != e.probe[0]) continue;
        const auto whole = merge_patched(twin.twin().model, patch, at.id());
        for (const auto& complaint : epjson_complaints(whole, schema, {at.id(), LintScope::whole}))
          ADD_FAILURE() << "at " << m << ": " << complaint.what();
      }
    }
  }
}

const char* text_of(Shown shown) {
  constexpr const char* names[] = {"room", "fcu", "mau", "supply", "fans", "chiller", "duty"};
  return names[static_cast<int>(shown)];
}

/// Duties are 0 or 1 in a row, and say something as means only.
ChannelTable response_of(const ChannelTable& table, const ChannelTable& base) {
  return tools::gap::binned(table, {}) - tools::gap::binned(base, {});
}

void expect_shown(const ExpectedSign& expected, double probe, const ChannelTable& response, const Channels& at) {
  const Effect& effect = effect_named(expected.effect);
  const std::string which =
      EffectAt{&effect, expected.place}.id() + " at " + std::to_string(probe) + " in " + text_of(expected.shown);
  const ShownResponse shown = shown_in(response, at, expected.shown);
  std::printf("  %-50s rms %.4f, mean %+.4f\n", which.c_str(), shown.rms, shown.mean);
  EXPECT_GT(shown.rms, 0.003) << which;
  if (expected.sign != 0) {
    EXPECT_GT(expected.sign * (probe > effect.null_value ? 1 : -1) * shown.mean, 0) << which;
  }
}

/// One of each kind of change: fields, new objects, schedules, a program of the engine, loops, commands, clock,
/// weather.
TEST(EffectsOnEnergyPlus, OneOfEachKindShowsWhereItShould) {
  AIRSIDE_NEEDS_ENGINE();
  const EnergyPlusEngine twin = engine(false);
  constexpr std::string_view some[] = {"solar_gain",   "infiltration_wind", "gain_weekend",     "thermal_mass",
                                       "fcu_degraded", "duct_leak",         "mau_capacity",     "rain_cooling",
                                       "vav_stuck",    "clock_shift",       "humidity_differs", "supply_sensor_offset"};
  std::vector<Task> tasks{{{}, &two_days()}};
  std::vector<EffectChange> ran;
  for (const std::string_view name : some) {
    const auto* expected = std::find_if(std::begin(expected_signs), std::end(expected_signs),
                                        [name](const ExpectedSign& e) { return e.effect == name; });
    const Effect& effect = effect_named(name);
    ran.push_back({{&effect, expected->place}, effect.probe[1]});
    tasks.push_back({{ran.back()}, &two_days()});
  }
  const auto tables = simulate_all(twin, tasks, jobs());
  for (std::size_t i = 0; i < ran.size(); ++i) {
    const EffectAt& at = ran[i].at;
    const ChannelTable response = response_of(tables[i + 1], tables[0]);
    EXPECT_TRUE(response.leftCols(twin.channels().fcu_duty()).allFinite()) << at.id();
    for (const ExpectedSign& expected : expected_signs) {
      if (expected.effect == at.effect->name && expected.place == at.place && expected.shown != Shown::duty)
        expect_shown(expected, ran[i].magnitude, response, twin.channels());
    }
  }
}

/// A line of the table: root mean squares by group.
std::string groups_text(const ChannelTable& response, const Channels& at) {
  std::string text;
  for (const Shown shown :
       {Shown::room, Shown::fcu, Shown::mau, Shown::supply, Shown::fans, Shown::chiller, Shown::duty}) {
    char field[32];
    std::snprintf(field, sizeof field, " %6.3f", shown_in(response, at, shown).rms);
    text += field;
  }
  return text;
}

/// The channel that shows a response most, supply left out: the workflow does not compare it.
ShownResponse shows_most(const ChannelTable& response, const Channels& at) {
  ShownResponse most;
  for (const Shown shown : {Shown::room, Shown::fcu, Shown::mau, Shown::fans, Shown::chiller}) {
    const ShownResponse one = shown_in(response, at, shown);
    if (one.rms > most.rms) most = one;
  }
  return most;
}

/// AIRSIDE_ALL_EFFECTS: absent: none; 1: all; else names with commas between.
bool asked(const std::string& name) {
  const char* names = std::getenv("AIRSIDE_ALL_EFFECTS");
  if (names == nullptr) return false;
  return names == std::string("1") || (std::string(",") + names + ",").find("," + name + ",") != std::string::npos;
}
bool any_asked() { return std::getenv("AIRSIDE_ALL_EFFECTS") != nullptr; }

struct AllRuns {
  std::vector<EffectAt> places;         ///< every place that the expectations name, once
  std::vector<ChannelTable> responses;  ///< of each
};

AllRuns run_all(const tools::gap::Engine& on, std::size_t probe) {
  AllRuns all;
  std::vector<Task> tasks{{{}, &two_days()}};
  for (const ExpectedSign& expected : expected_signs) {
    const EffectAt at{&effect_named(expected.effect), expected.place};
    if (!asked(at.effect->name) || (!all.places.empty() && all.places.back().id() == at.id())) continue;
    all.places.push_back(at);
    tasks.push_back({{{at, at.effect->probe[probe]}}, &two_days()});
  }
  const auto tables = simulate_all(on, tasks, jobs());
  for (std::size_t i = 1; i < tables.size(); ++i) all.responses.push_back(response_of(tables[i], tables[0]));
  return all;
}

constexpr const char* how_to_ask = "set AIRSIDE_ALL_EFFECTS=1 to run every effect";

void expect_all_shown(std::size_t probe) {
  const EnergyPlusEngine twin = engine(false);
  const Channels at = twin.channels();
  const AllRuns ours = run_all(twin, probe), rc = run_all(RcEngine(make_room()), probe);
  std::printf(
      "RC: room fcu mau supply fans chiller duty | EnergyPlus: the same (rms of 30-min means) | 1 x, 3 x 0.1\n");
  for (std::size_t i = 0; i < ours.places.size(); ++i) {
    const Effect& e = *ours.places[i].effect;
    EXPECT_TRUE(ours.responses[i].leftCols(at.fcu_duty()).allFinite()) << ours.places[i].id();
    const ShownResponse most = shows_most(ours.responses[i], at);
    std::printf("%-24s %7.3g |%s |%s | %-17s", ours.places[i].id().c_str(), e.probe[probe],
                groups_text(rc.responses[i], at).c_str(), groups_text(ours.responses[i], at).c_str(),
                at.name(most.column).c_str());
    for (const double times : {1.0, 3.0}) {
      const double m = e.null_value + 0.1 * times / std::max(1e-9, most.rms) * (e.probe[probe] - e.null_value);
      std::printf(" %.4g%s", std::clamp(m, e.low, e.high), m < e.low || m > e.high ? "*" : "");
    }
    std::printf("\n");
  }
  std::printf("*: at the effect's bound, which shows less\n");
  for (const ExpectedSign& expected : expected_signs) {
    for (std::size_t i = 0; expected.shown != Shown::duty && i < ours.places.size(); ++i) {
      if (expected.effect == ours.places[i].effect->name && expected.place == ours.places[i].place)
        expect_shown(expected, ours.places[i].effect->probe[probe], ours.responses[i], at);
    }
  }
}

TEST(EffectsOnEnergyPlus, AllShowAtTheirSecondProbe) {
  AIRSIDE_NEEDS_ENGINE();
  if (!any_asked()) GTEST_SKIP() << how_to_ask;
  expect_all_shown(1);
}

TEST(EffectsOnEnergyPlus, AllShowAtTheirFirstProbe) {
  AIRSIDE_NEEDS_ENGINE();
  if (!any_asked()) GTEST_SKIP() << how_to_ask;
  expect_all_shown(0);
}

TEST(EffectsOnEnergyPlus, ThermostatsAnswerWithDuty) {
  AIRSIDE_NEEDS_ENGINE();
  if (!any_asked()) GTEST_SKIP() << how_to_ask;
  const EnergyPlusEngine twin = engine(true);
  std::vector<Task> tasks{{{}, &two_days()}};
  std::vector<ExpectedSign> ran;
  for (const ExpectedSign& expected : expected_signs) {
    if (expected.shown != Shown::duty || !asked(std::string(expected.effect))) continue;
    const Effect& effect = effect_named(expected.effect);
    ran.push_back(expected);
    tasks.push_back({{{{&effect, expected.place}, effect.probe[1]}}, &two_days()});
  }
  const auto tables = simulate_all(twin, tasks, jobs());
  for (std::size_t i = 0; i < ran.size(); ++i) {
    const ChannelTable response = response_of(tables[i + 1], tables[0]);
    EXPECT_TRUE(response.allFinite());
    expect_shown(ran[i], effect_named(ran[i].effect).probe[1], response, twin.channels());
  }
}

/// An RC room that spares runs as the engine does, and counts them.
class SparingRoom final : public tools::gap::Engine {
 public:
  explicit SparingRoom(bool spares) : spares_(spares) {}
  ChannelTable simulate(const tools::gap::Changes& changes, const Recording& recording) const override {
    ++runs;
    return room_.simulate(changes, recording);
  }
  Channels channels() const override { return room_.channels(); }
  std::array<bool, facades> has_facade() const override { return room_.has_facade(); }
  bool can(const Effect& effect) const override { return room_.can(effect); }
  bool spares_runs() const override { return spares_; }
  std::string description() const override { return room_.description(); }
  mutable int runs = 0;

 private:
  RcEngine room_{make_room()};
  bool spares_;
};

TEST(Responses, EngineThatSparesRunsTakesParametersFromTheProbesAroundThem) {
  const SparingRoom every(false), sparing(true);
  const Channels five = every.channels();
  const Recording weekend = eventful_recording(synthetic_weather(3), civil_midnight(2021, 7, 2), 3, 12, 4);
  tools::gap::Library some;
  for (const char* name : {"solar_gain", "vav_flow", "mixing_interior", "fcu_degraded", "gain_occupied"}) {
    for (const EffectAt& at : places_of(effect_named(name), five, every.has_facade())) {
      some.parameters.push_back(at);
      some.candidates.push_back(at);
    }
  }
  // Kept out of the candidates: nothing to take it from.
  some.candidates.pop_back();
  int done = 0;
  const auto simulated = simulate_responses(every, some, weekend, true, 1);
  const auto spared = simulate_responses(sparing, some, weekend, true, 1, [&done] { ++done; });
  EXPECT_EQ(every.runs, static_cast<int>(tools::gap::runs_of(some, true)));
  EXPECT_EQ(done, every.runs);
  ASSERT_EQ(spared.parameters.size(), simulated.parameters.size());
  int saved = 0;
  for (std::size_t i = 0; i < spared.parameters.size(); ++i) {
    const Eigen::MatrixXd& there = simulated.parameters[i].response;
    const Eigen::MatrixXd& here = spared.parameters[i].response;
    const std::string id = some.parameters[i].id();
    // A fan coil's probes lie on the worse side, its parameter on the better one; twice the mixing is not twice the
    // response.
    if (id.starts_with("fcu_degraded") || id == "mixing_interior" || id == "gain_occupied") {
      EXPECT_EQ(here, there) << id;
      continue;
    }
    ++saved;
    const auto temps = [&five](const Eigen::MatrixXd& x) { return x.leftCols(five.power()); };
    std::printf("  %-18s off by %.3f of its response\n", id.c_str(),
                (temps(here) - temps(there)).norm() / temps(there).norm());
    EXPECT_GT(temps(there).norm(), 0) << id;
    EXPECT_LT((temps(here) - temps(there)).norm(), 0.15 * temps(there).norm()) << id;
  }
  EXPECT_GT(saved, 5);
  EXPECT_EQ(sparing.runs, every.runs - saved);
  ASSERT_EQ(spared.candidates.size(), simulated.candidates.size());
  for (std::size_t i = 0; i < spared.candidates.size(); ++i) {
    EXPECT_EQ(spared.candidates[i].response, simulated.candidates[i].response);
    EXPECT_EQ(spared.candidates[i].probe, simulated.candidates[i].probe);
  }
}

}  // namespace
}  // namespace airside::sim
