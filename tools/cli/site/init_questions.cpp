// The questions of airside init on a terminal.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>

#include "hal/modbus/baud_rates.hpp"
#include "hal/text/civil_text.hpp"
#include "tools/cli/site/ask/init_answers.hpp"
#include "tools/cli/site/ask/questions.hpp"
#include "tools/cli/site/ask/signal_questions.hpp"

namespace airside::tools {

namespace {

constexpr int day_s = 24 * 3600;
/// Setpoints in steps of 0.1 K that a controller can weigh.
constexpr double most_range_k = 19;

/// The words with the one that was chosen before first.
std::vector<std::string> with_first(std::vector<std::string> words, const std::string& chosen) {
  std::stable_partition(words.begin(), words.end(), [&](const std::string& word) { return word == chosen; });
  return words;
}

/// Each question is a step; 'back' goes to the one that was asked before.
class SiteQuestions {
 public:
  SiteQuestions(Questions& q, InitAnswers& a) : q_(q), a_(a) {
    a_.name = "AHU 1";
    add_room();
    add_hours();
    add_limits();
    add_bus();
    always([this] { ask_where(); });
  }

  void ask_all() {
    std::vector<std::size_t> asked;
    for (std::size_t i = 0; i < steps_.size();) {
      try {
        if (!steps_[i].applies || steps_[i].applies()) {
          steps_[i].ask();
          asked.push_back(i);
        }
        ++i;
      } catch (const Back&) {
        if (asked.empty()) {
          q_.say("  this is the first question");
          continue;
        }
        i = asked.back();
        asked.pop_back();
      }
    }
  }

 private:
  struct Step {
    std::function<bool()> applies;  ///< empty: always
    std::function<void()> ask;
  };

  void always(std::function<void()> ask) { steps_.push_back({{}, std::move(ask)}); }
  void where(std::function<bool()> applies, std::function<void()> ask) {
    steps_.push_back({std::move(applies), std::move(ask)});
  }

  void add_room() {
    always([this] {
      q_.text("Name of the room or AHU", a_.name, "",
              "as people call it, for the operator's page and reports; any text without quotes");
    });
    always([this] {
      q_.whole("How many VAV boxes (zones with a temperature)", a_.vavs, 1, 32,
               "one each room temperature that the AHU's boxes control: the network's inputs are as many");
    });
    always([this] {
      q_.whole("How many fan coil units", a_.fcus, 0, 32,
               "those whose supply temperature and state the AHU's controller shows; 0: none, or not seen");
    });
    always([this] {
      q_.whole("How many power meters", a_.powers, 0, 8,
               "electrical power of the AHU, its chiller, its fans: each that the bus shows; 0: none");
    });
    always([this] { ask_objective(); });
    where([this] { return a_.objective == Objective::mean; },
          [this] {
            q_.number("Room temperature to hold, degC", a_.target_degc, 10, 35,
                      "in working hours, the mean of all rooms");
          });
  }

  void ask_objective() {
    const Objective before = a_.objective;
    const bool may_be_band = a_.powers > 0;
    q_.ask(
        "Objective (mean: hold the mean room temperature, band: boxes modulate, least energy)",
        before == Objective::band && may_be_band ? "band" : "mean",
        [&](const std::string& typed) -> std::string {
          const std::string answer = in_small_letters(typed);
          if (answer != "mean" && answer != "band") return fmt::format("found '{}'; expected mean or band", typed);
          if (answer == "band" && !may_be_band) {
            return "found band without a power meter; expected one, from which band learns energy: take mean, or go "
                   "back and add a meter";
          }
          a_.objective = answer == "band" ? Objective::band : Objective::mean;
          return "";
        },
        "mean: boxes open or shut, the setpoint brings the mean of the rooms to a target; band: boxes that modulate "
        "hold their rooms, the setpoint is moved to what costs least energy; mean or band");
    if (a_.objective == before) return;
    const bool is_band = a_.objective == Objective::band;
    const InitAnswers usual;
    a_.min_degc = is_band ? 12 : usual.min_degc;
    a_.max_degc = is_band ? 18 : usual.max_degc;
    a_.schedule_work_degc = is_band ? 14 : usual.schedule_work_degc;
    a_.schedule_off_degc = is_band ? 14 : usual.schedule_off_degc;
    said_.clear();
  }

