// The blind generator on RC rooms: the key stays apart, files betray nothing, seeds repeat, what is hidden is there and
// only where it should be.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "hal/text/input_error.hpp"
#include "sim/rc/rc_plant.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "support/test_folder.hpp"
#include "tools/gap/blind/blind_cases.hpp"
#include "tools/gap/case/case_loader.hpp"

namespace airside::tools::gap {
namespace {

namespace fs = std::filesystem;

const std::vector<sim::Effect>& library() {
  static const std::vector<sim::Effect> effects = sim::load_effects(sim::find_effects());
  return effects;
}

BlindPlan small_plan(std::uint64_t seed) {
  BlindPlan plan;
  plan.single = 4;
  plan.null = 3;
  plan.outside = 6;
  plan.pairs = 1;
  plan.seed = seed;
  plan.days = 3;
  plan.rough = true;
  return plan;
}

/// All files of a folder by their names seen from it.
std::map<std::string, std::string> contents_of(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    contents[fs::relative(entry.path(), folder).string()] = {std::istreambuf_iterator<char>(in), {}};
  }
  return contents;
}

/// One generated set for all tests that only look.
struct MadeSet {
  hal::TestFolder root;
  fs::path folder = root.file("cases"), key = root.file("key.json");
  int steps = 0;
  MadeSet(const std::string& name, std::uint64_t seed) : root("blind_" + name) {
    make_blind_cases(small_plan(seed), library(), folder, key, [this] { ++steps; });
  }
  nlohmann::json answers() const { return nlohmann::json::parse(std::ifstream(key)); }
};

const MadeSet& made_set() {
  static const MadeSet set("once", 7);
  return set;
}

TEST(Blind, RefusesAKeyAmongTheCasesAndAFolderThatIsNotEmpty) {
  const hal::TestFolder root("blind_key");
  const fs::path folder = root.file("cases");
  EXPECT_THROW(make_blind_cases(small_plan(1), library(), folder, folder / "key.json"), hal::InputError);
  EXPECT_THROW(make_blind_cases(small_plan(1), library(), folder, folder / "more" / "key.json"), hal::InputError);
  fs::create_directories(folder);
  std::ofstream(folder / "note") << "here";
  EXPECT_THROW(make_blind_cases(small_plan(1), library(), folder, root.file("key.json")), hal::InputError);
}

TEST(Blind, RepeatsEveryByteForASeedAndNoneOfTheLogsForAnother) {
  const MadeSet again("again", 7), other("other", 8);
  const auto first = contents_of(made_set().folder), second = contents_of(again.folder);
  EXPECT_EQ(first, second);
  EXPECT_EQ(made_set().answers(), again.answers());
  const auto third = contents_of(other.folder);
  ASSERT_EQ(first.size(), third.size());
  for (const auto& [name, bytes] : first) {
    if (name.ends_with(".csv")) {
      EXPECT_NE(bytes, third.at(name)) << name;
    }
  }
}

void expect_nothing_betrayed() {
  const nlohmann::json cases = made_set().answers()["cases"];
  EXPECT_EQ(cases.size(), 14U);
  std::set<fs::file_time_type> times;
  for (const auto& entry : fs::recursive_directory_iterator(made_set().folder)) times.insert(entry.last_write_time());
  EXPECT_EQ(times.size(), 1U) << "the order of writing";
  std::size_t smallest = 1U << 30, largest = 0;
  std::set<std::set<std::string>> keys;
  for (const auto& [name, bytes] : contents_of(made_set().folder)) {
    if (name.ends_with("measured.csv")) {
      smallest = std::min(smallest, bytes.size());
      largest = std::max(largest, bytes.size());
    }
    if (!name.ends_with("case.json")) continue;
    std::set<std::string> here;
    const nlohmann::json file = nlohmann::json::parse(bytes);
    for (const auto& [key, value] : file.items()) here.insert(key);
    keys.insert(here);
    for (const char* word : {"single", "null", "outside", "pair", "seed", "ratio", "hidden"})
      EXPECT_EQ(bytes.find(word), std::string::npos) << name << " says " << word;
  }
  EXPECT_EQ(keys.size(), 1U) << "case files that differ in their keys";
  EXPECT_LT(static_cast<double>(largest), 1.05 * static_cast<double>(smallest));
  // Names in order: the sets must not stand in blocks.
  int changes = 0;
  std::string last;
  for (const auto& [name, answer] : cases.items()) {
    changes += answer["set"] != last ? 1 : 0;
    last = answer["set"];
  }
  EXPECT_GE(changes, 7);
}

void expect_key_tells_what_was_reached() {
  std::map<std::string, int> sets;
  std::set<std::string> outside;
  const nlohmann::json cases = made_set().answers()["cases"];
  for (const auto& [name, answer] : cases.items()) {
    const std::string set = answer["set"];
    ++sets[set];
    const auto& hidden = answer["hidden"];
    ASSERT_EQ(hidden.size(), set == "null" ? 0U : set == "pair" ? 2U : 1U) << name;
    for (const auto& one : hidden) {
      const std::string id = one["id"], effect = id.substr(0, id.find('@'));
      EXPECT_EQ(find_effect(library(), effect) == nullptr, set == "outside") << id;
      if (set == "outside") outside.insert(effect);
      ASSERT_TRUE(one["achieved_ratio"].is_number()) << id;
      const double reached = one["achieved_ratio"], wanted = answer["ratio"];
      if (set != "outside") {
        EXPECT_GE(reached, 0.8 * wanted) << id;
        if (wanted < 3) {
          EXPECT_LE(reached, 1.5 * wanted) << id;
        }
      } else {
        EXPECT_GT(reached, 0.5) << id << " shows nowhere";
      }
    }
  }
  EXPECT_EQ(sets, (std::map<std::string, int>{{"single", 4}, {"null", 3}, {"outside", 6}, {"pair", 1}}));
  EXPECT_EQ(outside, std::set<std::string>(outside_kinds().begin(), outside_kinds().end()));
}

// One test, since each test is a process and would make the set again.
TEST(Blind, BetraysNothingKeyTellsWhatWasReachedAndCasesCanBeLoaded) {
  EXPECT_EQ(made_set().steps, blind_steps(small_plan(7)));
  expect_nothing_betrayed();
  expect_key_tells_what_was_reached();
  const auto folders = case_folders(made_set().folder);
  ASSERT_EQ(folders.size(), 14U);
  const LoadedCase c = load_case(read_case(folders.front()), "first", {});
  EXPECT_EQ(c.data.test.recording.rows.size(), 3U * rows_per_day);
  EXPECT_EQ(c.data.reference.recording.to(), c.data.test.recording.from);
}

/// A week of a measured room, with something hidden in it or not.
struct Week {
  sim::RcRoom room = with_other_structure(measured_room(sim::load_room("301"), 5, false), 5);
  std::shared_ptr<const sim::Weather> weather = sim::synthetic_weather(3);
  MeasuredRun run{sim::civil_midnight(2021, 7, 1), 7, 11, false, 0};

