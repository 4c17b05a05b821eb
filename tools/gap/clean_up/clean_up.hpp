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
  other_room,
  too_little,  ///< not enough left to work with
};

/// What was done about it.
enum class Action {
  noted,     ///< nothing
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

/// The rows that may be used, and what was said about the others.
struct CleanLog {
  std::string place;
  std::vector<hal::LogRow> rows;  ///< in order of time, each once, on the 6-min grid; NaN: not to be used
  std::vector<Remark> remarks;    ///< in the order of the checks; rows and values are counted once a defect

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

/// Whether two logs can be of one room: outdoor temperatures of the same hours agree (else refused), medians of rooms
/// differ by less than 5 K (else noted). Remarks go to `measured`.
bool same_room(const CleanLog& reference, CleanLog& measured, const CleanUpContext& context);

}  // namespace airside::tools::gap
