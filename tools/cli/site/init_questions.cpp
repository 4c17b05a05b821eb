// The questions of airside init on a terminal.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "hal/text/civil_text.hpp"
#include "tools/cli/site/init_answers.hpp"
#include "tools/cli/site/questions.hpp"

namespace airside::tools {

namespace {

constexpr int day_s = 24 * 3600;
/// Setpoints in steps of 0.1 K that a controller can weigh.
constexpr double most_range_k = 19;

struct Place {
  const char* name;
  const char* question;
};

constexpr Place places[] = {{"room_temp", "room temperature 1"},
                            {"setpoint", "supply-air temperature setpoint"},
                            {"heartbeat", "what the box counts up, so that the AHU notices when it is gone"},
                            {"vav_on", "VAV box 1 on or off"},
                            {"fcu_temp", "fan coil 1, air temperature"},
                            {"fcu_on", "fan coil 1 on or off"},
                            {"power", "power meter 1, kW"},
                            {"supply_temp", "supply-air temperature"},
                            {"outdoor_temp", "outdoor temperature"},
                            {"mau_temp", "make-up air temperature"},
                            {"rain", "rain sensor"},
                            {"damper", "damper of box 1, 0 to 1"},
                            {"zone_setpoint", "cooling setpoint of zone 1"},
                            {"zone_heating_setpoint", "heating setpoint of zone 1"},
                            {"occupied", "whether people are there"},
                            {"supply_flow", "supply-air flow, m3/s"},
                            {"ahu_on", "whether the fan runs"}};

template <class Names>
bool is_in(const Names& names, std::string_view name) {
  return std::ranges::find(names, name) != std::end(names);
}

bool is_asked(std::string_view name, const InitAnswers& a) {
  constexpr std::string_view of_band[] = {"damper",   "zone_setpoint", "zone_heating_setpoint",
                                          "occupied", "supply_flow",   "ahu_on"};
  if (is_in(of_band, name)) return a.objective == Objective::band;
  return a.count_of(std::string(name)) > 0;
}

bool is_needed(std::string_view name, const InitAnswers& a) {
  constexpr std::string_view by_band[] = {"damper", "zone_setpoint", "supply_temp", "outdoor_temp", "power"};
  return name == "room_temp" || name == "setpoint" || (a.objective == Objective::band && is_in(by_band, name));
}

bool is_written(std::string_view name) { return name == "setpoint" || name == "heartbeat"; }

constexpr const char* place_form =
    "expected a register such as 40, or function:register:type:scale:offset:order:apart, of which the end may be left "
    "out, such as 4:40:int16:0.1 or 3:10:float32:1:0:little";

/// `4:40:int16:0.1:0:big:2`: function, register, type, scale, offset, word order, registers from one to the next; what
/// is empty or left out is as the example has it. Returns what is wrong.
std::string take_parts(const std::vector<std::string>& parts, SignalAnswer& out) {
  if (parts.size() > 7) return place_form;
  const auto part = [&](std::size_t i) { return i < parts.size() ? parts[i] : std::string(); };
  const auto said = [&](std::size_t i, auto& value, const auto& parsed) {
    if (part(i).empty()) return true;
    value = parsed;
    return parsed.has_value();
  };
  if (!said(0, out.fc, whole_of(part(0))) || (out.fc && (*out.fc < 1 || *out.fc > 4))) {
    return fmt::format(
        "found function '{}'; expected 1 (coils), 2 (discrete inputs), 3 (holding registers) or 4 (input registers)",
        part(0));
  }
  out.addr = whole_of(part(1));
  if (!out.addr || *out.addr < 0 || *out.addr > 65535) {
    return fmt::format("found register '{}'; expected a whole number from 0 to 65535; {}", part(1), place_form);
  }
  if (!part(2).empty()) out.type = part(2);
  if (out.type && !is_in(point_types(), *out.type)) {
    return fmt::format("found type '{}'; expected {}", *out.type, fmt::join(point_types(), ", "));
  }
  if (!said(3, out.scale, real_of(part(3))) || (out.scale && *out.scale == 0)) {
    return fmt::format("found scale '{}'; expected a number other than 0", part(3));
  }
  if (!said(4, out.offset, real_of(part(4)))) return fmt::format("found offset '{}'; expected a number", part(4));
  if (!part(5).empty()) out.word_order = part(5);
  if (out.word_order && *out.word_order != "big" && *out.word_order != "little") {
    return fmt::format("found word order '{}'; expected big (high word first) or little", *out.word_order);
  }
  if (!said(6, out.apart, whole_of(part(6))) || (out.apart && (*out.apart < 0 || *out.apart > 1000))) {
    return fmt::format("found '{}' registers from one to the next; expected 0 to 1000", part(6));
  }
  return {};
}

/// Of an answer on a Modbus site, and whether more is to be asked of it. Returns what is wrong.
std::string take_register(const std::string& answer, std::string_view name, SignalAnswer& out) {
  const std::vector<std::string> parts = parts_of(answer, ':');
  if (parts.size() == 1) {
    out.addr = whole_of(answer);
    if (out.addr && *out.addr >= 0 && *out.addr <= 65535) return {};
    return fmt::format("found '{}'; {}", answer, place_form);
  }
  if (std::string wrong = take_parts(parts, out); !wrong.empty()) return wrong;
  if (!is_written(name) || !out.fc || *out.fc == 3) return {};
  return fmt::format("found function {}; expected 3 (holding registers), since {} is written", *out.fc, name);
}

/// Asks one signal after the other; 'back' goes one back.
class SignalQuestions {
 public:
  SignalQuestions(Questions& q, InitAnswers& a) : q_(q), a_(a) {
    for (const Place& place : places) {
      if (is_asked(place.name, a)) asked_.push_back(&place);
    }
  }

