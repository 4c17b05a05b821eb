// A log of other columns, units, times and steps as rows of 6 min: what each becomes, and what is refused.

#include "tools/gap/map/mapped_log.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/map/mapped_table.hpp"
#include "tools/gap/model/log_window.hpp"

namespace airside::tools::gap {
namespace {

constexpr const char* files_of_both = "[model]\nfile = \"a.idf\"\n[weather]\nfile = \"a.epw\"\n";

/// Two whole days of two rooms and a meter, by the hour; the meter's energy is that of the hour before.
std::string hourly(const std::function<double(int)>& kwh) {
  std::string text = "when,core,meter\n";
  for (int h = 0; h <= 72; ++h) {
    text += fmt::format("{},{:.3f},{:.4f}\n", hal::civil_text({1625097600 + h * 3600}), 75.2 + 1.8 * std::sin(0.26 * h),
                        kwh(h));
  }
  return text;
}

const std::string hourly_map = std::string(files_of_both) + R"([log]
time = "when"
step_min = 60
[[channel]]
column = "core"
zone = "Core_ZN"
unit = "degF"
[[channel]]
column = "meter"
kind = "power"
meter = "Electricity:Facility"
unit = "kWh"
)";

CleanLog read(const std::string& text, const std::string& map) {
  static const auto station = sim::synthetic_weather(3);
  const Mapping m = parse_mapping(map, "map.toml");
  CleanUpContext context;
  context.place = "log.csv";
  context.counts = counts_of(m);
  context.station = station;
  return read_mapped_texts({text}, m, context);
}

std::string refusal(const std::string& text, const std::string& map) {
  try {
    read(text, map).require_usable();
  } catch (const hal::InputError& e) {
    return e.what();
  }
  return "";
}

const hal::LogRow& row_at(const CleanLog& log, const char* time) {
  const CivilTime t = hal::parse_civil_text(time).value();
  for (const hal::LogRow& row : log.rows) {
    if (row.time == t) return row;
  }
  throw std::runtime_error(std::string("no row at ") + time);
}

double meter_at(const CleanLog& log, const char* time) { return row_at(log, time).value[2]; }

TEST(MappedLog, TemperaturesAreInstantsAndEnergyIsMeanPowerOfTheHour) {
  const CleanLog log = read(hourly([](int h) { return 2.0 + h % 5; }), hourly_map);
  ASSERT_TRUE(log.usable());
  EXPECT_NEAR(row_at(log, "2021-07-01T03:00:00").value[0], (75.2 + 1.8 * std::sin(0.78) - 32) / 1.8, 1e-3);
  const double before = (75.2 + 1.8 * std::sin(0.78) - 32) / 1.8, after = (75.2 + 1.8 * std::sin(1.04) - 32) / 1.8;
  EXPECT_NEAR(row_at(log, "2021-07-01T03:30:00").value[0], (before + after) / 2, 1e-3) << "between two hours";
  EXPECT_NEAR(meter_at(log, "2021-07-01T03:00:00"), 5, 1e-9) << "the six minutes before belong to the hour before";
  EXPECT_NEAR(meter_at(log, "2021-07-01T03:06:00"), 6, 1e-9);
  EXPECT_NEAR(meter_at(log, "2021-07-01T04:00:00"), 6, 1e-9);
  EXPECT_EQ(row_at(log, "2021-07-01T04:00:00").value[1], 1) << "no box is commanded";
  const CleanLog begins =
      read(hourly([](int h) { return 2.0 + h % 5; }), hourly_map + "noise_floor = 0.1\n" + "mean = true\n");
  EXPECT_EQ(meter_at(begins, "2021-07-01T03:06:00"), meter_at(log, "2021-07-01T03:06:00"));
}

TEST(MappedLog, AStampMayBeTheBegin) {
  std::string map = hourly_map;
  map.insert(map.find("[[channel]]"), "stamp = \"begin\"\n");
  const CleanLog log = read(hourly([](int h) { return 2.0 + h % 5; }), map);
  EXPECT_NEAR(meter_at(log, "2021-07-01T03:06:00"), 5, 1e-9);
  EXPECT_NEAR(row_at(log, "2021-07-01T03:00:00").value[0], (75.2 + 1.8 * std::sin(0.78) - 32) / 1.8, 1e-3)
      << "an instant is where it is stamped";
}

TEST(MappedLog, ACounterIsReadByItsRises) {
  const std::string map = hourly_map + "counter = true\n";
  double total = 100;
  const CleanLog log = read(hourly([&total](int h) {
                              if (h == 30) total = 0;  // a new meter
                              return total += 2 + h % 5;
                            }),
                            map);
  EXPECT_NEAR(meter_at(log, "2021-07-01T03:06:00"), 6, 1e-6);
  EXPECT_TRUE(std::isnan(meter_at(log, "2021-07-02T05:30:00"))) << "set back at 6:00";
  EXPECT_NEAR(meter_at(log, "2021-07-02T06:30:00"), 3, 1e-6);
}

TEST(MappedLog, DenseRowsAreAveraged) {
  const auto core = [](int minute) { return 24 + std::sin(minute / 200.0) + 0.1 * (minute % 6); };
  std::string text = "when;core;SAT;fan\n";
  for (int i = 0; i <= 3 * 1440; ++i) {
    std::string number = fmt::format("{:.4f}", core(i));
    std::replace(number.begin(), number.end(), '.', ',');
    text +=
        fmt::format("{};{};{};{}\n", 1625097600 - 8 * 3600 + i * 60, number, 286 + i / 1440, i % 120 < 60 ? 100 : 0);
  }
  const std::string map = std::string(files_of_both) + R"([log]
time = "when"
format = "unix"
separator = ";"
decimal_comma = true
step_min = 1
[[channel]]
column = "core"
zone = "Core_ZN"
[[command]]
column = "SAT"
schedule = "S"
kind = "supply_setpoint"
unit = "K"
[[command]]
column = "fan"
schedule = "F"
unit = "%"
)";
  const CleanLog log = read(text, map);
  ASSERT_TRUE(log.usable());
  const hal::LogRow& row = row_at(log, "2021-07-02T10:06:00");
  double mean = 0;
  for (int i = 2046 - 2; i <= 2046 + 3; ++i) mean += core(i) / 6;
  EXPECT_NEAR(row.value[0], mean, 1e-4);
  EXPECT_NEAR(row.setpoint_degc, 287 - 273.15, 1e-9);
  ASSERT_EQ(row.side.size(), 1U);
  EXPECT_EQ(row.side[0], 1);
  EXPECT_EQ(row_at(log, "2021-07-02T11:06:00").side[0], 0);
  const Window window = window_of(log.rows, {1, 0, 0}, nullptr, "log.csv", counts_of(parse_mapping(map, "m")), 1);
  EXPECT_EQ(window.recording.rows[101].commands, (std::vector<double>{1}));
  EXPECT_EQ(window.recording.rows[111].commands, (std::vector<double>{0}));
}

