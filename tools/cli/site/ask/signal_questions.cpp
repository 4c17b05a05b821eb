#include "tools/cli/site/ask/signal_questions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tools/cli/site/ask/register_answer.hpp"
#include "tools/cli/site/ask/vendor_numbers.hpp"

namespace airside::tools {

namespace {

constexpr const char* word_for_made_up = "as it is";

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

/// Asks one signal after the other; 'back' goes one back.
class SignalQuestions {
 public:
  SignalQuestions(Questions& q, InitAnswers& a, std::map<std::string, SignalAnswer>& former)
      : q_(q), a_(a), former_(former) {
    for (const Place& place : places) {
      if (is_asked(place.name, a)) asked_.push_back(&place);
    }
  }

  void ask_all() {
    for (std::size_t i = 0; i < asked_.size();) {
      try {
        ask_one(*asked_[i]);
        ++i;
      } catch (const Back&) {
        if (i == 0) throw;
        --i;
      }
    }
  }

 private:
  /// Until an answer fits those before it.
  void ask_one(const Place& place) {
    const std::string name = place.name;
    for (;;) {
      a_.signals.erase(name);
      SignalAnswer said;
      q_.ask(
          place.question, default_of(name), [&](const std::string& answer) { return take(answer, name, said); },
          a_.bacnet ? "an object, DEVICE:TYPE:INSTANCE such as 1201:analog-input:3; - where the AHU has none"
                    : "a register, counted from 0, such as 40: the rest is then asked; or all at once, "
                      "function:register:type:scale:offset:order:apart such as 4:40:int16:0.1; - where the AHU has "
                      "none; as it is: a made-up register");
      try {
        ask_more(name, said);
      } catch (const Back&) {
        continue;
      }
      if (said.is_said()) a_.signals[name] = said;
      const std::string wrong = complaint_of_rows(a_, name);
      if (wrong.empty()) {
        q_.say("  taken: " + in_words(name, said));
        former_[name] = said;
        return;
      }
      q_.say("  " + wrong);
    }
  }

  void ask_more(const std::string& name, SignalAnswer& said) {
    if (said.object) return ask_more_of_object(name, said);
    if (!said.addr) return;
    const std::optional<int> function = ask_vendor_number(name, said);
    if (is_bare_) ask_more_of_register(name, said, function);
  }

  std::string in_words(const std::string& name, const SignalAnswer& said) const {
    if (said.is_absent) return "none";
    if (said.addr) return register_in_words(whole_answer(a_, name), a_.count_of(name));
    if (!said.object) return "a made-up register, that of the example";
    if (*said.object == "gateway") return "the gateway's own";
    std::string text =
        fmt::format("{}, scale {}, offset {}", *said.object, said.scale.value_or(1), said.offset.value_or(0));
    if (a_.count_of(name) < 2) return text;
    return text + fmt::format("; {} of them, from one to the next {} (device {})", a_.count_of(name),
                              said.apart.value_or(1), said.devices_apart);
  }

  const SignalAnswer* former_of(const std::string& name) const {
    const auto found = former_.find(name);
    return found == former_.end() ? nullptr : &found->second;
  }

  /// The former answer, in the form in which it can be typed.
  std::string default_of(const std::string& name) const {
    if (const SignalAnswer* former = former_of(name)) {
      if (former->is_absent) return "-";
      if (former->object) return *former->object;
      if (!former->addr) return word_for_made_up;
      InitAnswers with = a_;
      with.signals[name] = *former;
      return short_form(whole_answer(with, name), a_.count_of(name));
    }
    if (name == "heartbeat") return a_.bacnet ? "gateway" : "-";
    if (!a_.bacnet && name != "setpoint") return word_for_made_up;
    return is_needed(name, a_) ? "" : "-";
  }