  /// The second of two moves ahead of the first where it would contradict it: it is still to be asked.
  void add_hours() {
    always([this] {
      q_.ask(
          "Working hours begin", hal::clock_text(a_.work_start_s),
          [&](const std::string& answer) {
            InitAnswers so_far = a_;
            const auto given = time_of(answer);
            if (!given || *given >= day_s) return fmt::format("found '{}'; expected a time such as 07:00", answer);
            if (so_far.work_end_s <= *given) so_far.work_end_s = day_s;
            so_far.work_start_s = *given;
            return keep(so_far);
          },
          "when people come: the target holds from here on; a time such as 07:00");
    });
    always([this] {
      q_.ask(
          "Working hours end", hal::clock_text(a_.work_end_s),
          [&](const std::string& answer) {
            const auto given = time_of(answer);
            if (!given) return fmt::format("found '{}'; expected a time such as 19:00, to 24:00", answer);
            if (*given <= a_.work_start_s) {
              return fmt::format(
                  "found {}; the end must be after the beginning, {}; 'back' asks for the beginning again",
                  hal::clock_text(*given), hal::clock_text(a_.work_start_s));
            }
            InitAnswers so_far = a_;
            so_far.work_end_s = *given;
            return keep(so_far);
          },
          "when they leave: from here on the schedule's setpoint holds; a time such as 19:00");
    });
  }

  void add_limits() {
    always([this] {
      q_.ask(
          "Coldest supply-air setpoint that may be written, degC", fmt::format("{}", a_.min_degc),
          [&](const std::string& answer) { return take_coldest(answer); },
          "nothing colder is ever written: what coil, ducts and people bear; a number from 5 to below 40");
    });
    always([this] {
      q_.ask(
          "Warmest, degC", fmt::format("{}", a_.max_degc),
          [&](const std::string& answer) { return take_warmest(answer); },
          "nothing warmer is ever written; a number above the coldest, at most 40");
    });
    always([this] { ask_schedule("Setpoint that the AHU has today in working hours, degC", a_.schedule_work_degc); });
    always([this] { ask_schedule("And outside of them, degC", a_.schedule_off_degc); });
  }

  std::string take_coldest(const std::string& answer) {
    InitAnswers so_far = a_;
    const auto given = real_of(answer);
    if (!given || *given < 5 || *given >= 40) {
      return fmt::format("found '{}'; expected a number from 5 to below 40{}", answer, hint_of_number(answer));
    }
    if (so_far.max_degc <= *given) so_far.max_degc = std::min(40.0, *given + 6);
    so_far.min_degc = *given;
    if (so_far.max_degc - so_far.min_degc > most_range_k) so_far.max_degc = so_far.min_degc + most_range_k;
    return keep(so_far);
  }

  std::string take_warmest(const std::string& answer) {
    InitAnswers so_far = a_;
    const auto given = real_of(answer);
    if (!given || *given < 5 || *given > 40) {
      return fmt::format("found '{}'; expected a number from 5 to 40{}", answer, hint_of_number(answer));
    }
    if (*given <= a_.min_degc) {
      return fmt::format("found {:g}; warmest must be above coldest ({:g}); 'back' asks for the coldest again", *given,
                         a_.min_degc);
    }
    so_far.max_degc = *given;
    return keep(so_far);
  }

  /// Returns what is wrong with the answers so far, and takes them where nothing is.
  std::string keep(const InitAnswers& so_far) {
    std::string wrong = complaint_of_site(so_far);
    if (wrong.empty()) a_ = so_far;
    return wrong;
  }

  void ask_schedule(const char* question, double& degc) {
    if (!said_.contains(&degc)) degc = std::clamp(degc, a_.min_degc, a_.max_degc);
    q_.number(question, degc, 5, 40,
              "what the AHU does without airside: it is held wherever the controller is unsure or off");
    said_.insert(&degc);
    if (degc >= a_.min_degc && degc <= a_.max_degc) return;
    q_.say(fmt::format("  note: {:g} is outside {:g} to {:g}: the schedule will be held at that limit", degc,
                       a_.min_degc, a_.max_degc));
  }

  /// First of the bus: what it is. Then how it is reached.
  void add_bus() {
    const auto is_bacnet = [this] { return bus_ == "bacnet"; };
    const auto is_rtu = [this] { return bus_ == "rtu"; };
    const auto is_tcp = [this] { return bus_ == "tcp"; };
    const auto is_modbus = [this] { return bus_ != "bacnet"; };
    hal::ModbusSection& m = a_.modbus;
    always([this] { ask_kind_of_bus(); });
    where(is_bacnet, [this] { ask_bacnet_address(); });
    where(is_bacnet, [this] { q_.whole("UDP port of BACnet", a_.bacnet->port, 1, 65535); });
    where(is_bacnet, [this] { q_.whole("Priority at which the setpoint is commanded", a_.bacnet->priority, 8, 16); });
    where(is_bacnet, [this] { ask_bacnet_devices(); });
    where(is_bacnet, [this, &m] { q_.whole("Port of the gateway on this machine", m.port, 1, 65535); });
    where(is_rtu, [this] { ask_serial_line(); });
    where(is_rtu, [this] { ask_baud(); });
    where(is_rtu, [this, &m] {
      const std::vector<std::string> parities = with_first({"E", "N", "O"}, std::string(1, m.parity));
      q_.choice("Parity", parities, [&](std::size_t chosen) { m.parity = parities[chosen][0]; });
    });
    where(is_tcp, [this, &m] {
      q_.text("Address of the AHU's controller", m.host, "192.168.1.20",
              "its IP address or host name, without port; it is in the controller's network settings");
    });
    where(is_tcp, [this, &m] { q_.whole("Port", m.port, 1, 65535, "most devices have 502"); });
    where(is_modbus, [this, &m] {
      q_.whole("Unit number", m.unit_id, bus_ == "rtu" ? 1 : 0, 247,
               "the device's own number on the bus; over TCP most answer to 1 or to any");
    });
  }

