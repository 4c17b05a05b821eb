#include "tools/cli/site/ask/questions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/toml_section.hpp"

namespace airside::tools {

std::optional<int> whole_of(const std::string& text) {
  int value = 0;
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  if (r.ec != std::errc{} || r.ptr != text.data() + text.size()) return {};
  return value;
}

std::optional<double> real_of(const std::string& text) {
  double value = 0;
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  if (r.ec != std::errc{} || r.ptr != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

std::optional<int> time_of(const std::string& text) {
  return hal::parse_time_of_day(text.find(':') == 1 ? "0" + text : text);
}

std::string in_small_letters(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string hint_of_number(const std::string& text) {
  if (text.find(',') != std::string::npos) return "; write the decimal mark as a point";
  const std::vector<std::string> parts = parts_of(text, '/');
  if (parts.size() != 2) return {};
  const auto over = real_of(parts[0]), under = real_of(parts[1]);
  if (!over || !under || *under == 0) return {};
  return fmt::format("; write the fraction as a decimal number: {:.10g}", *over / *under);
}

std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

void Questions::ask(const std::string& question, const std::string& otherwise,
                    const std::function<std::string(const std::string&)>& take, const std::string& help) {
  for (;;) {
    out_ << question << (otherwise.empty() ? "" : " [" + otherwise + "]") << ": " << std::flush;
    std::string answer;
    if (!std::getline(in_, answer)) {
      out_ << '\n' << std::flush;
      throw hal::InputError("standard input", "its end", "an answer to: " + question,
                            "go on answering, or give --answers FILE; nothing was written");
    }
    constexpr const char* blank = " \t\r";
    answer.erase(0, std::min(answer.find_first_not_of(blank), answer.size()));
    answer.erase(answer.find_last_not_of(blank) + 1);
    if (answer == "back") throw Back{};
    if (answer == "?" || in_small_letters(answer) == "help") {
      const std::string about = help.empty() ? take("?") : help;
      const std::size_t found = about.find("; ");
      out_ << "  " << (help.empty() && found != std::string::npos ? about.substr(found + 2) : about) << '\n';
      continue;
    }
    if (answer.empty()) answer = otherwise;
    const std::string wrong = answer.empty() ? "found nothing; expected an answer: there is no default" : take(answer);
    if (wrong.empty()) return;
    out_ << "  " << wrong << '\n';
  }
}

void Questions::whole(const std::string& question, int& value, int least, int most, const std::string& help) {
  ask(
      question, std::to_string(value),
      [&](const std::string& answer) -> std::string {
        const auto given = whole_of(answer);
        if (!given || *given < least || *given > most) {
          return fmt::format("found '{}'; expected a whole number from {} to {}", answer, least, most);
        }
        return try_value(value, *given);
      },
      help.empty() ? help : fmt::format("{}; a whole number from {} to {}", help, least, most));
}

void Questions::number(const std::string& question, double& value, double least, double most, const std::string& help) {
  ask(
      question, fmt::format("{}", value),
      [&](const std::string& answer) -> std::string {
        const auto given = real_of(answer);
        if (!given || *given < least || *given > most) {
          return fmt::format("found '{}'; expected a number from {:g} to {:g}{}", answer, least, most,
                             hint_of_number(answer));
        }
        return try_value(value, *given);
      },
      help.empty() ? help : fmt::format("{}; a number from {:g} to {:g}", help, least, most));
}

void Questions::text(const std::string& question, std::string& value, const std::string& example,
                     const std::string& help) {
  const std::string shown = value.empty() ? fmt::format("{}, such as {}", question, example) : question;
  ask(
      shown, value,
      [&](const std::string& answer) -> std::string {
        for (const char c : answer) {
          if (c != '"' && c != '\\' && static_cast<unsigned char>(c) >= 0x20) continue;
          return fmt::format("found '{}'; expected no quotes, backslashes and control characters", answer);
        }
        return try_value(value, answer);
      },
      help);
}

void Questions::choice(const std::string& question, const std::vector<std::string>& words,
                       const std::function<void(std::size_t)>& set, const std::string& help) {
  ask(
      fmt::format("{} ({})", question, fmt::join(words, ", ")), words[0],
      [&](const std::string& answer) -> std::string {
        for (std::size_t chosen = 0; chosen < words.size(); ++chosen) {
          if (in_small_letters(words[chosen]) != in_small_letters(answer)) continue;
          set(chosen);
          return complaint_();
        }
        const bool letters = std::ranges::all_of(words, [](const std::string& word) { return word.size() == 1; });
        const std::string near = letters || answer.size() == 1 ? "" : hal::nearest_name(answer, words);
        return fmt::format("found '{}'; expected {}{}", answer, fmt::join(words, " or "),
                           near.empty() ? "" : fmt::format("; did you mean {}?", near));
      },
      help);
}

}  // namespace airside::tools