  std::vector<hal::LogRow> with(const std::vector<Hidden>& hidden) const {
    return measure(hide(room, hidden, library()), weather, run, hidden);
  }
};

int rows_that_differ(const std::vector<hal::LogRow>& a, const std::vector<hal::LogRow>& b) {
  int count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i].value != b[i].value ? 1 : 0;
  return count;
}

TEST(Blind, EveryEffectOfTheLibraryChangesTheMeasuredLog) {
  const Week week;
  const auto untouched = week.with({});
  EXPECT_EQ(rows_that_differ(untouched, week.with({})), 0);
  int hideable = 0;
  for (const sim::Effect& e : library()) {
    if (!rc_can_hide(e)) continue;
    ++hideable;
    if (e.name == "latent_load") continue;  // coils drip below 15.5 degC, and nobody sends such a setpoint
    const double strongest = e.high - e.null_value >= e.null_value - e.low ? e.high : e.low;
    EXPECT_GE(rows_that_differ(untouched, week.with({{e.name, 1, strongest}})), 10) << e.name;
  }
  EXPECT_GE(hideable, 40);
}

TEST(Blind, EveryOutsideKindChangesTheLogAndNoFileOfTheLibraryHasItsName) {
  const Week week;
  const auto untouched = week.with({});
  const std::map<std::string, double> sizes{
      {"fcu_dial", 1.5}, {"odd_heater", 1200}, {"escape_door", 8}, {"ahu_time_switch", 2.5}, {"hot_gas_bypass", 0.4}};
  for (const std::string& kind : outside_kinds()) {
    EXPECT_EQ(find_effect(library(), kind), nullptr);
    EXPECT_GE(rows_that_differ(untouched, week.with({{kind, 2, sizes.at(kind)}})), 100) << kind;
  }
  EXPECT_THROW(week.with({{"no_such_thing", 0, 1}}), std::invalid_argument);
}

TEST(Blind, OtherStructureStoresExactlyTheHeatThatEntered) {
  Week week;
  sim::RcRoom room = hide(week.room, {{"odd_heater", 1, 1500}, {"escape_door", 7, 8}, {"ahu_time_switch", -1, 2}}, {});
  room.vav_off_leak = 0;
  const CivilTime begin = week.run.start;
  sim::RcPlant plant(room, week.weather, begin, 3);
  plant.advance_to({begin.seconds + 3 * 86400});
  const sim::RcEnergy& energy = plant.energy();
  EXPECT_NEAR(energy.stored_kj, energy.entered_kj(), 1e-6 * std::abs(energy.gains_kj));
  EXPECT_GT(energy.gains_kj, 0);
}

TEST(WrongSensors, DoWhatTheirEffectsSay) {
  const CivilTime start = sim::civil_midnight(2021, 7, 1);
  const auto shown = [&](const std::string& name, int place, double m, int rows) {
    WrongSensors wrong({{{find_effect(library(), name), place}, m}}, start);
    sim::Sensors s;
    for (int i = 0; i < rows; ++i) {
      s.room_temp_degc = {24, 25, 26};
      if (i > 0) s.room_temp_degc[1] = 27;
      s.fcu_temp_degc = {22, 23};
      s.supply_temp_degc = 15;
      wrong.apply(s, {start.seconds + i * std::int64_t{row_s}});
    }
    return s;
  };
  EXPECT_EQ(shown("room_sensor_bias", 1, 0.5, 1).room_temp_degc, (std::vector<double>{24, 25.5, 26}));
  EXPECT_EQ(shown("fcu_sensor_bias", 0, -1, 1).fcu_temp_degc, (std::vector<double>{21, 23}));
  EXPECT_EQ(shown("room_sensor_jet", 2, 0.1, 1).room_temp_degc, (std::vector<double>{24, 25, 24.9}));
  EXPECT_EQ(shown("swapped_sensors", 1, 1, 1).room_temp_degc, (std::vector<double>{26, 25, 24}));
  EXPECT_EQ(shown("room_sensor_drift", 0, 0.5, rows_per_day + 1).room_temp_degc[0], 24.5);
  EXPECT_EQ(shown("room_sensor_lag", 1, 1e9, 3).room_temp_degc[1], 25);
  EXPECT_NEAR(shown("room_sensor_lag", 1, 360, 2).room_temp_degc[1], 25 + 2 * (1 - std::exp(-1.0)), 0.006);
}

}  // namespace
}  // namespace airside::tools::gap
