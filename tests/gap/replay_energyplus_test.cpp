// A recording of the twin, replayed on the twin, is what the twin did; and plain energyplus repeats the replay.

#include "sim/energyplus/replay/replay.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "gap/needs_engine.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/plant.hpp"
#include "sim/energyplus/process.hpp"
#include "sim/energyplus/replay/eso.hpp"
#include "sim/energyplus/replay/replay_cache.hpp"
#include "sim/energyplus/replay/replay_files.hpp"
#include "sim/json/json_file.hpp"
#include "sim/weather/epw.hpp"
#include "support/default_cycle.hpp"

namespace airside::sim {
namespace {
namespace fs = std::filesystem;

EnergyPlusOptions quiet_twin(int days) {
  EnergyPlusOptions options = energyplus_room("twin");
  options.days = days;
  options.rooms.occupancy_noise = 0;
  options.rooms.vav_off_per_day = 0;
  options.rooms.sensor_noise_k = 0;
  return options;
}

/// Setpoints between 20.5 and 24, another every 18 min.
double restless_setpoint_degc(CivilTime t) {
  const double golden = static_cast<double>(t.seconds / cycle_s) * 0.6180339887498949;
  return 20.5 + 3.5 * (golden - std::floor(golden));
}

/// What a run of the plant left behind: the record of its commands, and its own channels.
struct Lived {
  Recording recording;
  ChannelTable channels;
  std::vector<std::vector<double>> fcu_on;  ///< of every 3-min step, which the record has not
};

Lived live(const EnergyPlusOptions& options) {
  EnergyPlusPlant plant(options);
  Lived lived;
  lived.recording.from = plant.time();
  lived.recording.station = read_epw(default_weather(find_energyplus()).string());
  const Channels channels{5, 5, 2};
  std::vector<Eigen::VectorXd> rows;
  while (plant.time() < plant.end()) {
    const CivilTime t = plant.time();
    Sensors now = plant.sensors();
    Eigen::VectorXd state(channels.count());
    for (int i = 0; i < 5; ++i) state[i] = plant.true_room_temps_degc()[static_cast<std::size_t>(i)];
    for (int i = 0; i < 5; ++i) state[channels.fcu_temp() + i] = now.fcu_temp_degc[static_cast<std::size_t>(i)];
    state[channels.mau_temp()] = now.mau_temp_degc;
    state[channels.supply_temp()] = now.supply_temp_degc;
    for (int i = 0; i < 2; ++i) state[channels.power() + i] = now.power_kw[static_cast<std::size_t>(i)];
    if (starts_cycle(t)) plant.set_setpoint(restless_setpoint_degc(t));
    const double setpoint = plant.sensors().setpoint_degc;
    plant.advance_to({t.seconds + row_s / 2});
    const Sensors first = plant.sensors();
    plant.advance_to({t.seconds + row_s});
    for (int i = 0; i < 5; ++i) {
      const auto at = static_cast<std::size_t>(i);
      state[channels.fcu_duty() + i] = (first.fcu_on[at] + plant.sensors().fcu_on[at]) / 2;
    }
    lived.fcu_on.insert(lived.fcu_on.end(), {first.fcu_on, plant.sensors().fcu_on});
    lived.recording.rows.push_back({setpoint, first.vav_on, first.fcu_on, now.outdoor_temp_degc, now.rain});
    rows.push_back(state);
  }
  lived.channels.resize(static_cast<Eigen::Index>(rows.size()), channels.count());
  for (std::size_t i = 0; i < rows.size(); ++i) lived.channels.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  return lived;
}

/// Three days of the twin with a restless setpoint: lived once for all tests.
const Lived& three_days() {
  static const Lived lived = live(quiet_twin(3));
  return lived;
}

const EnergyPlusTwin& twin() {
  static const EnergyPlusTwin it = twin_of(quiet_twin(3));
  return it;
}

/// The stretch's first rows: a short replay.
Recording first_hours(int hours) {
  Recording some = three_days().recording;
  some.rows.resize(static_cast<std::size_t>(hours * 3600 / row_s));
  return some;
}

double rms_after_a_day(const Eigen::VectorXd& difference) {
  const Eigen::VectorXd later = difference.tail(difference.size() - rows_per_day);
  return std::sqrt(later.squaredNorm() / static_cast<double>(later.size()));
}

std::string whole_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What anyone would type in the folder. Returns the exit code.
int plain_energyplus(const fs::path& folder, const std::string& weather) {
  const std::string program = (find_energyplus().folder / "energyplus").string();
  const std::string command =
      "cd '" + folder.string() + "' && '" + program + "' -w '" + weather + "' -d out model.epJSON > /dev/null 2>&1";
  return std::system(command.c_str());
}

template <class Act>
std::string complaint(Act act) {
  try {
    act();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

/// Puts the fan coils' true 3-min steps into a kept folder, by the engine's other way to have a series: a file of the
/// whole year.  Before the recording its first day is repeated, as the replay does.
void write_true_fan_coils(const Lived& lived, const fs::path& folder) {
  nlohmann::json model = read_json(folder / "model.epJSON");
  const int begin = static_cast<int>(second_of_year(lived.recording.from) / replay_step_s);
  std::ofstream out(folder / "fan_coils.csv");
  for (int step = 0; step < 365 * replay_steps_per_day; ++step) {
    int at = step - begin;
    while (at < 0) at += replay_steps_per_day;
    const auto& on = lived.fcu_on[std::min(static_cast<std::size_t>(at), lived.fcu_on.size() - 1)];
    for (std::size_t i = 0; i < 5; ++i) out << (i > 0 ? "," : "") << (on[i] > 0 ? 1 : 0);
    out << '\n';
  }
  for (int i = 1; i <= 5; ++i) {
    const std::string name = "FCU " + std::to_string(i) + " On";
    for (const char* type : {"Schedule:Year", "Schedule:Constant"})
      if (model.contains(type)) model[type].erase(name);
    model["Schedule:File"][name] = {
        {"file_name", "fan_coils.csv"},          {"column_number", i},          {"rows_to_skip_at_top", 0},
        {"number_of_hours_of_data", 8760},       {"column_separator", "Comma"}, {"interpolate_to_timestep", "No"},
        {"minutes_per_item", replay_step_s / 60}};
  }
  std::ofstream(folder / "model.epJSON") << model;
}

/// The fan coils' true steps are put back to show that what is left of the gap is the record's: it has one sample of
/// a thermostat in 6 min. The last perimeter zone shows it most: the engine gives a capacity multiplier to all zones of
/// a list but the last (ZoneList in ZoneCapacitanceMultiplier:ResearchSpecial), so its fan coil cools it by 1.1 K in
/// 3 min and runs for 3 to 9.
TEST(EnergyPlusReplay, LivesThroughTheTwinsOwnDaysAgain) {
  AIRSIDE_NEEDS_ENGINE();
  const RunFolder folder;
  const Lived& lived = three_days();
  const Channels channels = channels_of(twin());
  const Eigen::Index later = lived.channels.rows() - rows_per_day;
  const ReplayOptions kept{.keep = folder.path() / "kept"};
  const ChannelTable replayed = replay_energyplus(twin(), lived.recording, kept);
  ASSERT_EQ(replayed.rows(), lived.channels.rows());
  ASSERT_EQ(replayed.cols(), lived.channels.cols());
  for (int c = 0; c < channels.fcu_duty(); ++c) {
    const std::string name = channels.name(c);
    const Eigen::VectorXd gap = replayed.col(c) - lived.channels.col(c);
    const double rms = rms_after_a_day(gap), bias = gap.tail(later).mean();
    const double mean = lived.channels.col(c).tail(later).mean();
    std::printf("  %-18s rms %.4f, mean %+.4f, of %.3f\n", name.c_str(), rms, bias, mean);
    if (c >= channels.power()) {
      EXPECT_LT(std::abs(bias), 0.03 * mean) << name;
    } else if (c < channels.fcu_temp() || c >= channels.mau_temp()) {
      EXPECT_LT(rms, 0.05) << name;
    } else {
      const bool lightest = c == channels.mau_temp() - 1;
      EXPECT_LT(rms, lightest ? 0.75 : 0.25) << name;
      EXPECT_LT(std::abs(bias), 0.05) << name;
    }
  }

  write_true_fan_coils(lived, kept.keep);
  ASSERT_EQ(plain_energyplus(kept.keep, "weather.epw"), 0);
  const EsoFile outputs(kept.keep / "out" / "eplusout.eso");
  for (int c = 0; c < channels.mau_temp(); ++c) {
    const auto& zones = c < channels.fcu_temp() ? twin().names.interior_zones : twin().names.perimeter_zones;
    const auto& steps = outputs.of(zones[static_cast<std::size_t>(c % 5)] + ",Zone Mean Air Temperature");
    Eigen::VectorXd gap(lived.channels.rows());
    for (Eigen::Index row = 0; row < gap.size(); ++row)
      gap[row] = steps[static_cast<std::size_t>(replay_lead_days * 480 + 2 * row - 1)] - lived.channels(row, c);
    std::printf("  %-18s rms %.4f with the true steps\n", channels.name(c).c_str(), rms_after_a_day(gap));
    EXPECT_LT(rms_after_a_day(gap), c < channels.fcu_temp() ? 0.02 : 0.05) << channels.name(c);
  }
}

TEST(EnergyPlusReplay, TakesHeatOfUnknownOriginAndCold) {
  AIRSIDE_NEEDS_ENGINE();
  const Lived& lived = three_days();
  const auto with = [&](double kw) {
    Recording recording = lived.recording;
    for (RecordedRow& row : recording.rows) row.zone_heat_kw = {0, kw, 0, 0, 0, 0, 0, 0, 0, 0};
    return replay_energyplus(twin(), recording, {});
  };
  const ChannelTable none = with(0), heat = with(0.4), cold = with(-0.4);
  const Eigen::Index last = none.rows() - 1;
  const double warmer = (heat - none).col(1).tail(rows_per_day).mean(),
               colder = (none - cold).col(1).tail(rows_per_day).mean();
  EXPECT_GT(warmer, 0.1);
  EXPECT_NEAR(colder, warmer, 0.2 * warmer);
  EXPECT_LT(std::abs((heat - none)(last, 4)), 0.3 * warmer) << "the farthest room";
  EXPECT_EQ(none(last, 1), replay_energyplus(twin(), lived.recording, {})(last, 1));
}

TEST(EnergyPlusReplay, FanCoilsFollowTheirThermostatsWhenAsked) {
  AIRSIDE_NEEDS_ENGINE();
  const Lived& lived = three_days();
  ReplayOptions closed;
  closed.thermostats = true;
  const ChannelTable replayed = replay_energyplus(twin(), lived.recording, closed);
  const Channels channels = channels_of(twin());
  for (int i = 0; i < channels.fcus; ++i) {
    for (int day = 1; day < 3; ++day) {
      const double duty = replayed.col(channels.fcu_duty() + i).segment(day * rows_per_day, rows_per_day).mean();
      const double was = lived.channels.col(channels.fcu_duty() + i).segment(day * rows_per_day, rows_per_day).mean();
      std::printf("  fan coil %d, day %d: duty %.4f, in the plant %.4f\n", i + 1, day + 1, duty, was);
      EXPECT_NEAR(duty, was, 0.03) << "fan coil " << i + 1 << ", day " << day + 1;
    }
  }
  for (int c = 0; c < channels.rooms; ++c)
    EXPECT_LT(rms_after_a_day(replayed.col(c) - lived.channels.col(c)), 0.1) << channels.name(c);
}

TEST(EnergyPlusReplay, KeptFolderRunByPlainEnergyPlusGivesTheSameBits) {
  AIRSIDE_NEEDS_ENGINE();
  const RunFolder folder;
  const Recording some = first_hours(7);
  for (const bool thermostats : {false, true}) {
    ReplayOptions options;
    options.thermostats = thermostats;
    options.keep = folder.path() / (thermostats ? "closed" : "open");
    const ChannelTable table = replay_energyplus(twin(), some, options);
    // Elsewhere, and with nothing of airside: the folder can be moved.
    const fs::path moved = folder.path() / (thermostats ? "moved closed" : "moved open");
    const EsoFile first(options.keep / "out" / "eplusout.eso");
    fs::rename(options.keep, moved);
    fs::remove_all(moved / "out");
    EXPECT_NE(whole_file(moved / "README.txt").find("energyplus -w weather.epw -d out model.epJSON"),
              std::string::npos);
    ASSERT_EQ(plain_energyplus(moved, "weather.epw"), 0);
    const EsoFile again(moved / "out" / "eplusout.eso");
    EXPECT_EQ(again.series(), first.series());
    const auto& temps = again.of("Interior 3,Zone Mean Air Temperature");
    for (Eigen::Index row = 0; row < table.rows(); ++row)
      EXPECT_EQ(table(row, 2), temps[static_cast<std::size_t>(replay_lead_days * 480 + 2 * row - 1)]);
    EXPECT_EQ(table, replay_energyplus(twin(), some, {.thermostats = thermostats}));
  }
}

TEST(EnergyPlusReplay, EngineSeesMeasuredWeatherAtItsInstants) {
  AIRSIDE_NEEDS_ENGINE();
  const RunFolder folder;
  Recording some = first_hours(30);
  // Begins at 10:00 and jumps every row: a shift by a single step would show.
  some.from.seconds += 10 * 3600;
  for (std::size_t i = 0; i < some.rows.size(); ++i) {
    some.rows[i].outdoor_temp_degc = 27 + 3 * static_cast<double>(i % 2) + 0.01 * static_cast<double>(i);
    some.rows[i].rain = i >= 50 && i < 60 ? 1 : 0;
  }
  const ReplayOptions kept{.keep = folder.path() / "kept"};
  replay_energyplus(twin(), some, kept);
  const EsoFile seen(kept.keep / "out" / "eplusout.eso");
  const auto& temps = seen.of("Environment,Site Outdoor Air Drybulb Temperature");
  const auto& rain = seen.of("Environment,Site Rain Status");
  for (std::size_t i = 0; i < some.rows.size(); ++i) {
    const std::size_t step = (replay_lead_days * 480) + 200 + 2 * i - 1;
    EXPECT_NEAR(temps[step], some.rows[i].outdoor_temp_degc, 0.006) << "row " << i;
    EXPECT_EQ(rain[step + 1], some.rows[i].rain) << "row " << i;
  }

  // The sun of the original file, which the engine interpolates itself.
  fs::copy(kept.keep, folder.path() / "original", fs::copy_options::recursive);
  ASSERT_EQ(plain_energyplus(folder.path() / "original", default_weather(find_energyplus()).string()), 0);
  const EsoFile original(folder.path() / "original" / "out" / "eplusout.eso");
  for (const char* name : {"Environment,Site Direct Solar Radiation Rate per Area",
                           "Environment,Site Diffuse Solar Radiation Rate per Area"}) {
    const auto &ours = seen.of(name), &theirs = original.of(name);
    // The recorded days alone: before them the first day is repeated.
    for (std::size_t day = replay_lead_days; day < replay_lead_days + 2; ++day) {
      const auto up = [day](const std::vector<double>& sun) {
        std::size_t step = day * 480;
        while (sun[step] <= 0) ++step;
        return static_cast<int>(step - day * 480);
      };
      std::printf("  %s: first at minute %d, in the original %d\n", name, 3 * up(ours), 3 * up(theirs));
      EXPECT_NEAR(up(ours), up(theirs), 1) << name;
      double square = 0, mean = 0, mean_theirs = 0;
      for (std::size_t step = day * 480 + (day == replay_lead_days ? 200 : 0);
           step < day * 480 + (day == replay_lead_days ? 480 : 320); ++step) {
        square += (ours[step] - theirs[step]) * (ours[step] - theirs[step]) / 300;
        mean += ours[step] / 300;
        mean_theirs += theirs[step] / 300;
      }
      std::printf("  %s: rms difference %.1f, mean %.1f and %.1f W/m2\n", name, std::sqrt(square), mean, mean_theirs);
      EXPECT_NEAR(mean, mean_theirs, 0.03 * mean_theirs) << name;
    }
  }
}

/// Longer warm-up changes nothing that a sensor shows.
TEST(EnergyPlusReplay, StartIsForgottenWhenTheRecordingBegins) {
  AIRSIDE_NEEDS_ENGINE();
  const RunFolder folder;
  const ReplayOptions kept{.keep = folder.path() / "kept"};
  replay_energyplus(twin(), first_hours(30), kept);
  const EsoFile ours(kept.keep / "out" / "eplusout.eso");
  nlohmann::json model = read_json(kept.keep / "model.epJSON");
  model["Building"].begin().value()["minimum_number_of_warmup_days"] = 25;
  std::ofstream(kept.keep / "model.epJSON") << model;
  ASSERT_EQ(plain_energyplus(kept.keep, "weather.epw"), 0);
  const EsoFile longer(kept.keep / "out" / "eplusout.eso");
  double most = 0;
  for (const auto& zones : {twin().names.interior_zones, twin().names.perimeter_zones}) {
    for (const auto& zone : zones) {
      const auto& a = ours.of(zone + ",Zone Mean Air Temperature");
      const auto& b = longer.of(zone + ",Zone Mean Air Temperature");
      for (std::size_t step = replay_lead_days * 480; step < a.size(); ++step)
        most = std::max(most, std::abs(a[step] - b[step]));
    }
  }
  std::printf("  25 days of warm-up: %.5f K at most\n", most);
  EXPECT_LT(most, 0.005);
}

TEST(EnergyPlusReplay, CommandsReachTheEngineToTheLastDigit) {
  AIRSIDE_NEEDS_ENGINE();
  const RunFolder folder;
  const Recording some = first_hours(30);
  const ReplayOptions kept{.keep = folder.path() / "kept"};
  replay_energyplus(twin(), some, kept);
  const ReplayDays days = replay_days(twin(), some);
  const ReplayCommands commands = replay_commands(twin(), some, days, false);
  nlohmann::json model = read_json(kept.keep / "model.epJSON");
  for (const auto& name : commands.schedules)
    model["Output:Variable"]["Of " + name] = {
        {"key_value", name}, {"variable_name", "Schedule Value"}, {"reporting_frequency", "Timestep"}};
  std::ofstream(kept.keep / "model.epJSON") << model;
  ASSERT_EQ(plain_energyplus(kept.keep, "weather.epw"), 0);
  const EsoFile seen(kept.keep / "out" / "eplusout.eso");
  for (std::size_t i = 0; i < commands.schedules.size(); ++i)
    EXPECT_EQ(seen.of(commands.schedules[i] + ",Schedule Value"), commands.values[commands.columns[i]])
        << commands.schedules[i];
}

/// Schedules have 53 places: of days, or of weeks.
TEST(EnergyPlusReplay, CommandsOfTenWeeksFitIntoTheEnginesSchedules) {
  AIRSIDE_NEEDS_ENGINE();
  Recording some = three_days().recording;
  some.rows.resize(70 * rows_per_day, some.rows.back());
  for (std::size_t i = 0; i < some.rows.size(); ++i)
    some.rows[i].setpoint_degc = 20 + 0.001 * static_cast<double>(i / rows_per_day);
  const ReplayDays days = replay_days(twin(), some);
  const ReplayCommands commands = replay_commands(twin(), some, days, false);
  nlohmann::json model = replay_model(twin(), days, commands, false);
  follow_commands(model, days, commands);
  const auto& parts = model["Schedule:Year"]["Supply Air Setpoint"]["schedule_weeks"];
  ASSERT_LE(parts.size(), 53u);
  const auto& supply = commands.values[commands.columns[0]];
  static constexpr const char* weekdays[] = {"monday", "tuesday",  "wednesday", "thursday",
                                             "friday", "saturday", "sunday"};
  for (int day = 0; day < days.days; ++day) {
    const CivilTime date{days.begin.seconds + day * 86400LL};
    const std::string text = sim::text_of(date);
    const int month = std::stoi(text.substr(5, 2)), of_month = std::stoi(text.substr(8, 2));
    const nlohmann::json* week = nullptr;
    for (const auto& part : parts) {
      const std::pair at(month, of_month);
      if (at >= std::pair(part["start_month"].get<int>(), part["start_day"].get<int>()) &&
          at <= std::pair(part["end_month"].get<int>(), part["end_day"].get<int>()))
        week = &model["Schedule:Week:Daily"][part["schedule_week_name"].get<std::string>()];
    }
    ASSERT_NE(week, nullptr) << text;
    const std::string name = (*week)[std::string(weekdays[date.weekday()]) + "_schedule_day_name"];
    const auto& last = model["Schedule:Day:Interval"][name]["data"].back();
    EXPECT_EQ(last["time"], "24:00");
    EXPECT_EQ(last["value_until_time"].get<double>(), supply[static_cast<std::size_t>(day) * 480 + 479]) << text;
  }

  nlohmann::json holiday = twin().model;
  holiday["RunPeriodControl:SpecialDays"]["Feast"] = {{"start_date", "July 4"}};
  EXPECT_NE(complaint([&] { follow_commands(holiday, days, commands); }).find("holidays"), std::string::npos);
}

TEST(EnergyPlusReplay, MemorySparesEqualRunsEvenAtTheSameTime) {
  AIRSIDE_NEEDS_ENGINE();
  std::atomic<int> runs{0};
  ReplayMemory memory;
  const ReplayOptions remembered{.engine_runs = &runs, .memory = &memory};
  const Recording some = first_hours(4);
  ChannelTable one, two;
  std::thread first([&] { one = replay_energyplus(twin(), some, remembered); });
  std::thread second([&] { two = replay_energyplus(twin(), some, remembered); });
  first.join();
  second.join();
  EXPECT_EQ(runs, 1);
  EXPECT_EQ(one, two);
  Recording colder = some;
  colder.rows[20].setpoint_degc -= 1;
  EXPECT_NE(replay_energyplus(twin(), colder, remembered), one);
  EXPECT_EQ(runs, 2);
}

TEST(EnergyPlusReplay, MemoryForgetsTheOldestAndWhatFailed) {
  ReplayMemory memory(2);
  std::vector<ReplayKey> keys(3);
  for (std::size_t i = 0; i < keys.size(); ++i) keys[i].add(std::to_string(i));
  int made = 0;
  const auto ask = [&](std::size_t i) {
    return memory.get(keys[i], [&] { return ++made, ChannelTable::Constant(1, 1, static_cast<double>(i)).eval(); });
  };
  ask(0), ask(1), ask(0);
  EXPECT_EQ(made, 2);
  EXPECT_EQ((*ask(2))(0, 0), 2);
  ask(0);
  EXPECT_EQ(made, 3);
  ask(1);
  EXPECT_EQ(made, 4);
  ReplayKey other;
  other.add("other");
  EXPECT_THROW(memory.get(other, []() -> ChannelTable { throw std::runtime_error("no"); }), std::runtime_error);
  EXPECT_EQ((*memory.get(other, [] { return ChannelTable::Constant(1, 1, 7.0).eval(); }))(0, 0), 7);
}

TEST(EnergyPlusReplay, CacheSparesTheEngineAndDamageIsRepaired) {
  AIRSIDE_NEEDS_ENGINE();
  const RunFolder folder;
  std::atomic<int> runs{0};
  ReplayOptions cached;
  cached.cache = folder.path() / "cache";
  cached.engine_runs = &runs;
  const Recording some = first_hours(4);
  const ChannelTable first = replay_energyplus(twin(), some, cached);
  EXPECT_EQ(runs, 1);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(replay_energyplus(twin(), some, cached), first);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("  from the cache: %.3f s\n", seconds);
  EXPECT_EQ(runs, 1);

  const fs::path file = fs::directory_iterator(cached.cache)->path();
  const std::string whole = whole_file(file);
  std::string damaged = whole;
  damaged[whole.size() / 2] = static_cast<char>(damaged[whole.size() / 2] ^ 4);
  int expected = 1;
  for (const std::string& content : {damaged, whole.substr(0, whole.size() - 9), std::string()}) {
    std::ofstream(file, std::ios::binary) << content;
    EXPECT_EQ(replay_energyplus(twin(), some, cached), first);
    EXPECT_EQ(runs, ++expected);
    EXPECT_EQ(whole_file(file), whole);
  }

  // Another command, another model: another run.
  Recording colder = some;
  colder.rows[20].setpoint_degc -= 1;
  EXPECT_NE(replay_energyplus(twin(), colder, cached), first);
  EnergyPlusTwin other = twin();
  other.model["Lights"]["Interior 1 Lights"]["watts_per_floor_area"] = 20;
  EXPECT_NE(replay_energyplus(other, some, cached), first);
  EXPECT_EQ(runs, expected + 2);
}

TEST(EnergyPlusReplay, SeveralThreadsGetTheirOwnRuns) {
  AIRSIDE_NEEDS_ENGINE();
  const Recording some = first_hours(4);
  EnergyPlusTwin bright = twin();
  bright.model["Lights"]["Interior 1 Lights"]["watts_per_floor_area"] = 20;
  ChannelTable as_it_is, brighter;
  std::thread one([&] { as_it_is = replay_energyplus(twin(), some); });
  std::thread two([&] { brighter = replay_energyplus(bright, some); });
  one.join();
  two.join();
  EXPECT_EQ(as_it_is, replay_energyplus(twin(), some));
  EXPECT_EQ(brighter, replay_energyplus(bright, some));
  EXPECT_GT(brighter.col(0).mean(), as_it_is.col(0).mean() + 0.1);
}

TEST(EnergyPlusReplay, EngineSpeaksForAModelThatItRefuses) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusTwin wrong = twin();
  wrong.model["Lights"]["Interior 1 Lights"]["schedule_name"] = "Interior 1 Ocupancy";
  const std::string said = complaint([&] { replay_energyplus(wrong, first_hours(1)); });
  EXPECT_NE(said.find("** Severe"), std::string::npos) << said;
  EXPECT_NE(said.find("INTERIOR 1 OCUPANCY"), std::string::npos) << said;
}

TEST(EnergyPlusReplay, RecordingThatDoesNotFitIsRefused) {
  AIRSIDE_NEEDS_ENGINE();
  const auto said_of = [](const auto& change) {
    Recording some = first_hours(1);
    EnergyPlusTwin it = twin();
    change(some, it);
    return complaint([&] { replay_energyplus(it, some); });
  };
  EXPECT_NE(said_of([](Recording& r, EnergyPlusTwin&) { r.rows.clear(); }).find("no rows"), std::string::npos);
  EXPECT_NE(said_of([](Recording& r, EnergyPlusTwin&) { r.rows[3].setpoint_degc = std::nan(""); }).find("07-01 00:18"),
            std::string::npos);
  EXPECT_NE(said_of([](Recording& r, EnergyPlusTwin&) { r.rows[3].fcu_on.pop_back(); }).find("4 fan coils"),
            std::string::npos);
  EXPECT_NE(said_of([](Recording& r, EnergyPlusTwin&) { r.from.seconds += 60; }).find("00:01"), std::string::npos);
  EXPECT_NE(said_of([](Recording&, EnergyPlusTwin& t) { t.names.vav_on_schedule = "VAV # Runs"; }).find("VAV 1 Runs"),
            std::string::npos);
}

}  // namespace
}  // namespace airside::sim
