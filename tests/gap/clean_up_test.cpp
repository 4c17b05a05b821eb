#include "tools/gap/clean_up/clean_up.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "gap/clean_up_case.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools::gap {
namespace {

TEST(CleanUp, ReadsACleanLogAsTheStrictReaderDoes) {
  const std::string text = csv(july().rows, july().context.counts);
  const hal::Log strict = hal::read_log_text(text, "room.csv", july().context.counts);
  const CleanLog lenient = read_dirty_log_text(text, july().context);
  EXPECT_TRUE(lenient.remarks.empty()) << told(lenient.remarks);
  expect_same_rows(lenient.rows, strict.rows);
  expect_same_rows(lenient.rows, july().rows);
}

// ---- rows

TEST(CleanUp, CountsGaps) {
  Rows rows = july().rows;
  rows.erase(rows.begin() + 500, rows.begin() + 540);
  rows.erase(rows.begin() + 2000, rows.begin() + 2003);
  const CleanLog log = clean_up(rows, july().context);
  const Remark r = only_remark(log, Defect::gap, Action::left_out);
  EXPECT_EQ(r.count, 43u);
  EXPECT_NE(r.text.find("2 gaps"), std::string::npos) << r.text;
  EXPECT_EQ(log.rows.size(), july().rows.size() - 43);
}

TEST(CleanUp, RefusesAGapOfMoreThanADayAndALogThatIsFullOfGaps) {
  Rows rows = july().rows;
  rows.erase(rows.begin() + 500, rows.begin() + 750);
  only_remark(clean_up(rows, july().context), Defect::gap, Action::refused);
  rows = july().rows;
  std::erase_if(rows, [](const hal::LogRow& row) { return row.time.seconds / row_s % 5 < 2; });
  only_remark(clean_up(rows, july().context), Defect::gap, Action::refused);
}

TEST(CleanUp, SortsShuffledRows) {
  Rows rows = july().rows;
  std::mt19937 random(1);
  for (std::size_t i = 0; i + 40 < rows.size(); i += 40) {
    std::shuffle(rows.begin() + static_cast<std::ptrdiff_t>(i), rows.begin() + static_cast<std::ptrdiff_t>(i + 40),
                 random);
  }
  CleanLog log = clean_up(rows, july().context);
  EXPECT_GT(only_remark(log, Defect::shuffled, Action::fixed).count, 2000u);
  expect_same_rows(log.rows, july().rows);
  log = read_dirty_log_text(csv(rows, july().context.counts), july().context);
  only_remark(log, Defect::shuffled, Action::fixed);
  expect_same_rows(log.rows, july().rows);
}

TEST(CleanUp, DropsRowsThatRepeatAnother) {
  Rows rows = july().rows;
  for (const int at : {100, 101, 102, 2000}) rows.insert(rows.begin() + at, rows[static_cast<std::size_t>(at)]);
  const CleanLog log = read_dirty_log_text(csv(rows, july().context.counts), july().context);
  EXPECT_EQ(only_remark(log, Defect::duplicate, Action::fixed).count, 4u);
  expect_same_rows(log.rows, july().rows);
}

TEST(CleanUp, LeavesOutAFewTimesWithContradictingRowsAndRefusesMany) {
  Rows rows = july().rows;
  for (const int at : {100, 900}) {
    hal::LogRow other = rows[static_cast<std::size_t>(at)];
    other.value[0] += 1;
    rows.insert(rows.begin() + at, other);
  }
  CleanLog log = clean_up(rows, july().context);
  ASSERT_EQ(log.remarks.size(), 2u) << told(log.remarks);  // the rows, and the gaps that they leave
  EXPECT_EQ(log.remarks[0].defect, Defect::duplicate);
  EXPECT_EQ(log.remarks[0].action, Action::left_out);
  EXPECT_EQ(log.remarks[0].count, 2u);
  EXPECT_EQ(log.rows.size(), july().rows.size() - 2);

  rows = july().rows;
  for (std::size_t i = 0; i < 300; ++i) {
    rows.push_back(july().rows[i]);
    rows.back().value[3] += 0.5;
  }
  log = clean_up(rows, july().context);
  EXPECT_FALSE(log.usable());
  EXPECT_TRUE(has(log, Defect::duplicate, "")) << told(log.remarks);
}

TEST(CleanUp, MovesRowsOntoTheGridAndRefusesOtherIntervals) {
  Rows rows = july().rows;
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].time.seconds += static_cast<std::int64_t>(i % 7) * 10 - 30;
  CleanLog log = read_dirty_log_text(csv(rows, july().context.counts), july().context);
  only_remark(log, Defect::off_grid, Action::fixed);
  expect_same_rows(log.rows, july().rows);
  std::erase_if(rows = july().rows, [](const hal::LogRow& row) { return row.time.second_of_day() % 3600 != 0; });
  log = clean_up(rows, july().context);
  EXPECT_TRUE(has(log, Defect::off_grid, "")) << told(log.remarks);
  EXPECT_FALSE(log.usable());
}

