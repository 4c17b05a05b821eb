#pragma once
// A log seen by columns, and robust statistics of a column; for the checks of the clean-up only.

#include <limits>
#include <span>

#include "tools/gap/clean_up/clean_up.hpp"

namespace airside::tools::gap {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t least_values = rows_per_day;  ///< below, nothing is said about a column

constexpr const char* plural(std::size_t n) { return n == 1 ? "" : "s"; }

/// What a column of a log is; the first nine are SignalKinds.
enum class Role {
  room = 0,
  fcu,
  vav_on,
  fcu_on,
  power,
  mau,
  outdoor,
  rain,
  setpoint,
  supply,
};

/// What is expected of a role, whatever the site.
struct RoleFacts {
  bool temperature, indoor, status;
  double low, high;      ///< of the median, degC
  double smallest_jump;  ///< of a spike, units of the column; 0: has no spikes
};

const RoleFacts& facts_of(Role role);

struct LogColumn {
  Role role{};
  std::string name;
  hal::LogLimits limits{};
  std::vector<double> value;  ///< NaN: missing

  const RoleFacts& facts() const { return facts_of(role); }
};

/// The station's outdoor temperature every 6 min, some hours beyond both ends. NaN: not covered.
class StationCourse {
 public:
  StationCourse() = default;
  /// Empty without a station, or where it does not cover the stretch.
  StationCourse(const sim::Weather* station, CivilTime from, CivilTime to);
  bool empty() const { return temp_degc_.empty(); }
  double at(CivilTime t) const;

  static constexpr int beyond_s = 4 * 3600;

 private:
  std::int64_t first_s_ = 0;
  std::vector<double> temp_degc_;
};

/// Columns in the order of the log's values, then setpoint and supply.
struct LogTable {
  std::vector<CivilTime> time;
  std::vector<LogColumn> columns;
  StationCourse station;
  std::optional<OutdoorDifference> outdoor_difference;  ///< by check_weather()

  LogColumn& only(Role role);  ///< of a role that occurs once
};

/// Shape: rows not empty, in order of time.
LogTable table_of(std::span<const hal::LogRow> rows, const CleanUpContext& context);
void write_back(const LogTable& table, std::vector<hal::LogRow>& rows);

/// Statistics of the finite values; NaN where there are none.
std::vector<double> sorted_finite(std::span<const double> values);
double quantile_of_sorted(std::span<const double> sorted, double share);
double median_of(std::span<const double> values);
std::size_t count_finite(std::span<const double> values);
/// Share of the finite values for which `fits`.
template <class Fits>
double share_of(std::span<const double> values, Fits fits) {
  std::size_t finite = 0, fitting = 0;
  for (const double v : values) {
    if (!(v == v)) continue;
    ++finite;
    if (fits(v)) ++fitting;
  }
  return finite > 0 ? static_cast<double>(fitting) / static_cast<double>(finite) : 0;
}

/// How a column follows the station's temperature.
struct Following {
  bool known = false;        ///< enough values, and they do follow it
  int lag_min = 0;           ///< by which the column comes late
  double unexplained = 1;    ///< share of the variance, 1 - r^2, at that lag
  double unexplained_0 = 1;  ///< without a lag
};

/// Lags of up to 3 h 12 min in steps of 6 min; the column may be in any unit.  Cost: 65 passes.
Following follow(std::span<const CivilTime> time, std::span<const double> values, const StationCourse& station);

/// Checks in the order in which they are made; each may change what the next one sees.
using RowCheck = void (*)(std::vector<hal::LogRow>&, const CleanUpContext&, std::vector<Remark>&);
using TableCheck = void (*)(LogTable&, const CleanUpContext&, std::vector<Remark>&);

// clean_up_time.cpp
void check_shape(std::vector<hal::LogRow>& rows, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_order(std::vector<hal::LogRow>& rows, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_grid(std::vector<hal::LogRow>& rows, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_repeated(std::vector<hal::LogRow>& rows, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_conflicts(std::vector<hal::LogRow>& rows, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_gaps(std::vector<hal::LogRow>& rows, const CleanUpContext& context, std::vector<Remark>& remarks);
// clean_up_clock.cpp
void check_daylight_saving(std::vector<hal::LogRow>& rows, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_clock(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);
// clean_up_weather.cpp
void check_weather(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);
// clean_up_columns.cpp
void check_units(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_swapped(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);
// clean_up_values.cpp
void check_missing(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_sentinels(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_range(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_spikes(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_stuck(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);
void check_enough_left(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks);

}  // namespace airside::tools::gap
