#include "tools/gap/any_model/schedule_shift.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "hal/text/civil_text.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;

constexpr int day_min = 24 * 60;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// "Until: 08:30" as minutes.
std::optional<int> until_of(const std::string& text) {
  const auto colon = text.find(':');
  if (!text.starts_with("until") || colon == std::string::npos) return std::nullopt;
  const auto first = text.find_first_not_of(' ', colon + 1);
  if (first == std::string::npos) return std::nullopt;
  std::string clock = text.substr(first, text.find_last_not_of(' ') + 1 - first);
  if (clock.find(':') == 1) clock.insert(0, 1, '0');  // "8:00"
  const auto seconds = hal::parse_time_of_day(clock);
  return seconds ? std::optional(*seconds / 60) : std::nullopt;
}

std::optional<double> number_of(const json& value) {
  if (value.is_number()) return value.get<double>();
  if (!value.is_string()) return std::nullopt;
  const auto text = value.get<std::string>();
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return end != text.c_str() && *end == '\0' ? std::optional(number) : std::nullopt;
}

/// (until, value) of a day, moved.
std::vector<std::pair<int, double>> moved(const std::vector<std::pair<int, double>>& course, int minutes) {
  const auto value_at = [&](int minute) {
    for (const auto& [until, value] : course) {
      if (minute < until) return value;
    }
    return course.back().second;
  };
  std::vector<int> ends{day_min};
  for (const auto& [until, value] : course) {
    const int end = ((until + minutes) % day_min + day_min) % day_min;
    if (end > 0) ends.push_back(end);
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  std::vector<std::pair<int, double>> out;
  for (const int end : ends) {
    const double value = value_at(((end - 1 - minutes) % day_min + day_min) % day_min);
    if (!out.empty() && out.back().second == value)
      out.back().first = end;
    else
      out.emplace_back(end, value);
  }
  return out;
}

}  // namespace

std::optional<json> shifted_compact(const json& schedule, int minutes) {
  const auto list = schedule.find("data");
  if (list == schedule.end() || !list->is_array()) return std::nullopt;
  json out = schedule, fields = json::array();
  std::vector<std::pair<int, double>> course;
  const auto say = [&fields](const json& value) { fields.push_back({{"field", value}}); };
  const auto end_day = [&] {
    if (course.empty()) return;
    say("Interpolate: Average");
    for (const auto& [until, value] : moved(course, minutes)) {
      say(fmt::format("Until: {:02}:{:02}", until / 60, until % 60));
      say(value);
    }
    course.clear();
  };
  std::optional<int> until;
  for (const json& entry : *list) {
    const json value = entry.value("field", json());
    if (until) {
      const auto number = number_of(value);
      if (!number) return std::nullopt;
      course.emplace_back(*until, *number);
      until.reset();
      continue;
    }
    if (!value.is_string()) return std::nullopt;
    const std::string text = lower(value.get<std::string>());
    until = until_of(text);
    if (until) continue;
    end_day();
    if (!text.starts_with("interpolate")) say(value);
  }
  end_day();
  if (fields.empty()) return std::nullopt;
  out["data"] = std::move(fields);
  return out;
}

}  // namespace airside::tools::gap