TEST(CleanUp, NamesLinesAndFieldsThatCannotBeRead) {
  std::string text = csv(july().rows, july().context.counts);
  std::size_t line = 0;
  for (int i = 0; i < 50; ++i) line = text.find('\n', line) + 1;
  const std::size_t value = text.find(',', line) + 1;
  text.replace(value, text.find(',', value) - value, "#N/A");
  line = text.find('\n', text.find('\n', line) + 1) + 1;
  text.replace(line, 10, "05.07.2023");
  const CleanLog log = read_dirty_log_text(text, july().context);
  ASSERT_EQ(log.remarks.size(), 4u) << told(log.remarks);
  EXPECT_NE(log.remarks[0].text.find("line 53"), std::string::npos) << told(log.remarks);
  EXPECT_NE(log.remarks[1].text.find("`#N/A` in line 51"), std::string::npos) << told(log.remarks);
  EXPECT_TRUE(has(log, Defect::missing_value, "room_temp_1_degc"));
  EXPECT_TRUE(has(log, Defect::gap, ""));
  EXPECT_TRUE(log.usable());
}

TEST(CleanUp, RefusesALogOfAnotherTimeOrAnotherRoomShape) {
  CleanUpContext context = july().context;
  context.from = sim::civil_midnight(2023, 8, 1);
  context.to = sim::civil_midnight(2023, 8, 15);
  only_remark(clean_up(july().rows, context), Defect::other_period, Action::refused);
  context = july().context;
  context.counts = {"three", 3, 0, 1};
  only_remark(clean_up(july().rows, context), Defect::other_room, Action::refused);
  EXPECT_THROW(read_dirty_log_text(csv(july().rows, july().context.counts), context), hal::InputError);
}

// ---- clock

struct ClockCase {
  const char* about;
  int month, day;
  bool forward;
};

/// The log as a clock writes it that is put forward or back in the night of the seventh day.
Rows with_clock_change(const Rows& rows, CivilTime at, bool forward) {
  Rows changed = rows;
  for (hal::LogRow& row : changed) {
    const bool summer = forward ? !(row.time < at) : row.time < at;
    if (summer) row.time.seconds += 3600;
  }
  return changed;
}

TEST(CleanUp, PutsDaylightSavingBackToStandardTime) {
  for (const ClockCase& c : {ClockCase{"Europe, spring", 3, 26, true}, ClockCase{"Europe, autumn", 10, 29, false},
                             ClockCase{"America, spring", 3, 12, true}, ClockCase{"America, autumn", 11, 5, false}}) {
    const CivilTime sunday = sim::civil_midnight(2023, c.month, c.day);
    ASSERT_EQ(sunday.weekday(), 6);
    const Logged log =
        log_of(sim::make_room(), 20 + static_cast<std::uint64_t>(c.month), {sunday.seconds - 6 * 86400}, c.forward);
    const Rows rows = with_clock_change(log.rows, {sunday.seconds + 7200}, c.forward);
    CleanUpContext alone = log.context;
    alone.station = nullptr;
    for (const CleanUpContext& context : {log.context, alone}) {
      SCOPED_TRACE(std::string(c.about) + (context.station ? "" : ", no station"));
      const CleanLog clean = clean_up(rows, context);
      only_remark(clean, Defect::daylight_saving, Action::fixed);
      expect_same_rows(clean.rows, log.rows);
      Rows sorted = rows;
      std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
      expect_same_rows(clean_up(sorted, context).rows, log.rows);
    }
  }
}

TEST(CleanUp, TakesAnHourThatIsOnlyMissingForAGap) {
  const CivilTime sunday = sim::civil_midnight(2023, 3, 26);
  const Logged log = log_of(sim::make_room(), 23, {sunday.seconds - 6 * 86400}, true);
  for (const std::int64_t day : {0, 1}) {
    Rows rows = log.rows;
    const std::int64_t hour_s = sunday.seconds + 86400 * day + 7200;
    std::erase_if(rows,
                  [&](const auto& row) { return row.time.seconds >= hour_s && row.time.seconds < hour_s + 3600; });
    EXPECT_EQ(only_remark(clean_up(rows, log.context), Defect::gap, Action::left_out).count, 10u);
  }
}

