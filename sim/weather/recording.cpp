#include "sim/weather/recording.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace airside::sim {

namespace {

/// t, moved by whole days into the first recorded day if it lies before.
CivilTime repeated(const Recording& recording, CivilTime t) {
  while (t < recording.from) t.seconds += seconds_per_day;
  return t;
}

double between(double a, double b, double share) { return a + share * (b - a); }

}  // namespace

const RecordedRow& Recording::at(CivilTime t) const {
  const std::int64_t row = (repeated(*this, t).seconds - from.seconds) / row_s;
  return rows[std::min(static_cast<std::size_t>(row), rows.size() - 1)];
}

std::string Channels::name(int column) const {
  const auto placed = [](const char* text, int place, const char* unit) {
    return std::string(text) + std::to_string(place + 1) + unit;
  };
  if (column < fcu_temp()) return placed("room_temp_", column, "_degc");
  if (column < mau_temp()) return placed("fcu_temp_", column - fcu_temp(), "_degc");
  if (column == mau_temp()) return "mau_temp_degc";
  if (column == supply_temp()) return "supply_temp_degc";
  if (column < fcu_duty()) return placed("power_", column - power(), "_kw");
  if (column < damper()) return placed("fcu_duty_", column - fcu_duty(), "");
  return placed("damper_", column - damper(), "");
}

const char* Channels::unit(int column) const { return column < power() ? "K" : column < fcu_duty() ? "kW" : "-"; }

namespace {

Weather weather_of(const Recording& recording, int interval_s) {
  const CivilTime begin{recording.from.seconds - lead_days * seconds_per_day};
  std::vector<WeatherRecord> records;
  // A record's temperature holds at its end: an instant's value is the mean of the rows around it.
  for (CivilTime end{begin.seconds + interval_s}; end <= recording.to(); end.seconds += interval_s) {
    const CivilTime there = repeated(recording, end);
    WeatherRecord record = recording.station->at(there);
    // Radiation belongs to the interval's middle.
    const WeatherRecord middle = recording.station->at({there.seconds - interval_s / 2});
    record.direct_normal_w_m2 = middle.direct_normal_w_m2;
    record.diffuse_horizontal_w_m2 = middle.diffuse_horizontal_w_m2;
    record.global_horizontal_w_m2 = middle.global_horizontal_w_m2;
    const RecordedRow& row = recording.at(there);
    const RecordedRow& next = recording.at({there.seconds + row_s});
    const double share = static_cast<double>((there.seconds - recording.from.seconds) % row_s) / row_s;
    const double measured = between(row.outdoor_temp_degc, next.outdoor_temp_degc, share);
    if (std::isfinite(measured)) record.outdoor_temp_degc = measured;
    if (std::isfinite(row.rain)) record.rain = row.rain;
    records.push_back(record);
  }
  const auto first = second_of_year(begin) / interval_s;
  return Weather(recording.station->location(), "measured weather", interval_s, static_cast<int>(first),
                 std::move(records));
}

/// By their bits, since what was not measured is NaN.
bool same_values(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace

std::shared_ptr<const Weather> measured_weather(const Recording& recording, int interval_s) {
  return std::make_shared<const Weather>(weather_of(recording, interval_s));
}

std::shared_ptr<const Weather> MeasuredWeathers::of(const Recording& recording) {
  std::vector<double> measured;
  measured.reserve(2 * recording.rows.size());
  for (const RecordedRow& row : recording.rows) measured.insert(measured.end(), {row.outdoor_temp_degc, row.rain});
  const auto find = [&]() -> std::shared_ptr<const Weather> {
    for (const Known& known : known_) {
      if (known.station == recording.station && known.from.seconds == recording.from.seconds &&
          same_values(known.measured, measured))
        return known.weather;
    }
    return nullptr;
  };
  {
    const std::lock_guard lock(mutex_);
    if (auto weather = find()) return weather;
  }
  Weather made = weather_of(recording, 180);
  made.keep_skies();
  const auto weather = std::make_shared<const Weather>(std::move(made));
  const std::lock_guard lock(mutex_);
  if (known_.size() == most) known_.erase(known_.begin());
  known_.push_back({recording.station, recording.from, std::move(measured), weather});
  return weather;
}

}  // namespace airside::sim