TEST(MappedLog, TimesOfOtherClocks) {
  const auto time = [](const char* field, const MappedLog& log, std::optional<CivilTime> before = {}) {
    const auto t = mapped_time(field, log, 1, before);
    return t ? hal::civil_text(*t) : "none";
  };
  MappedLog log;
  EXPECT_EQ(time("2021-07-01 03:00", log), "2021-07-01T03:00:00");
  EXPECT_EQ(time("2021-07-01T03:00:00.250Z", log), "2021-07-01T04:00:00");
  EXPECT_EQ(time("2021-07-01T03:00:00-05:30", log), "2021-07-01T09:30:00");
  EXPECT_EQ(time("2021-07-01T03:00:00+5:3", log), "none");
  EXPECT_EQ(time("01.07.2021 03:00", log), "none");
  log.utc_offset_h = 0;
  EXPECT_EQ(time("2021-07-01 03:00", log), "2021-07-01T04:00:00");
  log.format = "%d.%m.%Y %H:%M";
  EXPECT_EQ(time("01.07.2021 03:00", log), "2021-07-01T04:00:00");
  EXPECT_EQ(time("01.07.2021 03:00 h", log), "none");
  log.format = "unix";
  EXPECT_EQ(time("1625097600", log), "2021-07-01T01:00:00");
  EXPECT_EQ(time("yesterday", log), "none");
  MappedLog wall;
  wall.daylight_saving = DaylightSaving::european_union;
  EXPECT_EQ(time("2021-07-01 03:00", wall), "2021-07-01T02:00:00");
  EXPECT_EQ(time("2021-12-01 03:00", wall), "2021-12-01T03:00:00");
  EXPECT_EQ(time("2021-10-31 02:30", wall), "2021-10-31T01:30:00");
  EXPECT_EQ(time("2021-10-31 02:30", wall, hal::parse_civil_text("2021-10-31T01:30:00")), "2021-10-31T02:30:00");
}

