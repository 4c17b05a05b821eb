// Effects on the EnergyPlus twin: their patches are what the engine's schema allows, and real replays move the
// channels that they should. AIRSIDE_ALL_EFFECTS=1 runs every effect, prints what it does beside the RC room, and at
// which magnitude it shows by 0.1 K, kW or duty (half an hour; AIRSIDE_EFFECTS_CACHE=DIR keeps finished runs).

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <string>
#include <thread>

#include "gap/effects_expected.hpp"
#include "sim/energyplus_install.hpp"
#include "sim/epjson_lint.hpp"
#include "sim/epw.hpp"
#include "sim/merge_patch.hpp"
#include "tools/gap/energyplus_engine.hpp"
#include "tools/gap/residual.hpp"

#define AIRSIDE_NEEDS_ENGINE()                                                                  \
  if (!airside::sim::have_energyplus())                                                         \
  GTEST_SKIP() << "\n*** EnergyPlus is not installed: run tools/setup, or set AIRSIDE_VENV or " \
                  "AIRSIDE_ENERGYPLUS. This test checked nothing. ***"

namespace airside::sim {
namespace {

using tools::gap::Changes;
using tools::gap::EnergyPlusEngine;
using tools::gap::RcEngine;
using tools::gap::Task;

const std::vector<Effect>& library() {
  static const std::vector<Effect> effects =
      load_effects(std::filesystem::path(AIRSIDE_SOURCE_DIR) / "sim" / "effects");
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
      eventful_recording(read_epw(default_weather(find_energyplus()).string()), civil_midnight(2021, 7, 2), 2);
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
  return tools::gap::binned(table) - tools::gap::binned(base);
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
  for (const Shown shown : {Shown::room, Shown::fcu, Shown::mau, Shown::fans, Shown::chiller, Shown::duty}) {
    const ShownResponse one = shown_in(response, at, shown);
    if (one.rms > most.rms) most = one;
  }
  return most;
}

struct AllRuns {
  std::vector<EffectAt> places;                        ///< every place that the expectations name, once
  std::vector<std::array<ChannelTable, 2>> responses;  ///< of a place at its two probes
  ChannelTable base;
};

AllRuns run_all(const tools::gap::Engine& on) {
  AllRuns all;
  std::vector<Task> tasks{{{}, &two_days()}};
  for (const ExpectedSign& expected : expected_signs) {
    const EffectAt at{&effect_named(expected.effect), expected.place};
    if (!all.places.empty() && all.places.back().id() == at.id()) continue;
    all.places.push_back(at);
    for (const double probe : at.effect->probe) tasks.push_back({{{at, probe}}, &two_days()});
  }
  const auto tables = simulate_all(on, tasks, jobs());
  all.base = tables[0];
  for (std::size_t i = 0; i < all.places.size(); ++i)
    all.responses.push_back({response_of(tables[2 * i + 1], all.base), response_of(tables[2 * i + 2], all.base)});
  return all;
}

TEST(EffectsOnEnergyPlus, AllShowWhereTheyShould) {
  AIRSIDE_NEEDS_ENGINE();
  if (std::getenv("AIRSIDE_ALL_EFFECTS") == nullptr)
    GTEST_SKIP() << "set AIRSIDE_ALL_EFFECTS=1 to run every effect (half an hour)";
  const EnergyPlusEngine twin = engine(true);
  const RcEngine room(make_room());
  const Channels at = twin.channels();
  const AllRuns ours = run_all(twin), rc = run_all(room);
  std::printf("%-26s %8s | RC: room fcu mau supply fans chiller duty | EnergyPlus: the same (rms of 30-min means)\n",
              "effect", "at");
  for (std::size_t i = 0; i < ours.places.size(); ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_TRUE(ours.responses[i][k].allFinite()) << ours.places[i].id();
      std::printf("%-26s %8.3g |%s |%s\n", ours.places[i].id().c_str(), ours.places[i].effect->probe[k],
                  groups_text(rc.responses[i][k], at).c_str(), groups_text(ours.responses[i][k], at).c_str());
    }
  }
  for (const ExpectedSign& expected : expected_signs) {
    for (std::size_t i = 0; i < ours.places.size(); ++i) {
      if (expected.effect != ours.places[i].effect->name || expected.place != ours.places[i].place) continue;
      for (std::size_t k = 0; k < 2; ++k)
        expect_shown(expected, ours.places[i].effect->probe[k], ours.responses[i][k], at);
    }
  }

  // Which magnitude shows by 0.1 and 0.3 K, kW or duty: interpolated, then simulated.
  std::printf("%-26s %-18s %12s %8s %12s %8s\n", "effect", "shows most in", "1 x at", "rms", "3 x at", "rms");
  std::vector<Task> tasks;
  std::vector<int> columns;
  for (std::size_t i = 0; i < ours.places.size(); ++i) {
    const Effect& e = *ours.places[i].effect;
    const double upward = (e.high - e.null_value) >= (e.null_value - e.low) ? 1 : -1;
    const bool second = (e.probe[1] - e.null_value) * upward > (e.probe[0] - e.null_value) * upward;
    const std::size_t k = second ? 1 : 0;
    const ShownResponse most = shows_most(ours.responses[i][k], at);
    columns.push_back(most.column);
    for (const double times : {1.0, 3.0}) {
      const double m = e.null_value + 0.1 * times / std::max(1e-9, most.rms) * (e.probe[k] - e.null_value);
      tasks.push_back({{{ours.places[i], std::clamp(m, e.low, e.high)}}, &two_days()});
    }
  }
  const auto tables = simulate_all(twin, tasks, jobs());
  for (std::size_t i = 0; i < ours.places.size(); ++i) {
    std::printf("%-26s %-18s", ours.places[i].id().c_str(), at.name(columns[i]).c_str());
    for (const std::size_t k : {2 * i, 2 * i + 1}) {
      const double m = tasks[k].changes[0].magnitude;
      const bool bound = m == ours.places[i].effect->low || m == ours.places[i].effect->high;
      std::printf(" %11.4g%s %8.4f", m, bound ? "*" : " ",
                  shown_in(response_of(tables[k], ours.base), columns[i], 1).rms);
    }
    std::printf("\n");
  }
  std::printf("*: at the effect's bound\n");
}

}  // namespace
}  // namespace airside::sim
