#include "tools/cli/site/ask/register_answer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "hal/text/toml_section.hpp"
#include "tools/cli/site/ask/questions.hpp"

namespace airside::tools {

namespace {

constexpr const char* place_form =
    "expected a register such as 40, or function:register:type:scale:offset:order:apart, of which the end may be left "
    "out, such as 4:40:int16:0.1 or 3:10:float32:1:0:little";

bool is_one_of(const std::vector<std::string>& words, const std::string& word) {
  return std::ranges::find(words, word) != words.end();
}

bool is_wide_type(const std::optional<std::string>& type) { return type && type->ends_with("32"); }

/// Returns what is wrong.
std::string take_parts(const std::vector<std::string>& parts, std::string_view name, SignalAnswer& out) {
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
  if (!part(2).empty()) {
    if (std::string wrong = take_type(part(2), name, point_types(), out.type); !wrong.empty()) return wrong;
  }
  if (!said(3, out.scale, real_of(part(3))) || (out.scale && *out.scale == 0)) {
    return fmt::format("found scale '{}'; expected a number other than 0{}", part(3), hint_of_number(part(3)));
  }
  if (!said(4, out.offset, real_of(part(4)))) {
    return fmt::format("found offset '{}'; expected a number{}", part(4), hint_of_number(part(4)));
  }
  if (!part(5).empty()) {
    if (std::string wrong = take_word_order(part(5), out.word_order); !wrong.empty()) return wrong;
  }
  if (!said(6, out.apart, whole_of(part(6))) || (out.apart && (*out.apart < 0 || *out.apart > 1000))) {
    return fmt::format("found '{}' registers from one to the next; expected 0 to 1000", part(6));
  }
  return {};
}

}  // namespace

bool is_written_signal(std::string_view name) { return name == "setpoint" || name == "heartbeat"; }

std::string take_type(const std::string& answer, std::string_view name, const std::vector<std::string>& types,
                      std::optional<std::string>& type) {
  const std::string small = in_small_letters(answer);
  if (name == "heartbeat" && small == "int16") {
    return fmt::format("found type '{}'; expected one that counts to 65535; use uint16", answer);
  }
  if (is_one_of(types, small)) {
    type = small;
    return {};
  }
  std::string meant = hal::nearest_name(small, types);
  if (small == "float" || small == "real") meant = "float32";
  for (const char* bit : {"bool", "boolean", "bit"}) {
    if (small == bit) meant = "a coil (function 1)";
  }
  return fmt::format("found type '{}'; expected {}{}", answer, fmt::join(types, ", "),
                     meant.empty() ? "" : fmt::format("; did you mean {}?", meant));
}

std::string take_word_order(const std::string& answer, std::optional<std::string>& order) {
  const std::string small = in_small_letters(answer);
  if (small == "big" || small == "abcd") {
    order = "big";
  } else if (small == "little" || small == "cdab" || small == "swapped") {
    order = "little";
  } else if (small == "badc" || small == "dcba") {
    return fmt::format(
        "found word order '{}', whose bytes are swapped too; expected big or little: take {}, and write "
        "byte_order little in points.csv",
        answer, small == "badc" ? "big" : "little");
  } else {
    const std::string near = hal::nearest_name(small, {"big", "little"});
    return fmt::format("found word order '{}'; expected big (abcd, high word first) or little (cdab, swapped){}",
                       answer, near.empty() ? "" : fmt::format("; did you mean {}?", near));
  }
  return {};
}

std::string take_register(const std::string& answer, std::string_view name, SignalAnswer& out) {
  const std::vector<std::string> parts = parts_of(answer, ':');
  if (parts.size() == 1) {
    out.addr = whole_of(answer);
    if (out.addr && *out.addr >= 0 && *out.addr <= 65535) return {};
    return fmt::format("found '{}'; {}", answer, place_form);
  }
  if (std::string wrong = take_parts(parts, name, out); !wrong.empty()) return wrong;
  if (!is_written_signal(name) || !out.fc || *out.fc == 3) return {};
  return fmt::format("found function {}; expected 3 (holding registers), since {} is written", *out.fc, name);
}

std::string short_form(const SignalAnswer& whole, int count) {
  if (whole.is_absent) return "-";
  const bool is_bit = *whole.fc <= 2;
  std::string text = fmt::format(
      "{}:{}:{}:{}:{}:{}:{}", *whole.fc, *whole.addr, *whole.type, is_bit ? "" : fmt::format("{}", *whole.scale),
      is_bit || *whole.offset == 0 ? "" : fmt::format("{}", *whole.offset),
      is_wide_type(whole.type) ? *whole.word_order : "", count > 1 && whole.apart ? std::to_string(*whole.apart) : "");
  return text.erase(text.find_last_not_of(':') + 1);
}

std::string register_in_words(const SignalAnswer& whole, int count) {
  constexpr const char* kinds[] = {"coil", "discrete input", "holding register", "input register"};
  const bool is_bit = *whole.fc <= 2, is_wide = is_wide_type(whole.type);
  std::string text = fmt::format("{} {}", kinds[*whole.fc - 1], *whole.addr);
  if (!is_bit) text += fmt::format(", {}, scale {}, offset {}", *whole.type, *whole.scale, *whole.offset);
  if (is_wide) {
    text += *whole.word_order == "big" ? ", word order big (abcd, the high word first)"
                                       : ", word order little (cdab, the low word first)";
  }
  if (count < 2) return text;
  const int apart = whole.apart.value_or(0) > 0 ? *whole.apart : is_wide ? 2 : 1;
  return text + fmt::format("; {} of them, from one to the next {}", count, apart);
}

}  // namespace airside::tools