TEST(MappedLog, WhatCannotBeReadIsSaid) {
  const std::string good = hourly([](int) { return 2.0; });
  std::string renamed = hourly_map;
  renamed.replace(renamed.find("\"core\""), 6, "\"cor\"");
  const std::string column = refusal(good, renamed);
  EXPECT_EQ(column.rfind("log.csv:1: found no column \"cor\"; near it: \"core\"", 0), 0U) << column;
  EXPECT_NE(column.find("map.toml:8:1: channel[1]"), std::string::npos) << column;
  std::string divided = good;
  std::replace(divided.begin(), divided.end(), ',', '|');
  EXPECT_NE(refusal(divided, hourly_map).find("is the separator right?"), std::string::npos);
  EXPECT_NE(refusal("when,core,meter\n1.7.2021,70,1\n", hourly_map).find("`1.7.2021` as a time"), std::string::npos);
  EXPECT_NE(refusal("when,core,meter\n", hourly_map).find("no row"), std::string::npos);
  std::string mostly = good;
  for (int i = 0; i < 80; ++i) mostly += "1.7.2021,70,1\n";
  EXPECT_NE(refusal(mostly, hourly_map).find("correct format in [log]"), std::string::npos);

  std::string rough = good;
  rough += "2021-07-04T00:00:00,bad,3\n2021-07-04T00:00:00,\"75\",3\ncut\n# a comment\n\n";
  const CleanLog log = read("\xEF\xBB\xBF" + rough, hourly_map);
  ASSERT_GE(log.remarks.size(), 3U);
  EXPECT_NE(log.remarks[0].text.find("`cut`"), std::string::npos) << log.remarks[0].text;
  EXPECT_NE(log.remarks[1].text.find("`bad`"), std::string::npos) << log.remarks[1].text;
  EXPECT_NE(log.remarks[2].text.find("the last one counts"), std::string::npos) << log.remarks[2].text;
  EXPECT_NE(refusal(hourly([](int) { return NAN; }).substr(0, 16) + "2021-07-01T00:00:00,,\n", hourly_map), "");
}

TEST(MappedLog, ALogMayHaveNoRoomAndNoSetpointButNotNothing) {
  std::string map = std::string(files_of_both) + "[log]\ntime = \"when\"\nstep_min = 60\n";
  map.insert(map.find("[weather]"), "zones = [\"Core_ZN\"]\n");
  map += "[[channel]]\ncolumn = \"meter\"\nkind = \"power\"\nmeter = \"M\"\nunit = \"kWh\"\n";
  const CleanLog log = read(hourly([](int h) { return 2.0 + h % 3; }), map);
  EXPECT_TRUE(log.usable()) << (log.remarks.empty() ? "" : log.remarks.front().text);
  EXPECT_TRUE(std::isnan(log.rows[100].setpoint_degc));
  std::string still = hourly([](int) { return 2.0; });
  EXPECT_NE(refusal(still, map).find("no column that can be used"), std::string::npos) << "one value throughout";
}

TEST(NoiseModel, AnHourlyMeterIsComparedByTheHour) {
  sim::Channels channels{1, 0, 1};
  channels.grain.resize(static_cast<std::size_t>(channels.count()));
  channels.grain[static_cast<std::size_t>(channels.power())] = {60, false, 0.3, "meter"};
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(20 * bins_per_day, channels.count());
  for (Eigen::Index t = 0; t < x.rows(); ++t) {
    x(t, 0) = 0.1 * std::sin(static_cast<double>(t * t));
    x(t, channels.power()) = t % 2 == 0 ? 5 : -5;  // within the hour nobody knows
  }
  const NoiseModel noise = NoiseModel::fit(x, channels);
  const std::vector<bool> kept(static_cast<std::size_t>(x.rows()), true);
  const Eigen::VectorXd e = noise.whiten(x, kept, x);
  double power = 0;
  for (Eigen::Index i = channels.power(); i < e.size(); i += channels.count()) power = std::max(power, std::abs(e(i)));
  EXPECT_LT(power, 1e-9);
  Eigen::MatrixXd risen = x;
  risen.col(channels.power()).array() += 1;
  const Eigen::VectorXd d = noise.whiten(risen, kept, risen) - e;
  const auto hours = (d.array().abs() > 1e-6).count();
  EXPECT_NEAR(static_cast<double>(hours), 20 * 24, 4) << "one value an hour";
  EXPECT_LT(d.cwiseAbs().maxCoeff(), 1 / 0.3 + 0.1) << "the floor of noise holds";
}

}  // namespace
}  // namespace airside::tools::gap
