#pragma once
// What a person answers about a room and its AHU before a site is written: counts, bus, and where the signals are.

#include <istream>
#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "hal/points/stand_ins.hpp"
#include "hal/site/site_file.hpp"

namespace airside::tools {

/// Where a kind of signal is: the first one's register, and how the others follow.
struct SignalAnswer {
  std::optional<int> addr;  ///< of the first; none: as `airside init` without answers has it
  int apart = 0;            ///< registers from one to the next; 0: as many as the type has
  std::optional<int> fc;
  std::optional<std::string> type;
  std::optional<double> scale;
  bool is_absent = false;  ///< the AHU does not have it
};

/// Defaults are those of `airside init`. Units: degC.
struct InitAnswers {
  std::string name = "Room 301";
  int vavs = 5, fcus = 5, powers = 2;
  Objective objective = Objective::mean;
  double target_degc = 25.25, min_degc = 20, max_degc = 26, schedule_work_degc = 20.5, schedule_off_degc = 25;
  int work_start_s = 7 * 3600, work_end_s = 19 * 3600;
  hal::ModbusSection modbus;
  std::map<std::string, SignalAnswer> signals;  ///< by the point's name without its place

  std::string topology() const;
  /// Of the signals that are absent, a number that suits most sites.
  hal::StandIns stand_ins() const;
};

/// What `type` may be.
const std::vector<std::string>& point_types();

/// The names that `signals` may have, in the order in which they are asked.
const std::vector<std::string>& signal_names();

/// Reads answers.toml (docs/formats.md).
/// Errors: hal::InputError with file, line and key; unknown keys are errors too.
InitAnswers read_answers(const std::string& path);

/// Asks on a terminal, an empty line taking what is in brackets; a wrong answer is asked again.
/// Errors: hal::InputError where the input ends before the last answer.
InitAnswers ask_answers(std::istream& in, std::ostream& out);

/// As a file that read_answers() takes.
std::string text_of(const InitAnswers& answers);

/// The site file and the point map that follow.
/// Errors: hal::InputError for answers that contradict one another.
std::string site_text_of(const InitAnswers& answers);
std::string points_text_of(const InitAnswers& answers);

}  // namespace airside::tools