  void ask_kind_of_bus() {
    const std::vector<std::string> kinds = with_first({"tcp", "rtu", "bacnet"}, bus_);
    const std::string before = bus_;
    q_.choice(
        "Bus of the AHU, tcp and rtu: Modbus", kinds, [&](std::size_t chosen) { bus_ = kinds[chosen]; },
        "tcp: Modbus over Ethernet; rtu: Modbus on a serial line; bacnet: through the gateway airside-bacnet");
    if (bus_ == before) return;
    if (before == "bacnet" || bus_ == "bacnet") former_.clear();
    a_.modbus = {};
    a_.bacnet.reset();
    if (bus_ == "rtu") {
      a_.modbus.transport = hal::ModbusTransport::rtu;
      a_.modbus.device = "/dev/ttyUSB0";
    } else if (bus_ == "bacnet") {
      a_.modbus.host = "127.0.0.1";
      a_.modbus.port = gateway_port;
    }
  }

  void ask_serial_line() {
    q_.ask(
        "Serial line", a_.modbus.device,
        [&](const std::string& answer) {
          InitAnswers so_far = a_;
          const bool is_bare = answer.find('/') == std::string::npos;
          so_far.modbus.device = is_bare ? "/dev/" + answer : answer;
          std::string wrong = keep(so_far);
          if (wrong.empty() && is_bare) q_.say("  taken: " + a_.modbus.device);
          return wrong;
        },
        "the line's device file; `ls /dev/serial/by-id` shows what is plugged in");
  }

  void ask_baud() {
    q_.ask("Baud", std::to_string(a_.modbus.baud), [&](const std::string& answer) -> std::string {
      const auto given = whole_of(answer);
      if (!given || std::ranges::find(hal::baud_rates, *given) == hal::baud_rates.end()) {
        return fmt::format("found '{}'; expected one of {}", answer, fmt::join(hal::baud_rates, ", "));
      }
      a_.modbus.baud = *given;
      return "";
    });
  }

  void ask_bacnet_address() {
    hal::BacnetSection b = a_.bacnet.value_or(hal::BacnetSection{});
    q_.ask(
        "This machine's address in the devices' network, with the length of its prefix, such as 192.168.1.30/24",
        b.address,
        [&](const std::string& answer) {
          InitAnswers so_far = a_;
          b.address = answer;
          so_far.bacnet = b;
          return keep(so_far);
        },
        "broadcasts need the prefix; `ip -4 address` shows both, such as 192.168.1.30/24");
  }

  void ask_bacnet_devices() {
    const std::vector<std::string>& devices = a_.bacnet->devices;
    q_.ask(
        "Devices that Who-Is does not find, such as 1201@192.168.2.50 1305@2001:5",
        devices.empty() ? "none" : fmt::format("{}", fmt::join(devices, " ")),
        [&](const std::string& answer) {
          InitAnswers so_far = a_;
          so_far.bacnet->devices = answer == "none" ? std::vector<std::string>{} : parts_of(answer, ' ');
          return keep(so_far);
        },
        "devices behind a router, DEVICE@ADDRESS with blanks between; none where all are in this network");
  }

  void ask_where() {
    if (a_.bacnet) {
      q_.say(
          "Which object is each signal? DEVICE:TYPE:INSTANCE such as 1201:analog-input:3; `airside-bacnet --discover` "
          "lists\n"
          "them. '-': the AHU has none.");
    } else {
      q_.say(
          "Where is each signal? A register counted from 0, or function:register:type:scale:offset:order:apart such "
          "as\n"
          "4:40:int16:0.1; those of the same kind follow. '-': the AHU has none. 'as it is': a made-up register, that "
          "of\n"
          "the example.");
    }
    ask_signals(q_, a_, former_);
  }

  Questions& q_;
  InitAnswers& a_;
  std::vector<Step> steps_;
  std::set<const double*> said_;  ///< setpoints of the schedule that were answered
  std::string bus_ = "tcp";
  std::map<std::string, SignalAnswer> former_;
};

}  // namespace

InitAnswers ask_answers(std::istream& in, std::ostream& out) {
  InitAnswers a;
  Questions q(in, out, [&] { return complaint_of_site(a); });
  q.say(
      "Enter takes what is in brackets, '?' explains, 'back' goes one question back. Nothing is written before the "
      "last answer.");
  SiteQuestions(q, a).ask_all();
  return a;
}

}  // namespace airside::tools