  std::string take(const std::string& answer, const std::string& name, SignalAnswer& said) {
    said = {};
    is_bare_ = false;
    if (answer == word_for_made_up && !a_.bacnet) return {};
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
  std::string complaint_of(const std::string& name, const SignalAnswer& said) const {
    InitAnswers so_far = a_;
    so_far.signals[name] = said;
    return complaint_of_rows(so_far, name);
  }

  /// A number of a vendor's table, such as 40031, is offered as the register that it usually is. Returns the function
  /// that belongs to it where that was taken.
  std::optional<int> ask_vendor_number(const std::string& name, SignalAnswer& said) {
    const auto numbers = vendor_numbers_of(*said.addr);
    const SignalAnswer* former = former_of(name);
    if (!numbers || (former != nullptr && former->addr == said.addr)) return {};
    const int meant = *said.addr - numbers->first;
    q_.say(fmt::format("  {}; {} would be register {} of function {}", numbers->in_words(), *said.addr, meant,
                       numbers->fc));
    int addr = meant;
    q_.whole(fmt::format("  register, counted from 0 ({} if it is really meant)", *said.addr), addr, 0, 65535);
    said.addr = addr;
    if (addr != meant || (is_written_signal(name) && numbers->fc != 3)) return {};
    if (!is_bare_) said.fc = numbers->fc;
    return numbers->fc;
  }

  void ask_more_of_register(const std::string& name, SignalAnswer& said, std::optional<int> function) {
    const SignalAnswer* former = former_of(name);
    const bool is_power = name == "power" || name == "supply_flow";
    const bool is_temperature = name == "setpoint" || name.ends_with("temp") || name.starts_with("zone_");
    int fc = function ? *function : former != nullptr && former->fc ? *former->fc : 4, apart = 0;
    if (!is_written_signal(name)) {
      q_.whole("  function (1 coils, 2 discrete inputs, 3 holding registers, 4 input registers)", fc, 1, 4);
      said.fc = fc;
      if (fc <= 2) said.type = fc == 1 ? "coil" : "discrete";
    }
    if (!said.type) {
      std::string usual = is_power ? "float32" : is_temperature ? "int16" : "uint16";
      if (former != nullptr && former->type && is_in(register_types(), *former->type)) usual = *former->type;
      q_.ask(fmt::format("  type ({})", fmt::join(register_types(), ", ")), usual,
             [&](const std::string& answer) { return take_type(answer, name, register_types(), said.type); });
      ask_scale(said, said.type == "float32" ? 1 : is_temperature ? 0.01 : name == "damper" ? 0.0001 : 1, former);
    }
    const bool is_wide = said.type->ends_with("32");
    if (is_wide) {
      const std::string usual = former != nullptr && former->word_order ? *former->word_order : word_order_;
      q_.ask("  word order, big: the high word comes first (big, little)", usual,
             [&](const std::string& answer) { return take_word_order(answer, said.word_order); });
      word_order_ = *said.word_order;
    }
    if (a_.count_of(name) < 2) return;
    apart = former != nullptr && former->apart.value_or(0) > 0 ? *former->apart : is_wide ? 2 : 1;
    q_.whole("  registers from one to the next", apart, 1, 1000);
    said.apart = apart;
  }

  static const std::vector<std::string>& register_types() {
    static const std::vector<std::string> types = {"int16", "uint16", "int32", "uint32", "float32"};
    return types;
  }

  void ask_more_of_object(const std::string& name, SignalAnswer& said) {
    const SignalAnswer* former = former_of(name);
    const bool is_state = said.object->find(":binary-") != std::string::npos;
    if (*said.object == "gateway") return;
    if (!is_state && name != "heartbeat") ask_scale(said, 1, former);
    if (a_.count_of(name) < 2) return;
    int apart = former != nullptr ? former->apart.value_or(1) : 1;
    if (former != nullptr) said.devices_apart = former->devices_apart;
    q_.whole("  object instances from one to the next", apart, 0, 4194302);
    q_.whole("  device instances from one to the next, 0: all of one device", said.devices_apart, 0, 4194302);
    said.apart = apart;
  }

  void ask_scale(SignalAnswer& said, double scale, const SignalAnswer* former) {
    double offset = 0;
    if (former != nullptr && former->scale) {
      scale = *former->scale;
      offset = former->offset.value_or(0);
    }
    q_.ask("  scale, value = number * scale + offset", fmt::format("{}", scale),
           [&](const std::string& answer) -> std::string {
             const auto given = real_of(answer);
             if (!given || *given == 0 || std::abs(*given) > 1e6) {
               return fmt::format("found '{}'; expected a number other than 0, such as 0.1{}", answer,
                                  hint_of_number(answer));
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
  std::map<std::string, SignalAnswer>& former_;
  std::vector<const Place*> asked_;
  bool is_bare_ = false;            ///< the register alone was said: the rest is to be asked
  std::string word_order_ = "big";  ///< as last said: a device has one, mostly
};

}  // namespace

void ask_signals(Questions& questions, InitAnswers& answers, std::map<std::string, SignalAnswer>& former) {
  answers.signals.clear();
  SignalQuestions(questions, answers, former).ask_all();
}

}  // namespace airside::tools