  void ask_all() {
    for (std::size_t i = 0; i < asked_.size();) {
      if (ask_one(*asked_[i])) {
        ++i;
      } else if (i > 0) {
        --i;
      }
    }
  }

 private:
  /// Until an answer fits those before it; false: back.
  bool ask_one(const Place& place) {
    for (;;) {
      a_.signals.erase(place.name);
      SignalAnswer said;
      bool is_back = false;
      q_.ask(place.question, default_of(place.name),
             [&](const std::string& answer) { return take(answer, place.name, said, is_back); });
      if (is_back) return false;
      if (said.object) {
        ask_more_of_object(place.name, said);
      } else if (is_bare_) {
        ask_more_of_register(place.name, said);
      }
      if (said.is_said()) a_.signals[place.name] = said;
      const std::string wrong = complaint_of_rows(a_);
      if (wrong.empty()) return true;
      q_.say("  " + wrong);
    }
  }

  std::string default_of(std::string_view name) const {
    if (!a_.bacnet) return "as it is";
    if (name == "heartbeat") return "gateway";
    return is_needed(name, a_) ? "" : "-";
  }

  std::string take(const std::string& answer, std::string_view name, SignalAnswer& said, bool& is_back) {
    said = {};
    is_bare_ = false;
    is_back = answer == "back";
    if (is_back || (answer == "as it is" && !a_.bacnet)) return {};
    if (answer == "-") {
      said.is_absent = true;
      return is_needed(name, a_) ? "no site can do without it" : "";
    }
    if (!a_.bacnet) {
      is_bare_ = answer.find(':') == std::string::npos;
      return take_register(answer, name, said);
    }
    said.object = answer;
    return complaint_of(name, said);
  }

  /// Of an answer as far as it was given.
  std::string complaint_of(std::string_view name, const SignalAnswer& said) const {
    InitAnswers so_far = a_;
    so_far.signals[std::string(name)] = said;
    return complaint_of_rows(so_far);
  }

  void ask_more_of_register(const std::string& name, SignalAnswer& said) {
    const bool is_power = name == "power" || name == "supply_flow";
    const bool is_temperature = name == "setpoint" || name.ends_with("temp") || name.starts_with("zone_");
    int fc = 4, apart = 0;
    if (!is_written(name)) {
      q_.whole("  function (1 coils, 2 discrete inputs, 3 holding registers, 4 input registers)", fc, 1, 4);
      said.fc = fc;
      if (fc <= 2) said.type = fc == 1 ? "coil" : "discrete";
    }
    if (!said.type) {
      std::vector<std::string> types = {is_power ? "float32" : is_temperature ? "int16" : "uint16"};
      for (const char* type : {"int16", "uint16", "int32", "uint32", "float32"}) {
        if (type != types[0]) types.emplace_back(type);
      }
      q_.choice("  type", types, [&](std::size_t chosen) { said.type = types[chosen]; });
      ask_scale(said, said.type == "float32" ? 1 : is_temperature ? 0.01 : name == "damper" ? 0.0001 : 1);
    }
    const bool is_wide = said.type->ends_with("32");
    if (is_wide) {
      std::vector<std::string> orders = {"big", "little"};
      if (word_order_ == "little") std::swap(orders[0], orders[1]);
      q_.choice("  word order, big: the high word comes first", orders,
                [&](std::size_t chosen) { word_order_ = orders[chosen]; });
      said.word_order = word_order_;
    }
    if (a_.count_of(name) < 2) return;
    apart = is_wide ? 2 : 1;
    q_.whole("  registers from one to the next", apart, 1, 1000);
    said.apart = apart;
  }

