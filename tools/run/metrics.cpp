#include "tools/run/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "hal/text/input_error.hpp"

namespace airside::tools {
namespace {

using Samples = std::span<const CycleSample>;

std::string at_second(CivilTime time) { return "second " + std::to_string(time.seconds); }

void check(Samples samples, std::span<const EnergyRow> energy) {
  if (samples.empty()) {
    throw hal::InputError("metrics", "no control cycle", "at least one", "run at least one scored day");
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const CycleSample& sample = samples[i];
    bool finite = std::isfinite(sample.room_mean_degc) && std::isfinite(sample.setpoint_degc);
    for (const double t : sample.room_temp_degc) finite = finite && std::isfinite(t);
    const std::string place = "metrics: cycle at " + at_second(sample.time);
    if (!finite) {
      throw hal::InputError(place, "a value that is not finite", "finite temperatures and setpoint",
                            "leave the cycle out of the samples");
    }
    if (i > 0 && sample.time <= samples[i - 1].time) {
      throw hal::InputError(place, "a time that does not increase", "cycles in order of time",
                            "sort the samples and drop repeats");
    }
    if (sample.room_temp_degc.size() != samples[0].room_temp_degc.size()) {
      throw hal::InputError(place, std::to_string(sample.room_temp_degc.size()) + " rooms",
                            std::to_string(samples[0].room_temp_degc.size()) + " as in the first cycle",
                            "give every sample the same rooms");
    }
  }
  for (const EnergyRow& row : energy) {
    if (!std::isfinite(row.power_kw)) {
      throw hal::InputError("metrics: energy row at " + at_second(row.time), "a power that is not finite",
                            "a finite number of kW", "leave the row out");
    }
  }
}

/// DARV of samples that all belong to one day. Fewer than two terms carry no variation: 0.
double darv(Samples day, int cycle_length_s) {
  double sum = 0;
  int terms = 0;
  for (std::size_t i = 2; i < day.size(); ++i) {
    if (day[i].time.seconds - day[i - 2].time.seconds != 2 * cycle_length_s) continue;
    sum += std::abs(day[i].setpoint_degc - 2 * day[i - 1].setpoint_degc + day[i - 2].setpoint_degc);
    ++terms;
  }
  return terms < 2 ? 0.0 : sum / (terms - 1);
}

DayMetrics day_metrics(Samples all, Samples scored, const MetricsSettings& settings) {
  DayMetrics day;
  day.midnight = CivilTime{all[0].time.day() * 86400};
  day.samples = static_cast<int>(scored.size());
  day.room_dae_degc.assign(all[0].room_temp_degc.size(), 0.0);
  const double hours = settings.cycle_s / 3600.0;
  const double n = static_cast<double>(scored.size());
  for (const CycleSample& s : scored) {
    const double error = s.room_mean_degc - settings.target_degc;
    const double gap = s.room_mean_degc - s.setpoint_degc;
    day.dae_degc += std::abs(error) / n;
    day.degree_hours_above_degch += std::max(0.0, error) * hours;
    day.degree_hours_below_degch += std::max(0.0, -error) * hours;
    day.cdh_degch += std::max(0.0, gap) * hours;
    day.hdh_degch += std::max(0.0, -gap) * hours;
    for (std::size_t r = 0; r < s.room_temp_degc.size(); ++r) {
      day.room_dae_degc[r] += std::abs(s.room_temp_degc[r] - settings.target_degc) / n;
    }
  }
  for (const double room : day.room_dae_degc) day.worst_room_dae_degc = std::max(day.worst_room_dae_degc, room);
  for (const CycleSample& s : all) {
    const double area = (s.setpoint_degc - settings.reference_setpoint_degc) * hours;
    day.saved_area_degch += area;
    day.saved_area_unsigned_degch += std::abs(area);
  }
  day.darv_degc = darv(scored, settings.cycle_s);
  day.darv_full_day_degc = darv(all, settings.cycle_s);
  return day;
}

}  // namespace

bool is_scored(CivilTime time, const MetricsSettings& settings) {
  if (settings.weekdays_only && time.weekday() >= 5) return false;
  const int second = time.second_of_day();
  return second >= settings.work_start_s && second < settings.work_end_s;
}

Metrics compute_metrics(Samples samples, std::span<const EnergyRow> energy, const MetricsSettings& settings) {
  check(samples, energy);
  Metrics m;
  for (std::size_t begin = 0; begin < samples.size();) {
    const std::int64_t date = samples[begin].time.day();
    std::size_t end = begin;
    while (end < samples.size() && samples[end].time.day() == date) ++end;
    // Working hours are one interval of the day, so the scored samples are contiguous.
    std::size_t first = begin;
    while (first < end && !is_scored(samples[first].time, settings)) ++first;
    std::size_t last = first;
    while (last < end && is_scored(samples[last].time, settings)) ++last;
    if (last > first) {
      m.days.push_back(
          day_metrics(samples.subspan(begin, end - begin), samples.subspan(first, last - first), settings));
    }
    begin = end;
  }
  if (m.days.empty()) {
    throw hal::InputError("metrics", "no cycle in working hours", "at least one", "run at least one scored day");
  }

  const double days = static_cast<double>(m.days.size());
  m.day1_dae_degc = m.days.front().dae_degc;
  m.room_dae_degc.assign(samples[0].room_temp_degc.size(), 0.0);
  for (const DayMetrics& day : m.days) {
    m.dae_degc += day.dae_degc / days;
    m.me_degc = std::max(m.me_degc, day.dae_degc);
    m.darv_degc += day.darv_degc / days;
    m.darv_full_day_degc += day.darv_full_day_degc / days;
    m.cdh_degch += day.cdh_degch;
    m.hdh_degch += day.hdh_degch;
    m.degree_hours_above_degch += day.degree_hours_above_degch / days;
    m.degree_hours_below_degch += day.degree_hours_below_degch / days;
    m.saved_area_degch += day.saved_area_degch / days;
    m.saved_area_unsigned_degch += day.saved_area_unsigned_degch / days;
    m.worst_room_dae_degc += day.worst_room_dae_degc / days;
    for (std::size_t r = 0; r < m.room_dae_degc.size(); ++r) m.room_dae_degc[r] += day.room_dae_degc[r] / days;
  }
  for (const double room : m.room_dae_degc) m.rooms_dae_degc += room / static_cast<double>(m.room_dae_degc.size());
  m.degree_hours_degch = m.degree_hours_above_degch + m.degree_hours_below_degch;

  const double row_hours = settings.row_s / 3600.0;
  for (const EnergyRow& row : energy) m.hvac_kwh += row.power_kw * row_hours;
  if (!energy.empty()) m.hvac_kwh_per_day = m.hvac_kwh * 24.0 / (row_hours * static_cast<double>(energy.size()));
  return m;
}

Spread spread_of(std::span<const double> values) {
  Spread s;
  s.count = static_cast<int>(values.size());
  if (values.empty()) return s;
  for (const double v : values) s.mean += v / s.count;
  if (s.count < 2) return s;
  double sum = 0;
  for (const double v : values) sum += (v - s.mean) * (v - s.mean);
  s.sd = std::sqrt(sum / (s.count - 1));
  return s;
}

Spread spread_of(std::span<const Metrics> runs, double Metrics::*figure) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const Metrics& run : runs) values.push_back(run.*figure);
  return spread_of(values);
}

}  // namespace airside::tools
