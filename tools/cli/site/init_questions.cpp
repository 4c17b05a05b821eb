// The questions of airside init on a terminal.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <istream>
#include <optional>
#include <ostream>
#include <string>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "tools/cli/site/init_answers.hpp"

namespace airside::tools {

namespace {

std::optional<int> whole_of(const std::string& text) {
  int value = 0;
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  if (r.ec != std::errc{} || r.ptr != text.data() + text.size()) return {};
  return value;
}

/// Asks until an answer is one.
class Questions {
 public:
  Questions(std::istream& in, std::ostream& out) : in_(in), out_(out) {}

  void say(const std::string& text) { out_ << text << '\n'; }

  /// `take` returns what is wrong with an answer, "" where it was taken.
  void ask(const std::string& question, const std::string& otherwise,
           const std::function<std::string(const std::string&)>& take) {
    for (;;) {
      out_ << question << " [" << otherwise << "]: " << std::flush;
      std::string answer;
      if (!std::getline(in_, answer)) {
        throw hal::InputError("standard input", "its end", "an answer to: " + question,
                              "go on answering, or give --answers FILE; nothing was written");
      }
      while (!answer.empty() && (answer.back() == ' ' || answer.back() == '\r')) answer.pop_back();
      if (answer.empty()) answer = otherwise;
      const std::string wrong = take(answer);
      if (wrong.empty()) return;
      out_ << "  " << wrong << '\n';
    }
  }

  void whole(const std::string& question, int& value, int least, int most) {
    ask(question, std::to_string(value), [&](const std::string& answer) -> std::string {
      const auto given = whole_of(answer);
      if (!given || *given < least || *given > most) {
        return fmt::format("found '{}'; expected a whole number from {} to {}", answer, least, most);
      }
      value = *given;
      return "";
    });
  }
  void number(const std::string& question, double& value, double least, double most) {
    ask(question, fmt::format("{:g}", value), [&](const std::string& answer) -> std::string {
      double given = 0;
      const auto r = std::from_chars(answer.data(), answer.data() + answer.size(), given);
      if (r.ec != std::errc{} || r.ptr != answer.data() + answer.size() || !(given >= least && given <= most)) {
        return fmt::format("found '{}'; expected a number from {:g} to {:g}", answer, least, most);
      }
      value = given;
      return "";
    });
  }
  void time(const std::string& question, int& seconds) {
    ask(question, hal::clock_text(seconds), [&](const std::string& answer) -> std::string {
      const std::size_t colon = answer.find(':');
      const int h = whole_of(answer.substr(0, colon)).value_or(-1);
      const int m = colon == std::string::npos ? -1 : whole_of(answer.substr(colon + 1)).value_or(-1);
      if (h < 0 || h > 24 || m < 0 || m > 59) {
        return fmt::format("found '{}'; expected a time such as 07:00", answer);
      }
      seconds = h * 3600 + m * 60;
      return "";
    });
  }
  void text(const std::string& question, std::string& value, const std::string& example) {
    ask(question, value.empty() ? example : value, [&](const std::string& answer) -> std::string {
      if (answer.find_first_of("\"\\") != std::string::npos) return "no quotes and backslashes, please";
      value = answer;
      return "";
    });
  }
  /// Which of the words; returns its place.
  std::size_t choice(const std::string& question, const std::vector<std::string>& words) {
    std::size_t chosen = 0;
    ask(fmt::format("{} ({})", question, fmt::join(words, ", ")), words[0],
        [&](const std::string& answer) -> std::string {
          for (chosen = 0; chosen < words.size(); ++chosen) {
            if (words[chosen] == answer) return "";
          }
          return fmt::format("found '{}'; expected {}", answer, fmt::join(words, " or "));
        });
    return chosen;
  }

