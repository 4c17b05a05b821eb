#include "hal/text/civil_text.hpp"

#include <algorithm>
#include <chrono>

namespace airside::hal {
namespace {

char* write_digits(char* out, int value, int digits) {
  for (int i = digits - 1; i >= 0; --i) {
    out[i] = static_cast<char>('0' + value % 10);
    value /= 10;
  }
  return out + digits;
}

/// Reads exactly `digits` digits at the front of `text` and removes them.
std::optional<int> take_digits(std::string_view& text, std::size_t digits) {
  if (text.size() < digits) return std::nullopt;
  int value = 0;
  for (std::size_t i = 0; i < digits; ++i) {
    if (text[i] < '0' || text[i] > '9') return std::nullopt;
    value = value * 10 + (text[i] - '0');
  }
  text.remove_prefix(digits);
  return value;
}

bool take(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

CivilTime civil_time(const CivilDate& d) {
  const std::chrono::sys_days day = std::chrono::year{d.year} / std::chrono::month{static_cast<unsigned>(d.month)} /
                                    std::chrono::day{static_cast<unsigned>(d.day)};
  return {std::int64_t{day.time_since_epoch().count()} * 86400 + d.hour * 3600 + d.minute * 60 + d.second};
}

CivilDate civil_date(CivilTime time) {
  const std::chrono::sys_days days{std::chrono::days{time.day()}};
  const std::chrono::year_month_day ymd{days};
  const int s = time.second_of_day();
  return {int{ymd.year()},
          static_cast<int>(unsigned{ymd.month()}),
          static_cast<int>(unsigned{ymd.day()}),
          s / 3600,
          s / 60 % 60,
          s % 60};
}

char* write_date_text(char* out, CivilTime time) {
  constexpr std::int64_t first = -62167219200;  // 0000-01-01T00:00:00
  constexpr std::int64_t last = 253402300799;   // 9999-12-31T23:59:59
  const CivilDate d = civil_date({std::clamp(time.seconds, first, last)});
  out = write_digits(out, d.year, 4);
  *out++ = '-';
  out = write_digits(out, d.month, 2);
  *out++ = '-';
  return write_digits(out, d.day, 2);
}

char* write_civil_text(char* out, CivilTime time) {
  out = write_date_text(out, time);
  const int s = time.second_of_day();
  *out++ = 'T';
  out = write_digits(out, s / 3600, 2);
  *out++ = ':';
  out = write_digits(out, s / 60 % 60, 2);
  *out++ = ':';
  return write_digits(out, s % 60, 2);
}

std::string civil_text(CivilTime time) {
  char text[civil_text_size];
  return {text, write_civil_text(text, time)};
}

std::optional<int> parse_time_of_day(std::string_view text) {
  const auto hour = take_digits(text, 2);
  if (!hour || !take(text, ':')) return std::nullopt;
  const auto minute = take_digits(text, 2);
  if (!minute) return std::nullopt;
  std::optional<int> second = 0;
  if (take(text, ':')) second = take_digits(text, 2);
  if (!second || !text.empty() || *minute > 59 || *second > 59) return std::nullopt;
  const int s = *hour * 3600 + *minute * 60 + *second;
  return s <= 86400 ? std::optional(s) : std::nullopt;
}

std::optional<CivilTime> parse_civil_text(std::string_view text) {
  const auto year = take_digits(text, 4);
  if (!year || !take(text, '-')) return std::nullopt;
  const auto month = take_digits(text, 2);
  if (!month || !take(text, '-')) return std::nullopt;
  const auto day = take_digits(text, 2);
  if (!day || !(take(text, 'T') || take(text, ' '))) return std::nullopt;
  const auto second = parse_time_of_day(text);
  const std::chrono::year_month_day ymd{std::chrono::year{*year}, std::chrono::month{static_cast<unsigned>(*month)},
                                        std::chrono::day{static_cast<unsigned>(*day)}};
  if (!second || !ymd.ok()) return std::nullopt;
  return CivilTime{civil_time({*year, *month, *day, 0, 0, 0}).seconds + *second};
}

std::string clock_text(int second_of_day) {
  std::string text(5, ':');
  write_digits(text.data(), second_of_day / 3600, 2);
  write_digits(text.data() + 3, second_of_day / 60 % 60, 2);
  return text;
}

}  // namespace airside::hal
