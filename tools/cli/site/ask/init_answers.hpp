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

/// Where a kind of signal is: the first one's register or object, and how the others follow.
struct SignalAnswer {
  std::optional<int> addr;  ///< of the first; none: as `airside init` without answers has it
  /// From one to the next: registers, 0: as many as the type has; BACnet: object instances.
  std::optional<int> apart;
  std::optional<int> fc;
  std::optional<std::string> type;
  std::optional<double> scale, offset;
  std::optional<std::string> word_order;  ///< of a 32-bit type: big or little
  std::optional<std::string> object;      ///< BACnet, of the first: `1201:analog-input:3`
  int devices_apart = 0;                  ///< BACnet: device instances from one to the next
  bool is_absent = false;                 ///< the AHU does not have it

  bool is_said() const { return addr || object || is_absent; }
};

/// Defaults are those of `airside init`. Units: degC.
struct InitAnswers {
  std::string name = "Room 301";
  int vavs = 5, fcus = 5, powers = 2;
  Objective objective = Objective::mean;
  double target_degc = 25.25, min_degc = 20, max_degc = 26, schedule_work_degc = 20.5, schedule_off_degc = 25;
  int work_start_s = 7 * 3600, work_end_s = 19 * 3600;
  hal::ModbusSection modbus;                    ///< of a BACnet site: to the gateway on this machine
  std::optional<hal::BacnetSection> bacnet;     ///< there: the AHU speaks BACnet
  std::map<std::string, SignalAnswer> signals;  ///< by the point's name without its place

  std::string topology() const;
  /// How many of a kind of signal the site has; 1 where they are not counted.
  int count_of(const std::string& signal) const;
  bool is_absent(const std::string& signal) const;
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

/// The port of the gateway of BACnet, which needs no privileges.
constexpr int gateway_port = 1502;

/// The site file and the point map that follow. A signal whose place nobody has said keeps the register of `airside
/// init` without answers, or goes to the next free one; on BACnet it is absent. Errors: hal::InputError for answers
/// that contradict one another.
std::string site_text_of(const InitAnswers& answers);
std::string points_text_of(const InitAnswers& answers);

/// The signals of the point map whose place nobody has said.
std::vector<std::string> unsaid_signals(const InitAnswers& answers);

/// What is said of a signal, filled in from `airside init`: function, register, type, scale, offset, word order.
SignalAnswer whole_answer(const InitAnswers& answers, const std::string& signal);

/// What is wrong with the answers so far, in words; "" where nothing is. Of the site file: all but signals. Of the
/// rows: those of the signals that are said; of two that contradict one another `latest` is the one to correct.
std::string complaint_of_site(const InitAnswers& answers);
std::string complaint_of_rows(const InitAnswers& answers, const std::string& latest = "");

}  // namespace airside::tools
