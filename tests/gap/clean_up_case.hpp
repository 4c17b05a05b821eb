#pragma once
// What tests of the clean-up share: two logs, their columns, and what is expected of a remark.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "hal/text/civil_text.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/blind/blind.hpp"
#include "tools/gap/clean_up/clean_up.hpp"

namespace airside::tools::gap {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

using Rows = std::vector<hal::LogRow>;
using Column = std::function<double&(hal::LogRow&)>;

/// Two weeks of a room and what is known beside them.
struct Logged {
  Rows rows;
  CleanUpContext context;
};

inline Logged log_of(const sim::RcRoom& twin, std::uint64_t seed, CivilTime start, bool feedback,
                     const std::vector<Hidden>& hidden = {}) {
  const sim::RcRoom room = hide(measured_room(twin, seed, feedback), hidden, {});
  Logged log;
  log.context.place = "room.csv";
  log.context.counts = {"test", room.vavs, room.fcus, room.powers};
  log.context.station = sim::synthetic_weather(seed);
  MeasuredRun run;
  run.start = start;
  run.seed = seed;
  run.feedback = feedback;
  log.rows = measure(room, log.context.station, run, hidden);
  return log;
}

/// Five zones with five fan coils, two powers: a warm fortnight under control, a cool one with a varied setpoint.
inline const Logged& july() {
  static const Logged log = log_of(sim::make_room(), 7, sim::civil_midnight(2023, 7, 3), true);
  return log;
}
inline const Logged& january() {
  static const Logged log = log_of(sim::load_room("701"), 8, sim::civil_midnight(2023, 1, 9), false);
  return log;
}

// Columns of the five-zone logs.
inline Column signal(int index) {
  return [index](hal::LogRow& row) -> double& { return row.value[static_cast<std::size_t>(index)]; };
}
inline Column room(int n) { return signal(n - 1); }
inline Column fcu(int n) { return signal(4 + n); }
inline Column vav_on(int n) { return signal(9 + n); }
inline Column fcu_on(int n) { return signal(14 + n); }
inline Column power(int n) { return signal(19 + n); }
const Column mau = signal(22), outdoor = signal(23), rain = signal(24);
const Column setpoint = [](hal::LogRow& row) -> double& { return row.setpoint_degc; };
const Column supply = [](hal::LogRow& row) -> double& { return row.supply_temp_degc; };

inline void map(Rows& rows, const Column& column, const std::function<double(double)>& f) {
  for (hal::LogRow& row : rows) column(row) = f(column(row));
}
inline void swap(Rows& rows, const Column& a, const Column& b) {
  for (hal::LogRow& row : rows) std::swap(a(row), b(row));
}
inline double hundredths(double v) { return std::round(100 * v) / 100; }

inline std::string told(const std::vector<Remark>& remarks) {
  std::string text;
  for (const Remark& r : remarks) {
    text += std::string("\n  ") + text_of(r.defect) + " | " + text_of(r.action) + " | " + r.column + " | " +
            hal::civil_text(r.from) + " .. " + hal::civil_text(r.to) + " | " + std::to_string(r.count) + " | " + r.text;
  }
  return text.empty() ? "no remark" : text;
}

/// The same times and the same bits, NaN included.
inline void expect_same_rows(const Rows& a, const Rows& b) {
  ASSERT_EQ(a.size(), b.size());
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].time, b[i].time) << "row " << i;
    ASSERT_TRUE(std::equal(a[i].value.begin(), a[i].value.end(), b[i].value.begin(), b[i].value.end(), same)) << i;
    ASSERT_TRUE(same(a[i].setpoint_degc, b[i].setpoint_degc) && same(a[i].supply_temp_degc, b[i].supply_temp_degc));
  }
}

inline void expect_near(const Rows& a, const Rows& b, const Column& column, double tolerance) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    hal::LogRow x = a[i], y = b[i];
    ASSERT_NEAR(column(x), column(y), tolerance) << "row " << i;
  }
}

/// The one remark that a log must give.
inline Remark only_remark(const CleanLog& log, Defect defect, Action action, const std::string& column = "") {
  EXPECT_EQ(log.remarks.size(), 1u) << told(log.remarks);
  if (log.remarks.empty()) return {};
  const Remark& r = log.remarks.front();
  EXPECT_EQ(r.defect, defect) << told(log.remarks);
  EXPECT_EQ(r.action, action) << told(log.remarks);
  EXPECT_EQ(r.column, column) << told(log.remarks);
  EXPECT_EQ(log.usable(), action != Action::refused);
  return r;
}

inline bool has(const CleanLog& log, Defect defect, const std::string& column) {
  return std::any_of(log.remarks.begin(), log.remarks.end(),
                     [&](const Remark& r) { return r.defect == defect && r.column == column; });
}

inline std::string csv(const Rows& rows, const hal::TopologyCounts& counts) {
  std::string text = hal::log_header(counts, false);
  std::vector<char> line(hal::max_log_row_text);
  for (const hal::LogRow& row : rows) text.append(line.data(), hal::format_log_row(line, row, false));
  return text;
}

// ---- nothing wrong

}  // namespace airside::tools::gap
