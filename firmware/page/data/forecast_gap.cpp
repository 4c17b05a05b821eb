#include "firmware/page/data/forecast_gap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>

#include "hal/text/civil_text.hpp"
#include "hal/text/shell_word.hpp"

namespace airside::page {
namespace {

using nlohmann::json;

constexpr std::int64_t shown_days = 14;
constexpr std::size_t recent_days = 3, before_days_needed = 4;
constexpr int forecasts_needed = 10;  ///< of a day, to be compared with others
constexpr double growth = 1.5, growth_k = 0.05;
constexpr std::size_t least_reference_days = 2, reference_days_wanted = 7;  ///< the least that airside gap takes

/// Errors of one day or of several; the held value first, then each room.
struct Errors {
  struct Sums {
    double sum_k = 0, square_k2 = 0;
    int n = 0;
  };
  std::int64_t day = 0;
  int n = 0;  ///< of the held value
  std::vector<Sums> of;

  void add(std::size_t i, double error_k) {
    if (!std::isfinite(error_k)) return;
    of[i].sum_k += error_k;
    of[i].square_k2 += error_k * error_k;
    ++of[i].n;
  }
  void add(const Errors& other) {
    n += other.n;
    for (std::size_t i = 0; i < of.size(); ++i) {
      of[i].sum_k += other.of[i].sum_k;
      of[i].square_k2 += other.of[i].square_k2;
      of[i].n += other.of[i].n;
    }
  }
  double bias_k(std::size_t i) const { return of[i].n == 0 ? std::nan("") : of[i].sum_k / of[i].n; }
  double rms_k(std::size_t i) const { return of[i].n == 0 ? std::nan("") : std::sqrt(of[i].square_k2 / of[i].n); }
};

/// Thousandths: single errors are of a forecast between readings of hundredths.
json list_of(const Errors& errors, double (Errors::*what)(std::size_t) const) {
  json list = json::array();
  for (std::size_t i = 0; i < errors.of.size(); ++i) {
    const double value = (errors.*what)(i);
    list.push_back(std::isfinite(value) ? json(std::round(value * 1000) / 1000) : json());
  }
  return list;
}

/// Last name of a path, which may end in a slash, as a word of a command.
std::string last_name(const std::filesystem::path& path) {
  return hal::shell_word((path.has_filename() ? path : path.parent_path()).filename().string());
}

/// Adds what the cycle that begins in row `number` shows, if it shows something.
void add_cycle(const TrendStore& store, std::uint64_t number, Errors& errors) {
  const auto rows = static_cast<std::uint64_t>(store.cycle_rows());
  const TrendRow& begin = store.row(number);
  if (!begin.working_hours || !std::isfinite(begin.expected_degc) || number + rows >= store.count()) return;
  const TrendRow& end = store.row(number + rows);
  if (end.time.seconds - begin.time.seconds != store.cycle_rows() * row_s) return;
  for (std::uint64_t i = number + 1; i < number + rows; ++i) {
    if (store.row(i).setpoint_degc != begin.setpoint_degc) return;  // the forecast was of another one
  }
  const double forecast_k = static_cast<double>(begin.expected_degc) - static_cast<double>(begin.held_degc);
  const double moved_k = static_cast<double>(end.held_degc) - static_cast<double>(begin.held_degc);
  if (!std::isfinite(moved_k - forecast_k)) return;
  ++errors.n;
  errors.add(0, moved_k - forecast_k);
  for (std::size_t r = 0; r < static_cast<std::size_t>(store.vavs()); ++r) {
    const double room_k =
        static_cast<double>(store.rooms_degc(number + rows)[r]) - static_cast<double>(store.rooms_degc(number)[r]);
    errors.add(r + 1, room_k - forecast_k);
  }
}

std::vector<Errors> errors_by_day(const TrendStore& store, const Errors& none) {
  std::vector<Errors> days;
  if (store.count() == 0) return days;
  const std::int64_t last_day = store.row(store.count() - 1).time.day();
  const std::uint64_t from = store.from({(last_day - shown_days + 1) * seconds_per_day});
  for (std::uint64_t i = from; i < store.count(); ++i) {
    const std::int64_t day = store.row(i).time.day();
    if (days.empty() || days.back().day != day) {
      days.push_back(none);
      days.back().day = day;
    }
    add_cycle(store, i, days.back());
  }
  std::erase_if(days, [](const Errors& d) { return d.n == 0; });
  return days;
}

}  // namespace

json forecast_gap(const TrendStore& store) {
  Errors none;
  none.of.resize(static_cast<std::size_t>(store.vavs()) + 1);
  const std::vector<Errors> days = errors_by_day(store, none);
  Errors all = none, recent = none, before = none;
  std::size_t n_recent = 0, n_before = 0;
  for (auto day = days.rbegin(); day != days.rend(); ++day) {
    all.add(*day);
    if (day->n < forecasts_needed) continue;
    const bool is_recent = n_recent < recent_days;
    (is_recent ? recent : before).add(*day);
    ++(is_recent ? n_recent : n_before);
  }
  json by_day = json::array(), grows = json::array();
  for (const Errors& day : days) {
    by_day.push_back({{"date", hal::civil_text({day.day * seconds_per_day}).substr(0, hal::date_text_size)},
                      {"n", day.n},
                      {"bias_k", list_of(day, &Errors::bias_k)},
                      {"rms_k", list_of(day, &Errors::rms_k)}});
  }
  const bool enough = n_before >= before_days_needed;
  for (std::size_t i = 0; i < none.of.size(); ++i) {
    grows.push_back(enough && recent.rms_k(i) > growth * before.rms_k(i) &&
                    recent.rms_k(i) - before.rms_k(i) > growth_k);
  }
  return {{"cycle_min", store.cycle_rows() * row_s / 60},
          {"days", by_day},
          {"n", all.n},
          {"bias_k", list_of(all, &Errors::bias_k)},
          {"rms_k", list_of(all, &Errors::rms_k)},
          {"recent_days", n_recent},
          {"before_days", n_before},
          {"recent_rms_k", list_of(recent, &Errors::rms_k)},
          {"before_rms_k", list_of(before, &Errors::rms_k)},
          {"grows", grows},
          {"enough", enough},
          {"reference_days", std::clamp(days.size() - n_recent, least_reference_days, reference_days_wanted)},
          {"reading", store.is_reading()}};
}

GapHint::GapHint(const hal::SiteFile& site)
    : files_(fmt::format("--site {} --measured {}", last_name(site.path), last_name(site.log_dir))),
      weather_(site.twin && !site.twin->weather.empty() ? "" : " --weather STATION.epw"),
      has_twin_(site.twin.has_value()) {}

std::vector<std::string> GapHint::commands(int reference_days) const {
  const std::string judged = fmt::format("airside gap {} --reference-days {}", files_, reference_days);
  constexpr const char* out = " --out gap-report";
  if (has_twin_) return {judged + weather_ + out};
  return {fmt::format("airside gap fit {}{} --out room.json", files_, weather_),
          judged + " --plant rc --room room.json" + weather_ + out};
}

}  // namespace airside::page