  void ask_more_of_object(const std::string& name, SignalAnswer& said) {
    const bool is_state = said.object->find(":binary-") != std::string::npos;
    if (*said.object == "gateway") return;
    if (!is_state && name != "heartbeat") ask_scale(said, 1);
    if (a_.count_of(name) < 2) return;
    int apart = 1;
    q_.whole("  object instances from one to the next", apart, 0, 4194302);
    q_.whole("  device instances from one to the next, 0: all of one device", said.devices_apart, 0, 4194302);
    said.apart = apart;
  }

  void ask_scale(SignalAnswer& said, double scale) {
    double offset = 0;
    q_.ask("  scale, value = number * scale + offset", fmt::format("{}", scale),
           [&](const std::string& answer) -> std::string {
             const auto given = real_of(answer);
             if (!given || *given == 0 || std::abs(*given) > 1e6) {
               return fmt::format("found '{}'; expected a number other than 0, such as 0.1", answer);
             }
             scale = *given;
             return "";
           });
    q_.number("  offset", offset, -1e6, 1e6);
    said.scale = scale;
    if (offset != 0) said.offset = offset;
  }

  Questions& q_;
  InitAnswers& a_;
  std::vector<const Place*> asked_;
  bool is_bare_ = false;            ///< the register alone was said: the rest is to be asked
  std::string word_order_ = "big";  ///< as last said: a device has one, mostly
};

void ask_hours_and_limits(Questions& q, InitAnswers& a) {
  // The second of two moves ahead of the first where it would contradict it: it is still to be asked.
  q.ask("Working hours begin", hal::clock_text(a.work_start_s), [&](const std::string& answer) {
    InitAnswers so_far = a;
    const auto given = time_of(answer);
    if (!given || *given >= day_s) return fmt::format("found '{}'; expected a time such as 07:00", answer);
    if (so_far.work_end_s <= *given) so_far.work_end_s = day_s;
    so_far.work_start_s = *given;
    std::string wrong = complaint_of_site(so_far);
    if (wrong.empty()) a = so_far;
    return wrong;
  });
  q.time("Working hours end", a.work_end_s);
  q.ask("Coldest supply-air setpoint that may be written, degC", fmt::format("{}", a.min_degc),
        [&](const std::string& answer) {
          InitAnswers so_far = a;
          const auto given = real_of(answer);
          if (!given || *given < 5 || *given >= 40) {
            return fmt::format("found '{}'; expected a number from 5 to below 40", answer);
          }
          if (so_far.max_degc <= *given) so_far.max_degc = std::min(40.0, *given + 6);
          so_far.min_degc = *given;
          if (so_far.max_degc - so_far.min_degc > most_range_k) so_far.max_degc = so_far.min_degc + most_range_k;
          std::string wrong = complaint_of_site(so_far);
          if (wrong.empty()) a = so_far;
          return wrong;
        });
  q.number("Warmest, degC", a.max_degc, 5, 40);
  const auto schedule = [&](const char* question, double& degc) {
    degc = std::clamp(degc, a.min_degc, a.max_degc);
    q.number(question, degc, 5, 40);
    if (degc >= a.min_degc && degc <= a.max_degc) return;
    q.say(fmt::format("  note: {:g} is outside {:g} to {:g}: the schedule will be held at that limit", degc, a.min_degc,
                      a.max_degc));
  };
  schedule("Setpoint that the AHU has today in working hours, degC", a.schedule_work_degc);
  schedule("And outside of them, degC", a.schedule_off_degc);
}

void ask_room(Questions& q, InitAnswers& a) {
  a.name = "AHU 1";
  q.text("Name of the room or AHU", a.name, "");
  q.whole("How many VAV boxes (zones with a temperature)", a.vavs, 1, 32);
  q.whole("How many fan coil units", a.fcus, 0, 32);
  q.whole("How many power meters", a.powers, 0, 8);
  q.ask("Objective (mean: hold the mean room temperature, band: boxes modulate, least energy)", "mean",
        [&](const std::string& answer) -> std::string {
          if (answer != "mean" && answer != "band") return fmt::format("found '{}'; expected mean or band", answer);
          if (answer == "band" && a.powers == 0) {
            return "found band without a power meter; expected one, from which band learns energy: take mean, or begin "
                   "anew with a meter";
          }
          a.objective = answer == "band" ? Objective::band : Objective::mean;
          return "";
        });
  if (a.objective == Objective::band) {
    a.min_degc = 12;
    a.max_degc = 18;
    a.schedule_work_degc = a.schedule_off_degc = 14;
  } else {
    q.number("Room temperature to hold, degC", a.target_degc, 10, 35);
  }
  ask_hours_and_limits(q, a);
}

/// First of the bus: what it is. Then how it is reached.
void ask_bus(Questions& q, InitAnswers& a) {
  bool is_bacnet = false, is_rtu = false;
  q.choice("Bus of the AHU, tcp and rtu: Modbus", {"tcp", "rtu", "bacnet"},
           [&](std::size_t chosen) { is_rtu = chosen == 1, is_bacnet = chosen == 2; });
  hal::ModbusSection& m = a.modbus;
  if (is_bacnet) {
    hal::BacnetSection b;
    m.host = "127.0.0.1";
    m.port = gateway_port;
    q.ask("This machine's address in the devices' network, with the length of its prefix, such as 192.168.1.30/24", "",
          [&](const std::string& answer) {
            InitAnswers so_far = a;
            b.address = answer;
            so_far.bacnet = b;
            return complaint_of_site(so_far);
          });
    a.bacnet = b;
    q.whole("UDP port of BACnet", a.bacnet->port, 1, 65535);
    q.whole("Priority at which the setpoint is commanded", a.bacnet->priority, 8, 16);
    q.ask("Devices that Who-Is does not find, such as 1201@192.168.2.50 1305@2001:5", "none",
          [&](const std::string& answer) {
            InitAnswers so_far = a;
            so_far.bacnet->devices = answer == "none" ? std::vector<std::string>{} : parts_of(answer, ' ');
            std::string wrong = complaint_of_site(so_far);
            if (wrong.empty()) a.bacnet->devices = so_far.bacnet->devices;
            return wrong;
          });
    q.whole("Port of the gateway on this machine", m.port, 1, 65535);
    return;
  }
  m.transport = is_rtu ? hal::ModbusTransport::rtu : hal::ModbusTransport::tcp;
  if (is_rtu) {
    m.device = "/dev/ttyUSB0";
    q.text("Serial line", m.device, "");
    q.whole("Baud", m.baud, 1200, 921600);
    q.choice("Parity", {"E", "N", "O"}, [&](std::size_t chosen) { m.parity = "ENO"[chosen]; });
  } else {
    q.text("Address of the AHU's controller", m.host, "192.168.1.20");
    q.whole("Port", m.port, 1, 65535);
  }
  q.whole("Unit number", m.unit_id, is_rtu ? 1 : 0, 247);
}

}  // namespace

InitAnswers ask_answers(std::istream& in, std::ostream& out) {
  InitAnswers a;
  Questions q(in, out, [&] { return complaint_of_site(a); });
  q.say("Enter takes what is in brackets. Nothing is written before the last answer.");
  ask_room(q, a);
  ask_bus(q, a);
  if (a.bacnet) {
    q.say(
        "Which object is each signal? DEVICE:TYPE:INSTANCE such as 1201:analog-input:3; `airside-bacnet --discover` "
        "lists\n"
        "them. '-': the AHU has none. 'back': the one before.");
  } else {
    q.say(
        "Where is each signal? A register counted from 0, or function:register:type:scale:offset:order:apart such as\n"
        "4:40:int16:0.1; those of the same kind follow. '-': the AHU has none. 'as it is': a made-up register, that "
        "of\n"
        "the example. 'back': the signal before.");
  }
  SignalQuestions(q, a).ask_all();
  return a;
}

}  // namespace airside::tools