 private:
  std::istream& in_;
  std::ostream& out_;
};

struct Place {
  const char* name;
  const char* question;
  bool is_needed;
};

constexpr Place places[] = {
    {"room_temp", "room temperature 1", true},
    {"setpoint", "supply-air temperature setpoint", true},
    {"heartbeat", "register that the box counts up, so that the AHU notices when it is gone", false},
    {"vav_on", "VAV box 1 on or off", false},
    {"fcu_temp", "fan coil 1, air temperature", false},
    {"fcu_on", "fan coil 1 on or off", false},
    {"power", "power meter 1", false},
    {"supply_temp", "supply-air temperature", false},
    {"outdoor_temp", "outdoor temperature", false},
    {"mau_temp", "make-up air temperature", false},
    {"rain", "rain sensor", false},
    {"damper", "damper of box 1, 0 to 1", true},
    {"zone_setpoint", "cooling setpoint of zone 1", true},
    {"zone_heating_setpoint", "heating setpoint of zone 1", false},
    {"occupied", "whether people are there", false},
    {"supply_flow", "supply-air flow, m3/s", false},
    {"ahu_on", "whether the fan runs", false}};

bool is_asked(const std::string& name, const InitAnswers& a) {
  constexpr std::string_view of_band[] = {"damper",   "zone_setpoint", "zone_heating_setpoint",
                                          "occupied", "supply_flow",   "ahu_on"};
  if (std::ranges::find(of_band, name) != std::end(of_band)) return a.objective == Objective::band;
  if (name == "fcu_temp" || name == "fcu_on") return a.fcus > 0;
  return name != "power" || a.powers > 0;
}

/// `40`, `4:40`, `4:40:float32` or `4:40:int16:0.1`: function, register, type, scale; `-`: there is none.
std::string take_place(const std::string& answer, bool is_needed, SignalAnswer& out) {
  constexpr const char* form = "expected a register such as 40, or function:register:type:scale such as 4:40:int16:0.1";
  out = {};
  if (answer == "-") {
    out.is_absent = true;
    return is_needed ? "no site can do without it" : "";
  }
  if (answer == "as it is") return "";
  std::vector<std::string> parts(1);
  for (const char c : answer) {
    if (c == ':') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  if (parts.size() == 1) {
    out.addr = whole_of(parts[0]);
    return out.addr && *out.addr >= 0 && *out.addr <= 65535 ? "" : form;
  }
  out.fc = whole_of(parts[0]);
  out.addr = whole_of(parts[1]);
  if (!out.fc || !out.addr || *out.fc < 1 || *out.fc > 4 || *out.addr < 0 || *out.addr > 65535) return form;
  if (parts.size() > 2) {
    if (std::ranges::find(point_types(), parts[2]) == point_types().end()) {
      return fmt::format("found type '{}'; expected {}", parts[2], fmt::join(point_types(), ", "));
    }
    out.type = parts[2];
  }
  if (parts.size() > 3) {
    double scale = 0;
    const auto r = std::from_chars(parts[3].data(), parts[3].data() + parts[3].size(), scale);
    if (r.ec != std::errc{} || r.ptr != parts[3].data() + parts[3].size()) return form;
    out.scale = scale;
  }
  return parts.size() > 4 ? form : "";
}

}  // namespace

InitAnswers ask_answers(std::istream& in, std::ostream& out) {
  InitAnswers a;
  Questions q(in, out);
  q.say("Enter takes what is in brackets. Nothing is written before the last answer.");
  q.text("Name of the room or AHU", a.name, "AHU 1");
  q.whole("How many VAV boxes (zones with a temperature)", a.vavs, 1, 32);
  q.whole("How many fan coil units", a.fcus, 0, 32);
  q.whole("How many power meters", a.powers, 0, 8);
  a.objective = q.choice("Objective", {"mean", "band"}) == 0 ? Objective::mean : Objective::band;
  if (a.objective == Objective::band) {
    a.min_degc = 12;
    a.max_degc = 18;
    a.schedule_work_degc = a.schedule_off_degc = 14;
  } else {
    q.number("Room temperature to hold, degC", a.target_degc, 10, 35);
  }
  q.time("Working hours begin", a.work_start_s);
  q.time("Working hours end", a.work_end_s);
  q.number("Coldest supply-air setpoint that may be written, degC", a.min_degc, 5, 40);
  q.number("Warmest, degC", a.max_degc, 5, 40);
  q.number("Setpoint that the AHU has today in working hours, degC", a.schedule_work_degc, 5, 40);
  q.number("And outside of them, degC", a.schedule_off_degc, 5, 40);
  a.modbus.transport =
      q.choice("Modbus by", {"tcp", "rtu"}) == 0 ? hal::ModbusTransport::tcp : hal::ModbusTransport::rtu;
  if (a.modbus.transport == hal::ModbusTransport::tcp) {
    q.text("Address of the AHU's controller", a.modbus.host, "192.0.2.7");
    q.whole("Port", a.modbus.port, 1, 65535);
  } else {
    q.text("Serial line", a.modbus.device, "/dev/ttyUSB0");
    q.whole("Baud", a.modbus.baud, 300, 921600);
    a.modbus.parity = "ENO"[q.choice("Parity", {"E", "N", "O"})];
  }
  q.whole("Unit number", a.modbus.unit_id, 0, 247);
  q.say(
      "Where is each signal? A register counted from 0, or function:register:type:scale such as 4:40:int16:0.1;\n"
      "those of the same kind follow. '-': the AHU has none. 'as it is': the register of the example.");
  for (const Place& place : places) {
    if (!is_asked(place.name, a)) continue;
    SignalAnswer signal;
    q.ask(place.question, "as it is",
          [&](const std::string& answer) { return take_place(answer, place.is_needed, signal); });
    if (signal.is_absent || signal.addr) a.signals[place.name] = signal;
  }
  return a;
}

}  // namespace airside::tools