TEST(CleanUp, NotesAClockThatIsWrongThroughout) {
  for (const auto& [month, hours] : {std::pair{1, 1}, std::pair{7, -1}, std::pair{5, 2}, std::pair{9, -3}}) {
    const Logged log = log_of(sim::make_room(), 30 + static_cast<std::uint64_t>(month),
                              sim::civil_midnight(2023, month, 5), month % 2 == 0, {{"clock_shift", 0, hours * 1.0}});
    const CleanLog clean = clean_up(log.rows, log.context);
    const Remark r = only_remark(clean, Defect::clock_shift, Action::noted);
    const std::string way = (hours > 0 ? "ahead by " : "behind by ") + std::to_string(std::abs(hours)) + " h";
    EXPECT_NE(r.text.find(way), std::string::npos) << r.text;
    expect_same_rows(clean.rows, log.rows);
  }
}

// ---- units

TEST(CleanUp, ConvertsALogThatIsInFahrenheitOrKelvinThroughout) {
  for (const double scale : {1.8, 1.0}) {
    Rows rows = january().rows;
    const double offset = scale == 1.8 ? 32 : 273.15;
    const auto shown = [=](double v) { return hundredths(scale * v + offset); };
    for (int n = 1; n <= 5; ++n) map(rows, room(n), shown), map(rows, fcu(n), shown);
    for (const Column& column : {mau, outdoor, setpoint, supply}) map(rows, column, shown);
    const CleanLog log = clean_up(rows, january().context);
    EXPECT_EQ(log.remarks.size(), 14u) << told(log.remarks);
    EXPECT_TRUE(log.usable());
    expect_near(log.rows, january().rows, room(2), 0.011);
    expect_near(log.rows, january().rows, outdoor, 0.011);
  }
}

TEST(CleanUp, ConvertsWatts) {
  for (const int n : {1, 2}) {
    Rows rows = july().rows;
    map(rows, power(n), [](double v) { return 1000 * v; });
    const CleanLog log = clean_up(rows, july().context);
    only_remark(log, Defect::wrong_unit, Action::fixed, n == 1 ? "power_1_kw" : "power_2_kw");
    expect_near(log.rows, july().rows, power(n), 1e-9);
  }
}

TEST(CleanUp, ConvertsAStatusInPercent) {
  Rows rows = july().rows;
  map(rows, fcu_on(2), [](double v) { return 100 * v; });
  const CleanLog log = clean_up(rows, july().context);
  only_remark(log, Defect::wrong_unit, Action::fixed, "fcu_on_2");
  expect_same_rows(log.rows, july().rows);
}

TEST(CleanUp, RefusesAUnitThatItCannotTell) {
  Rows rows = july().rows;
  map(rows, setpoint, [](double v) { return std::round(v) + 273; });  // kelvin, or tenths of 29.6 degC
  const CleanLog log = clean_up(rows, july().context);
  EXPECT_FALSE(has(log, Defect::wrong_unit, "room_temp_1_degc"));
  EXPECT_TRUE(has(log, Defect::wrong_unit, "setpoint_degc")) << told(log.remarks);
}

// ---- swapped columns

TEST(CleanUp, NamesARoomThatExchangedPlacesWithTheOutdoorsAndAllFanCoilsWithTheirStatus) {
  Rows rows = july().rows;
  swap(rows, outdoor, room(2));
  CleanLog log = clean_up(rows, july().context);
  EXPECT_TRUE(has(log, Defect::swapped, "outdoor_temp_degc")) << told(log.remarks);
  rows = july().rows;
  for (int n = 1; n <= 5; ++n) swap(rows, fcu(n), fcu_on(n));
  log = clean_up(rows, july().context);
  EXPECT_EQ(std::count_if(log.remarks.begin(), log.remarks.end(),
                          [](const Remark& r) { return r.defect == Defect::swapped; }),
            5)
      << told(log.remarks);
}

TEST(CleanUp, NamesAnOutdoorColumnThatStandsStillWithoutAStation) {
  CleanUpContext alone = july().context;
  alone.station = nullptr;
  for (const auto& [name, column] :
       {std::pair<const char*, Column>{"mau_temp_degc", mau}, {"room_temp_2_degc", room(2)}}) {
    Rows rows = july().rows;
    swap(rows, outdoor, column);
    const Remark r = only_remark(clean_up(rows, alone), Defect::swapped, Action::refused, "outdoor_temp_degc");
    EXPECT_NE(r.text.find(name), std::string::npos) << r.text;
  }
}

// ---- values

