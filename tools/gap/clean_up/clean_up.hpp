#pragma once
// What is wrong with a log, said before anything is concluded from it: each defect is named, and is put right, left
// out or a reason to refuse. Behind this stage a value is right as far as the log itself can tell, or NaN.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/log/log_csv.hpp"
#include "sim/weather/weather.hpp"

namespace airside::tools::gap {

/// What may be wrong with a log.
enum class Defect {
  unreadable,       ///< lines or fields that are no row and no number
  off_grid,         ///< rows beside the 6-min grid
  shuffled,         ///< times that do not grow
  duplicate,        ///< several rows with one time
  daylight_saving,  ///< an hour that is missing or comes twice, and a clock that differs before and after
  gap,              ///< missing rows
  other_period,     ///< not the time that was asked for
  missing_value,    ///< empty fields
  sentinel,         ///< numbers with which a device says that it has none
  wrong_unit,
  swapped,
  implausible,  ///< not what the column's name says
  out_of_range,
  spike,
  constant,  ///< one value throughout
  stuck,     ///< one value for hours while others move
  clock_shift,
  other_weather,  ///< the station's days are not those of the log
  other_room,
  too_little,  ///< not enough left to work with
};

/// What was done about it.
enum class Action {
  noted,     ///< nothing
  warned,    ///< nothing, and conclusions are in doubt
  fixed,     ///< values or times were put right
  left_out,  ///< values became NaN, rows were dropped
  refused,   ///< the log cannot be used
};

/// "daylight saving", "left out".
const char* text_of(Defect defect);
const char* text_of(Action action);

/// A row of the clean-up table.
struct Remark {
  Defect defect{};
  Action action = Action::noted;
  std::string column;     ///< empty: all
  CivilTime from, to;     ///< first and last row concerned
  std::size_t count = 0;  ///< of rows or values
  std::string text;       ///< one sentence: what was found, what was done
  std::string expected;   ///< refused only: what should have been there
  std::string remedy;     ///< refused only: what the user can do
};

/// What is known beside the log.
struct CleanUpContext {
  std::string place;                                               ///< file name, for messages
  hal::TopologyCounts counts;                                      ///< of the room
  std::shared_ptr<const sim::Weather> station;                     ///< may be null: then checks against it are left out
  std::array<hal::LogLimits, 9> limits = hal::default_log_limits;  ///< by SignalKind; units as in the log
  /// Electric power a zone, far above any room's; infinite where meters may be of a whole building.
  double largest_zone_kw = 20;
  ControlCycle cycle;  ///< in which the setpoint steps
  /// Of a log with whichever columns its owner has: any may be absent, as long as one is there.
  bool partial = false;
  std::optional<CivilTime> from, to;  ///< period that was asked for
};

/// How a log's outdoor temperature differs from the station's, in hourly means. The first three are of the log as it
/// is, the others of the log put back by `lag_min`.
struct OutdoorDifference {
  double mean_k = 0;             ///< log less station
  double rms_k = 0;              ///< about that mean
  int lag_min = 0;               ///< by which the log comes late; 0 unless a shift takes a tenth off
  double shifted_rms_k = 0;      ///< about the mean
  double irregular_k = 0;        ///< about the mean course of the day: a sensor in the sun has one, other weather none
  int days = 0;                  ///< with 20 hours or more
  double daily_k = 0;            ///< standard deviation of the differences of daily means
  double daily_correlation = 1;  ///< of the daily means themselves

  /// More than sensor and distance make: irregular_k > 1.1, or daily means of 4 days or more that differ by > 0.3 K and
  /// correlate by < 0.9.  Source: docs/gap-workflow.md, "The weather beside the log".
  bool other_weather() const;
  /// Days that have nothing in common: daily means of 6 days or more that differ by > 1 K and correlate by < 0.3.
  bool no_relation() const;
};

/// The rows that may be used, and what was said about the others.
struct CleanLog {
  std::string place;
  std::vector<hal::LogRow> rows;  ///< in order of time, each once, on the 6-min grid; NaN: not to be used
  std::vector<Remark> remarks;    ///< in the order of the checks; rows and values are counted once a defect
  std::optional<OutdoorDifference> outdoor_difference;  ///< none without a station or a sensor

  bool usable() const;
  /// Throws hal::InputError of the first refused remark and the number of the others, if there are any.
  void require_usable() const;
};

/// Looks for every Defect.
/// Errors: none; what is wrong stands in the remarks.  Cost: 2 weeks about 20 ms, a year 0.5 s.
CleanLog clean_up(std::vector<hal::LogRow> rows, const CleanUpContext& context);

/// Reads a log, or all `*.csv` of a directory in order of name, and cleans it up. Rows and columns are understood as
/// hal::read_log does, but rows in any order, several with one time, off the grid, cut, and fields that are no
/// numbers are remarks instead of errors.
/// Errors: hal::InputError for a file that is none and a header that does not fit.
CleanLog read_dirty_log(const std::string& path, const CleanUpContext& context);

/// The same of text; context.place stands in messages.
CleanLog read_dirty_log_text(std::string_view text, const CleanUpContext& context);

/// "log.csv: outdoor temperatures of the log and of ..", a line a warning; "" without one.
std::string warnings_text(const CleanLog& log);

/// Whether two logs can be of one room: outdoor temperatures of the same hours agree (else refused), medians of rooms
/// differ by less than 5 K (else noted). Remarks go to `measured`.
bool same_room(const CleanLog& reference, CleanLog& measured, const CleanUpContext& context);

}  // namespace airside::tools::gap
