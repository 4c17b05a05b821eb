#pragma once
// The log that everything reads and writes: one CSV row every 6 min, ISO local times, units in the header.
// Column names come from signals.hpp, so a log says itself which room shape it belongs to.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "airside/civil_time.hpp"
#include "airside/signals.hpp"
#include "hal/text/staged_file.hpp"

namespace airside::hal {

/// Signals beside the network's inputs; a log has those that the site shows.
enum class SideSignal : std::uint8_t { damper, zone_setpoint, zone_heating_setpoint, occupied, supply_flow, ahu_on };
/// One of them; place 0 where there is only one.
struct SideColumn {
  SideSignal signal;
  int place;
};

/// The counts of a topology as run-time values, and what a site of it senses.
struct TopologyCounts {
  std::string name;
  int vavs = 0, fcus = 0, powers = 0;
  /// The stand-in of each signal that has one, in their order; empty: the site has a sensor for each.
  std::vector<std::optional<double>> stand_ins{};
  std::vector<SideColumn> sides{};  ///< further columns of its logs

  Shape shape() const { return {vavs, fcus, powers}; }
  int signals() const { return 2 * vavs + 2 * fcus + powers + 3; }
  /// Kind and place of sensed signal `index`, in the order of Layout<T>.
  SignalId signal(int index) const;
  /// Nothing where signal `index` is sensed.
  std::optional<double> stand_in(int index) const {
    return stand_ins.empty() ? std::nullopt : stand_ins[static_cast<std::size_t>(index)];
  }
};

inline TopologyCounts counts_of(const Shape& shape) {
  return {name_of(shape).c_str(), shape.vavs, shape.fcus, shape.powers};
}
template <Topology T>
requires(T::exact) TopologyCounts counts_of() { return counts_of(capacity_of<T>()); }

/// `room_temp_1_degc`: name[_place][_unit].
std::string column_of(SignalId id);

/// The column of signal `index` of a site: of a stand-in, `rain_stand_in`, so that nobody takes it for measured.
std::string column_of(const TopologyCounts& counts, int index);
constexpr const char* stand_in_mark = "_stand_in";
/// `damper_1`, `supply_flow_m3s`.
std::string column_of(SideColumn side);
/// Whether a name is that of a side signal's column, of whatever place.
bool is_side_column(std::string_view name);

/// What the controller thought in a row. NaN or "" is written as an empty field.
struct ControllerColumns {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::string mode;              ///< learn, run, expert or release
  std::string reason;            ///< why, "none" while learning undisturbed
  double a_network_degc = none;  ///< best setpoint by the network's forecast
  double a_head_degc = none;     ///< best setpoint after the room head
  double a_expert_degc = none;   ///< the schedule's setpoint
  double a_g36_degc = none;      ///< what Guideline 36 would command
  double confidence = none;      ///< 0..1
  double loss_strb = none, loss_tdb = none, loss_gc = none, loss_rc = none, loss_rec = none;
  std::string fault;                  ///< text of the gravest active fault, "none" where there is none
  double expected_held_degc = none;   ///< held value forecast for the end of the cycle
  double expected_error_k = none;     ///< root mean square of what such forecasts were wrong by lately
  double residual_forecast_k = none;  ///< what the residual network adds to the head's forecast, where all of it counts
  double residual_share = none;       ///< how much of it counts: 0, 0.5 or 1
};

/// One row. Shape: value: signals() of the topology. Units: as in the column names.
struct LogRow {
  CivilTime time;
  std::vector<double> value;  ///< NaN: missing
  double setpoint_degc = ControllerColumns::none;
  double supply_temp_degc = ControllerColumns::none;
  std::vector<double> side;  ///< in the order of TopologyCounts::sides; NaN: missing
  ControllerColumns controller;
  std::vector<std::string> extra;  ///< fields of further columns, in file order
};

/// A row with room for every signal and texts of up to 47 characters, so that filling it never allocates.
LogRow make_log_row(const TopologyCounts& counts);

/// A side signal of a row that is not of a room; NaN where the log has none.
double side_of(const TopologyCounts& counts, const LogRow& row, SideSignal signal);

/// The header line, final newline included. `extra` are names of further columns.
std::string log_header(const TopologyCounts& counts, bool controller, std::span<const std::string> extra = {});

/// Writes the row, final newline included, and returns the number of characters; 0 where `out` is too small.
/// Numbers are the shortest text that reads back to the same bits; commas and line ends in texts become spaces.
/// Cost: no heap.
std::size_t format_log_row(std::span<char> out, const LogRow& row, bool controller);

constexpr std::size_t max_log_row_text = 8192;  ///< characters; enough for 300 columns

/// Bounds that a logged number must keep.
struct LogLimits {
  double min, max;
};

/// Bounds by SignalKind; units as in signals.hpp. What lies outside is a broken sensor, not weather.
constexpr std::array<LogLimits, 9> default_log_limits{{
    {0, 50},     // room_temp
    {0, 60},     // fcu_temp
    {0, 1},      // vav_on
    {0, 1},      // fcu_on
    {0, 10000},  // power
    {-40, 60},   // mau_temp
    {-50, 60},   // outdoor_temp
    {0, 1},      // rain
    {5, 40},     // setpoint
}};

struct LogReadOptions {
  std::array<LogLimits, 9> limits = default_log_limits;
  /// Empty, NaN or out-of-range signals become NaN and are counted instead of being refused.
  bool keep_missing = false;
};

/// A stretch without rows between two rows.
struct LogGap {
  CivilTime from, to;  ///< last row before, first row after
  int line = 0;        ///< of the first row after
};

struct LogSummary {
  CivilTime first, last;
  std::size_t rows = 0;
  std::size_t missing_rows = 0;    ///< in all gaps
  std::size_t missing_values = 0;  ///< only with keep_missing
  std::vector<LogGap> gaps;
};

struct Log {
  std::vector<LogRow> rows;
  std::vector<std::string> extra_columns;
  std::vector<bool> stood_in;   ///< of each signal: a stand-in somewhere, by the site or by a file's header
  bool has_controller = false;  ///< the controller's columns are there
  LogSummary summary;
};

/// Reads a log file, or all `*.csv` of a directory in order of name as one log.
/// Columns may stand in any order; supply_temp_degc, sides and the controller's may be missing, and so may signals for
/// which the site has a stand-in: whatever the file says of those, the stand-in is read.
/// Errors: InputError with file:line and column.
Log read_log(const std::string& path, const TopologyCounts& counts, const LogReadOptions& options = {});

/// Reads several files, each of them later than the one before, as one log.
/// Errors: as read_log(); also for files whose columns differ.
Log read_log_files(const std::vector<std::string>& files, const TopologyCounts& counts,
                   const LogReadOptions& options = {});

/// Reads the text of one log; `name` stands in messages.
Log read_log_text(std::string_view text, const std::string& name, const TopologyCounts& counts,
                  const LogReadOptions& options = {});

/// Writes a log row by row to a new file, which appears when it is closed: a run that stops before leaves none, and no
/// row is cut.
/// Errors: InputError when the file cannot be written; std::runtime_error for a row that does not fit the header.
class LogWriter {
 public:
  LogWriter(std::string path, const TopologyCounts& counts, bool controller,
            std::vector<std::string> extra_columns = {});
  void append(const LogRow& row);
  /// Puts the whole file in its place; an error that only shows here is thrown here.
  void close() { file_.commit(); }

 private:
  std::string path_;
  bool controller_;
  std::size_t values_, sides_, extras_;
  StagedFile file_;
};

}  // namespace airside::hal