TEST(CleanUp, LeavesOutAConstantColumn) {
  for (const auto& [name, column] : {std::pair<const char*, Column>{"room_temp_2_degc", room(2)},
                                     {"fcu_temp_5_degc", fcu(5)},
                                     {"mau_temp_degc", mau},
                                     {"power_1_kw", power(1)}}) {
    Rows rows = july().rows;
    const double first = column(rows[0]);
    map(rows, column, [first](double) { return first; });
    const CleanLog log = clean_up(rows, july().context);
    only_remark(log, Defect::constant, Action::left_out, name);
    hal::LogRow row = log.rows[1000];
    EXPECT_TRUE(std::isnan(column(row)));
  }
  Rows rows = july().rows;
  map(rows, outdoor, [](double) { return 29.5; });
  const CleanLog log = clean_up(rows, july().context);
  EXPECT_TRUE(has(log, Defect::constant, "outdoor_temp_degc")) << told(log.remarks);
  EXPECT_FALSE(log.usable());  // nothing can be simulated without it
}

TEST(CleanUp, LeavesOutTheHoursInWhichASensorIsStuck) {
  for (const auto& [name, column] : {std::pair<const char*, Column>{"room_temp_2_degc", room(2)},
                                     {"mau_temp_degc", mau},
                                     {"outdoor_temp_degc", outdoor},
                                     {"supply_temp_degc", supply},
                                     {"power_2_kw", power(2)}}) {
    Rows rows = july().rows;
    for (std::size_t i = 300; i < 400; ++i) column(rows[i]) = column(rows[299]);
    const CleanLog log = clean_up(rows, july().context);
    const Remark r = only_remark(log, Defect::stuck, Action::left_out, name);
    EXPECT_EQ(r.count, 101u);
    EXPECT_EQ(r.from, rows[299].time);
    EXPECT_EQ(r.to, rows[399].time);
  }
}

TEST(CleanUp, LetsACoarseSensorAndAHeldOutletStandStill) {
  Rows rows = july().rows;
  map(rows, room(2), [](double v) { return std::round(2 * v) / 2; });
  map(rows, mau, [](double v) { return std::max(18.0, v); });
  map(rows, supply, [](double v) { return std::round(5 * v) / 5; });
  for (hal::LogRow& row : rows) {  // a fan of two steps, the lower one at night
    power(1)(row) = row.time.second_of_day() < 6 * 3600 + 1800 ? 0.9 : 1.4;
  }
  const CleanLog log = clean_up(rows, july().context);
  EXPECT_TRUE(log.remarks.empty()) << told(log.remarks);
}

TEST(CleanUp, CountsNumbersThatMeanNoValue) {
  for (const double number : {65535.0, -32768.0, 3276.7, -327.68, 655.35, -9999.0, 1e30}) {
    Rows rows = july().rows;
    for (const std::size_t i : {10u, 11u, 700u}) rows[i].value[3] = number;
    const CleanLog log = clean_up(rows, july().context);
    EXPECT_EQ(only_remark(log, Defect::sentinel, Action::left_out, "room_temp_4_degc").count, 3u);
    EXPECT_TRUE(std::isnan(log.rows[11].value[3]));
  }
  Rows rows = july().rows;
  for (std::size_t i = 100; i < 110; ++i) rows[i].value[6] = 0;
  EXPECT_EQ(only_remark(clean_up(rows, july().context), Defect::sentinel, Action::left_out, "fcu_temp_2_degc").count,
            10u);
}

TEST(CleanUp, CountsMissingAndOutOfRangeValues) {
  Rows rows = july().rows;
  for (const std::size_t i : {10u, 11u, 700u}) rows[i].value[3] = nan;
  EXPECT_EQ(
      only_remark(clean_up(rows, july().context), Defect::missing_value, Action::left_out, "room_temp_4_degc").count,
      3u);
  rows = july().rows;
  for (const std::size_t i : {10u, 11u, 700u}) rows[i].value[23] = 71;
  const CleanLog log = read_dirty_log_text(csv(rows, july().context.counts), july().context);
  EXPECT_EQ(only_remark(log, Defect::out_of_range, Action::left_out, "outdoor_temp_degc").count, 3u);
  EXPECT_TRUE(std::isnan(log.rows[11].value[23]));
}

TEST(CleanUp, LeavesOutAColumnThatIsMostlyOutOfRange) {
  Rows rows = july().rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i % 3 != 0) rows[i].value[1] = -20 - static_cast<double>(i % 10);
  }
  const CleanLog log = clean_up(rows, july().context);
  only_remark(log, Defect::out_of_range, Action::left_out, "room_temp_2_degc");
  EXPECT_TRUE(std::isnan(log.rows[3].value[1]));
}

