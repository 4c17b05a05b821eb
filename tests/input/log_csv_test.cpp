#include "hal/log/log_csv.hpp"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "airside/splitmix64.hpp"
#include "hal/text/civil_text.hpp"
#include "support/complaint.hpp"

namespace airside::hal {
namespace {

const TopologyCounts three = counts_of<ThreeVav>();

// A log of three VAVs and no fan coils, short enough to read; cases edit it.
const char* const good_log =
    "time,room_temp_1_degc,room_temp_2_degc,room_temp_3_degc,vav_on_1,vav_on_2,vav_on_3,power_1_kw,mau_temp_degc,"
    "outdoor_temp_degc,rain,setpoint_degc,supply_temp_degc\n"
    "2021-07-01T00:00:00,25.1,25.2,25.3,1,1,0,7.5,18,29.5,0,20.5,20.61\n"
    "2021-07-01T00:06:00,25.2,25.2,25.3,1,1,0,7.25,18,29.25,1,20.5,\n"
    "2021-07-01T00:12:00,25.3,25.2,25.3,1,1,0,7.125,18,29,0,21,20.75\n";

Log read(const std::string& text, bool keep_missing = false) {
  return read_log_text(text, "room.csv", three, {default_log_limits, keep_missing});
}

std::uint64_t bits(double value) {
  std::uint64_t word;
  std::memcpy(&word, &value, sizeof word);
  return word;
}

TEST(LogCsv, ReadsValuesInTheOrderOfTheLayout) {
  const Log log = read(good_log);
  ASSERT_EQ(log.rows.size(), 3u);
  const LogRow& row = log.rows[1];
  EXPECT_EQ(civil_text(row.time), "2021-07-01T00:06:00");
  EXPECT_EQ(row.value, (std::vector<double>{25.2, 25.2, 25.3, 1, 1, 0, 7.25, 18, 29.25, 1}));
  EXPECT_EQ(row.setpoint_degc, 20.5);
  EXPECT_TRUE(std::isnan(row.supply_temp_degc));
  EXPECT_FALSE(log.has_controller);
  EXPECT_EQ(log.summary.rows, 3u);
  EXPECT_TRUE(log.summary.gaps.empty());
}

TEST(LogCsv, RunTimeColumnsAreThoseOfTheCompileTimeLayout) {
  const auto check = []<class T>(T) {
    const TopologyCounts counts = counts_of<T>();
    ASSERT_EQ(counts.signals(), Layout<T>::signals);
    for (int i = 0; i < counts.signals(); ++i) EXPECT_EQ(column_of(counts.signal(i)), column_of(signal_id<T>(i)));
  };
  check(FiveZone{});
  check(ThreeVav{});
  check(EightVavFourFcu{});
  EXPECT_EQ(column_of(counts_of<FiveZone>().signal(20)), "power_1_kw");
}

TEST(LogCsv, AcceptsOtherOrderCarriageReturnsMarksQuotesAndFurtherColumns) {
  std::string text = "\xEF\xBB\xBFnote,";
  text += good_log;
  for (const char* day : {"2021-07-01T00:00", "2021-07-01T00:06", "2021-07-01T00:12"}) {
    text = replaced(text, std::string("\n") + day, std::string("\r\n\"warm, dry \"\"day\"\"\",") + day);
  }
  const Log log = read(text);
  ASSERT_EQ(log.rows.size(), 3u);
  EXPECT_EQ(log.extra_columns, std::vector<std::string>{"note"});
  EXPECT_EQ(log.rows[2].extra[0], "warm, dry \"day\"");
  EXPECT_EQ(log.rows[2].setpoint_degc, 21.0);
}

TEST(LogCsv, GapsAreReportedNotRefused) {
  const Log log = read(std::string(good_log) + "2021-07-01T01:00:00,25.3,25.2,25.3,1,1,0,7,18,29,0,21,20.75\n");
  ASSERT_EQ(log.summary.gaps.size(), 1u);
  EXPECT_EQ(log.summary.missing_rows, 7u);
  EXPECT_EQ(log.summary.gaps[0].line, 5);
  EXPECT_EQ(civil_text(log.summary.gaps[0].from), "2021-07-01T00:12:00");
  EXPECT_EQ(civil_text(log.summary.gaps[0].to), "2021-07-01T01:00:00");
}

TEST(LogCsv, KeepMissingTurnsBrokenSensorsIntoHoles) {
  std::string text = replaced(good_log, "25.2,25.2,25.3", "nan,,250");
  const Log log = read(text, true);
  EXPECT_EQ(log.summary.missing_values, 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(std::isnan(log.rows[1].value[i]));
  EXPECT_EQ(log.rows[1].value[3], 1.0);
}

/// A number of a reading: to the millionth.
double reading(double value) { return std::round(value * 1e6) / 1e6; }

TEST(LogCsv, WhatIsWrittenReadsBackToTheSameBits) {
  const std::string path = testing::TempDir() + "airside_round_trip.csv";
  const TopologyCounts five = counts_of<FiveZone>();
  SplitMix64 random(7);
  std::vector<LogRow> rows;
  LogWriter writer(path, five, true, {"chiller_kw"});
  for (int i = 0; i < 500; ++i) {
    LogRow row = make_log_row(five);
    row.time = {1625097600 + std::int64_t{360} * i};
    for (double& value : row.value) value = reading(0.01 + random.uniform());
    row.setpoint_degc = reading(20 + 6 * random.uniform());
    if (i % 3 != 0) row.supply_temp_degc = 20 + 6 * random.uniform();
    row.controller.mode = "learn";
    row.controller.confidence = random.uniform();
    row.controller.loss_rec = random.uniform() * 1e-9;
    row.controller.fault = i % 7 == 0 ? "stuck, \"twice\"" : "none";
    row.extra = {std::to_string(i)};
    writer.append(row);
    rows.push_back(row);
  }
  writer.close();
  LogReadOptions options;
  options.limits.fill({-1, 100});
  const Log log = read_log(path, five, options);
  ASSERT_EQ(log.rows.size(), rows.size());
  EXPECT_TRUE(log.has_controller);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(log.rows[i].time, rows[i].time);
    for (std::size_t j = 0; j < rows[i].value.size(); ++j) {
      ASSERT_EQ(bits(log.rows[i].value[j]), bits(rows[i].value[j])) << i << " " << j;
    }
    EXPECT_EQ(bits(log.rows[i].setpoint_degc), bits(rows[i].setpoint_degc));
    EXPECT_EQ(std::isnan(log.rows[i].supply_temp_degc), std::isnan(rows[i].supply_temp_degc));
    EXPECT_EQ(bits(log.rows[i].controller.loss_rec), bits(rows[i].controller.loss_rec));
    EXPECT_EQ(log.rows[i].controller.fault, i % 7 == 0 ? "stuck   twice " : "none");
    EXPECT_EQ(log.rows[i].extra, rows[i].extra);
  }
  std::filesystem::remove(path);
}

TEST(LogCsv, NumbersAreWrittenAsAPersonWould) {
  const TopologyCounts counts = counts_of<ThreeVav>();
  LogRow row = make_log_row(counts);
  row.time = {1625097600};
  for (double& value : row.value) value = 0.1 + 0.2;
  row.setpoint_degc = 23.869999999999997;
  row.supply_temp_degc = 1234567890.123;
  row.controller.confidence = 0.9984522588838656;
  row.controller.loss_strb = 0.00068764607422;
  row.controller.loss_tdb = 3.4e-12;
  row.controller.a_head_degc = 23.71393462792165;
  std::array<char, 4096> line{};
  const std::size_t size = format_log_row(line, row, true);
  const std::string text(line.data(), size);
  for (const char* part :
       {",0.3,0.3,", ",23.87,1234567890.123,", ",0.998452,", ",0.00068764607422,", ",3.4e-12,", ",23.713935,"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST(LogCsv, AppearsOnlyWhenItIsWhole) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "airside_whole_log";
  std::filesystem::create_directories(folder);
  const std::string path = folder / "log.csv";
  std::ofstream(path) << "time, of before";
  const auto text = [&path] {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const auto files = [&folder] {
    return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
  };
  {
    LogWriter writer(path, three, false);
    LogRow row = make_log_row(three);
    row.value.assign(10, 1.0);
    writer.append(row);
    EXPECT_EQ(text(), "time, of before");
  }
  EXPECT_EQ(text(), "time, of before");
  EXPECT_EQ(files(), 1);
  const std::string link = folder / "link.csv";
  std::filesystem::create_symlink("log.csv", link);
  LogWriter again(link, three, false);
  again.close();
  again.close();
  EXPECT_EQ(text(), log_header(three, false));
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(files(), 2);
  std::filesystem::remove_all(folder);
}

TEST(LogCsv, GoesToADeviceDirectly) {
  LogWriter writer("/dev/full", three, false);
  EXPECT_THROW(writer.close(), InputError);
  LogWriter nowhere("/dev/null", three, false);
  nowhere.close();
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_FALSE(std::filesystem::exists("/dev/null.part"));
  expect_complaint({"no/such/log.csv", "cannot be written", "writable place", "choose another"},
                   [] { LogWriter("no/such/log.csv", three, false); });
}

TEST(LogCsv, FormatSaysSoWhenTheBufferIsTooSmall) {
  LogRow row = make_log_row(three);
  row.value.assign(10, 1.0 / 3.0);
  char text[max_log_row_text];
  const std::size_t size = format_log_row(text, row, false);
  ASSERT_GT(size, 100u);
  for (std::size_t small = 0; small < size; ++small) EXPECT_EQ(format_log_row({text, small}, row, false), 0u);
  EXPECT_EQ(format_log_row({text, size}, row, false), size);
}

struct Case {
  const char* name;
  const char* from;
  const char* to;
  Complaint want;
};

const Case cases[] = {
    {"TimeColumnMissing", "time,", "when,", {"room.csv:1", "no column `time`", "starts with `time`", "ISO local"}},
    {"ColumnMissing",
     "room_temp_2_degc",
     "office_b",
     {"room.csv:1: room_temp_2_degc", "no such column", "room_temp_2_degc", "add it"}},
    {"SetpointMissing", "setpoint_degc", "sat", {":1: setpoint_degc", "no such column", "setpoint_degc", "add it"}},
    {"Fahrenheit",
     "room_temp_1_degc",
     "room_temp_1_degf",
     {":1: room_temp_1_degf", "the unit `degf`", "`degc`", "convert the values"}},
    {"Watts", "power_1_kw", "power_1_w", {":1: power_1_w", "the unit `w`", "`kw`", "convert the values"}},
    {"UnitMissing", "mau_temp_degc", "mau_temp", {":1: mau_temp", "without unit", "`degc`", "rename"}},
    {"SupplyInFahrenheit", "supply_temp_degc", "supply_temp_degf", {":1: supply_temp_degf", "degf", "degc", "convert"}},
    {"StatusInPercent", "vav_on_1,", "vav_on_1_percent,", {":1: vav_on_1_percent", "percent", "0/1", "convert"}},
    {"ColumnTwice", "room_temp_2_degc", "room_temp_1_degc", {":1: room_temp_1_degc", "twice", "once", "remove"}},
    {"ColumnWithoutName", "room_temp_2_degc", "", {":1", "no name for column 3", "a name", "remove it"}},
    {"OtherTopology",
     "room_temp_3_degc,vav_on_1,vav_on_2,vav_on_3,",
     "room_temp_3_degc,room_temp_4_degc,vav_on_1,vav_on_2,vav_on_3,vav_on_4,",
     {":1", "a 4vav-0fcu-1power room", "3vav-0fcu-1power", "topology in [site]"}},
    {"FanCoilsOfAnotherTopology",
     "vav_on_1,",
     "fcu_temp_1_degc,fcu_on_1,vav_on_1,",
     {":1", "a 3vav-1fcu-1power room", "3vav-0fcu-1power", "topology in [site]"}},
    {"TextForNumber", "25.1,25.2", "warm,25.2", {":2: room_temp_1_degc", "`warm`", "such as 25.3", "correct"}},
    {"NumberWithUnit", "25.1,25.2", "25.1C,25.2", {":2: room_temp_1_degc", "`25.1C`", "such as 25.3", "correct"}},
    {"DecimalCommaInQuotes", "25.1,25.2", "\"25,1\",25.2", {":2: room_temp_1_degc", "`25,1`", "25.3", "point"}},
    {"DecimalComma", "25.1,25.2", "25,1,25.2", {":2", "14 fields", "13 as in the header", "decimal commas"}},
    {"FieldMissing", "7.25,18,", "18,", {":3", "12 fields", "13", "missing field"}},
    {"CutLastLine", "29,0,21,20.75\n", "29,0", {":4", "11 fields", "13", "cut off"}},
    {"EmptySignal", "25.1,25.2", ",25.2", {":2: room_temp_1_degc", "empty field", "0 to 50 degc", "gaps"}},
    {"NotANumber", "25.1,25.2", "nan,25.2", {":2: room_temp_1_degc", "`nan`", "0 to 50 degc", "gaps"}},
    {"Infinite", "29.25,1", "inf,1", {":3: outdoor_temp_degc", "`inf`", "-50 to 60 degc", "remove"}},
    {"Sentinel", "25.1,25.2", "3276.7,25.2", {":2: room_temp_1_degc", "3276.7", "0 to 50 degc", "sensor"}},
    {"StatusOutOfRange", "1,1,0,7.5", "100,1,0,7.5", {":2: vav_on_1", "100", "from 0 to 1", "correct"}},
    {"SetpointOutOfRange", "0,20.5,20.61", "0,0,20.61", {":2: setpoint_degc", "`0`", "5 to 40", "correct"}},
    {"SupplyNotANumber", "20.61", "off", {":2: supply_temp_degc", "`off`", "25.3", "correct"}},
    {"GermanDate",
     "2021-07-01T00:06:00",
     "01.07.2021 00:06",
     {":3: time", "01.07.2021", "2021-07-01T00:06:00", "ISO dates"}},
    {"TimeZone", "2021-07-01T00:06:00", "2021-07-01T00:06:00Z", {":3: time", "Z`", "2021-07-01", "without a zone"}},
    {"DayThatDoesNotExist", "2021-07-01T00:06:00", "2021-02-30T00:06:00", {":3: time", "02-30", "a time", "ISO"}},
    {"SameTimeTwice", "00:12:00", "00:06:00", {":4: time", "the same as line 3", "once", "remove one"}},
    {"TimeGoesBack",
     "2021-07-01T00:12:00",
     "2021-06-30T23:00:00",
     {":4: time", "earlier than 2021-07-01T00:06:00 of line 3", "grow", "sort"}},
    {"FiveMinutes", "00:06:00", "00:05:00", {":3: time", "300 s after line 2", "every 6 min", "resample"}},
};

class BrokenLog : public testing::TestWithParam<Case> {};

TEST_P(BrokenLog, IsRefusedWithPlaceFoundExpectedAndRemedy) {
  const Case& c = GetParam();
  const std::string text = replaced(good_log, c.from, c.to);
  expect_complaint(c.want, [&] { read(text); });
}

INSTANTIATE_TEST_SUITE_P(Table, BrokenLog, testing::ValuesIn(cases),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(LogCsv, FilesThatAreNoLogsAreRefused) {
  const std::string header(good_log, std::strchr(good_log, '\n') + 1);
  expect_complaint({"room.csv:1", "empty file", "header", "export"}, [] { read(""); });
  expect_complaint({"room.csv:1", "empty file", "header", "export"}, [] { read("\r\n \n"); });
  expect_complaint({"room.csv:1", "not text", "CSV", "plain CSV"}, [] { read("PK\x03\x04 spreadsheet"); });
  expect_complaint({"room.csv:1", "not text", "CSV", "plain CSV"}, [] { read(std::string("a\0b", 3)); });
  expect_complaint({"room.csv:1", "separated by `;`", "`,`", "decimal mark"}, [] { read("time;room_temp_1_degc\n"); });
  expect_complaint({"room.csv:1", "without rows", "at least one row", "export"}, [&] { read(header); });
  expect_complaint({"no/such.csv", "no file", "CSV log", "path"}, [] { read_log("no/such.csv", three); });
}

TEST(LogCsv, ThreeRowsWithoutNeighboursSayTheirSpacing) {
  std::string text = replaced(good_log, "00:12:00", "00:36:00");
  text = replaced(text, "00:06:00", "00:18:00");
  expect_complaint({"room.csv: time", "rows every 18 min", "every 6 min", "6-min interval"}, [&] { read(text); });
}

TEST(LogCsv, ADirectoryIsReadAsOneLogAndOverlapsAreRefused) {
  namespace fs = std::filesystem;
  const fs::path dir = fs::path(testing::TempDir()) / "airside_log_dir";
  fs::remove_all(dir);
  fs::create_directory(dir);
  expect_complaint({"airside_log_dir", "without *.csv", "log files", "directory"},
                   [&] { read_log(dir.string(), three); });
  std::ofstream(dir / "airside-2021-07-01.csv") << good_log;
  std::string next = good_log;
  for (int i = 0; i < 3; ++i) next = replaced(next, "2021-07-01", "2021-07-02");
  std::ofstream(dir / "airside-2021-07-02.csv") << next;
  const Log log = read_log(dir.string(), three);
  EXPECT_EQ(log.rows.size(), 6u);
  EXPECT_EQ(log.summary.gaps.size(), 1u);
  EXPECT_EQ(log.summary.missing_rows, 237u);
  std::ofstream(dir / "airside-2021-07-03.csv") << good_log;
  expect_complaint({"07-03.csv:2: time", "2021-07-01T00:00:00", "after 2021-07-02T00:12:00", "share"},
                   [&] { read_log(dir.string(), three); });
  fs::remove_all(dir);
}

TEST(LogCsv, EveryPrefixIsAcceptedOrRefusedWithAnInputError) {
  const std::string text = good_log;
  for (std::size_t size = 0; size <= text.size(); ++size) {
    try {
      EXPECT_LE(read(text.substr(0, size)).rows.size(), 3u);
    } catch (const InputError&) {
    }
  }
}

TEST(CivilText, ReadsAndWritesEveryDayOfFourHundredYears) {
  for (std::int64_t day = -40000; day < 106097; ++day) {
    const CivilTime time{day * 86400 + (day * 7919 % 86400 + 86400) % 86400};
    ASSERT_EQ(parse_civil_text(civil_text(time)), time) << civil_text(time);
  }
  EXPECT_EQ(civil_text({1625097960}), "2021-07-01T00:06:00");
  EXPECT_EQ(parse_civil_text("2021-07-01 00:06"), CivilTime{1625097960});
  EXPECT_EQ(parse_civil_text("2021-06-30T24:00"), CivilTime{1625097600});
  for (const char* bad : {"", "2021-7-1T00:06", "2021-07-01", "2021-07-01T24:06", "2021-13-01T00:00",
                          "2021-07-01T00:06:00Z", "2021-07-01T00:60", "20210701T0006", "2021-07-01T00:06:0x"}) {
    EXPECT_FALSE(parse_civil_text(bad)) << bad;
  }
}

}  // namespace
}  // namespace airside::hal