TEST(CleanUp, TakesOutSpikes) {
  for (const auto& [name, column, size] : {std::tuple<const char*, Column, double>{"room_temp_2_degc", room(2), 5},
                                           {"room_temp_2_degc", room(2), -5},
                                           {"fcu_temp_1_degc", fcu(1), 8},
                                           {"outdoor_temp_degc", outdoor, -7},
                                           {"power_2_kw", power(2), 60}}) {
    Rows rows = july().rows;
    for (const std::size_t i : {150u, 1500u, 2501u}) column(rows[i]) += size;
    const CleanLog log = clean_up(rows, july().context);
    EXPECT_EQ(only_remark(log, Defect::spike, Action::left_out, name).count, 3u);
    hal::LogRow row = log.rows[1500];
    EXPECT_TRUE(std::isnan(column(row)));
  }
}

TEST(CleanUp, StandsDropOuts) {
  Rows rows = july().rows;
  std::mt19937 random(3);
  for (hal::LogRow& row : rows) {
    for (double& v : row.value) {
      if (random() % 50 == 0) v = nan;
    }
  }
  const CleanLog log = clean_up(rows, july().context);
  EXPECT_EQ(log.remarks.size(), 25u) << told(log.remarks);
  EXPECT_TRUE(std::all_of(log.remarks.begin(), log.remarks.end(),
                          [](const Remark& r) { return r.defect == Defect::missing_value; }));
  expect_same_rows(log.rows, rows);
}

// ---- together

TEST(CleanUp, NamesSeveralDefectsOfOneLog) {
  Rows rows = july().rows;
  map(rows, room(3), [](double v) { return hundredths(1.8 * v + 32); });
  rows[200].value[0] = 65535;
  for (std::size_t i = 300; i < 400; ++i) rows[i].value[1] = 25.1;
  rows.erase(rows.begin() + 1000, rows.begin() + 1020);
  std::swap(rows[5], rows[90]);
  const CleanLog log = read_dirty_log_text(csv(rows, july().context.counts), july().context);
  EXPECT_EQ(log.remarks.size(), 5u) << told(log.remarks);
  EXPECT_TRUE(has(log, Defect::shuffled, "") && has(log, Defect::gap, ""));
  EXPECT_TRUE(has(log, Defect::wrong_unit, "room_temp_3_degc") && has(log, Defect::sentinel, "room_temp_1_degc"));
  EXPECT_TRUE(has(log, Defect::stuck, "room_temp_2_degc"));
  EXPECT_TRUE(log.usable());
}

TEST(CleanUp, ThrowsTheFirstReasonToRefuseWithItsRemedy) {
  Rows rows = july().rows;
  swap(rows, outdoor, mau);
  swap(rows, room(2), fcu_on(1));
  const CleanLog log = clean_up(rows, july().context);
  try {
    log.require_usable();
    FAIL() << "not refused" << told(log.remarks);
  } catch (const hal::InputError& error) {
    EXPECT_EQ(error.place(), "room.csv: room_temp_2_degc");
    EXPECT_NE(error.remedy().find("exchange the names"), std::string::npos) << error.what();
    EXPECT_NE(error.remedy().find("1 more"), std::string::npos) << error.what();
  }
}

TEST(CleanUp, TellsAnotherRoomsLogFromTheReferences) {
  const CleanLog reference = clean_up(july().rows, july().context);
  CleanLog same = clean_up(Rows(july().rows.begin() + 1000, july().rows.end()), july().context);
  EXPECT_TRUE(same_room(reference, same, july().context));
  EXPECT_TRUE(same.remarks.empty()) << told(same.remarks);

  const Logged elsewhere = log_of(sim::make_room(), 99, sim::civil_midnight(2023, 7, 5), true);
  CleanLog other = clean_up(elsewhere.rows, elsewhere.context);
  EXPECT_FALSE(same_room(reference, other, july().context));
  only_remark(other, Defect::other_room, Action::refused, "outdoor_temp_degc");

  const Logged later = log_of(sim::make_room(), 7, sim::civil_midnight(2023, 9, 5), true);
  CleanLog warmer = clean_up(later.rows, later.context);
  EXPECT_TRUE(same_room(reference, warmer, july().context));
  EXPECT_TRUE(warmer.remarks.empty()) << told(warmer.remarks);
  for (hal::LogRow& row : warmer.rows) {
    for (std::size_t v = 0; v < 5; ++v) row.value[v] -= 6;
  }
  EXPECT_TRUE(same_room(reference, warmer, july().context));
  only_remark(warmer, Defect::other_room, Action::noted);
}

}  // namespace
}  // namespace airside::tools::gap
