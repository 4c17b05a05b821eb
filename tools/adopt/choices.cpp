#include "tools/adopt/choices.hpp"

#include <algorithm>
#include <cmath>

namespace airside::tools {

bool works(const SiteChoices& choices, const Observation& week, std::size_t step) {
  const double hour = week.hour_of_day(step);
  if (choices.work.weekday_only && week.weekday(step) >= 5) return false;
  return hour >= choices.work.from_h && hour < choices.work.to_h;
}

namespace {

constexpr double no_setpoint = -900;  ///< the engine shows -999

double mean(const std::vector<double>& values, double otherwise) {
  if (values.empty()) return otherwise;
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double quantile(std::vector<double> values, double share, double otherwise) {
  if (values.empty()) return otherwise;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

double round_to(double value, double step) { return std::round(value / step) * step; }

double mean_of_rooms(const std::vector<std::vector<double>>& rooms, std::size_t step) {
  double sum = 0;
  for (const auto& room : rooms) sum += room[step];
  return sum / static_cast<double>(rooms.size());
}

std::vector<double> total(const std::vector<std::vector<double>>& parts, std::size_t steps) {
  std::vector<double> sum(steps, 0.0);
  for (const auto& part : parts) {
    for (std::size_t i = 0; i < part.size() && i < steps; ++i) sum[i] += part[i];
  }
  return sum;
}

/// Hours within which most of the days' steps are on.
DayHours hours_of(const std::vector<bool>& on, const Observation& week) {
  const auto bins = static_cast<std::size_t>(week.steps_per_day);
  std::vector<int> count(bins, 0);
  int days = 0, weekday_on = 0, weekend_on = 0;
  for (std::size_t i = 0; i < on.size(); ++i) {
    const bool weekend = week.weekday(i) >= 5;
    if (i % bins == 0 && !weekend) ++days;
    (weekend ? weekend_on : weekday_on) += on[i] ? 1 : 0;
    if (!weekend && on[i]) ++count[i % bins];
  }
  DayHours out;
  std::size_t first = bins, last = 0, filled = 0;
  for (std::size_t b = 0; b < bins; ++b) {
    if (2 * count[b] <= days) continue;
    first = std::min(first, b);
    last = b + 1;
    ++filled;
  }
  out.weekday_only = weekend_on * 10 < weekday_on;
  if (filled == 0 || days == 0) return {0, 24, out.weekday_only, weekday_on > 0};
  out.from_h = 24.0 * static_cast<double>(first) / static_cast<double>(bins);
  out.to_h = 24.0 * static_cast<double>(last) / static_cast<double>(bins);
  out.interrupted = filled != last - first;
  return out;
}

/// Steps with more than a quarter of the most people.
std::vector<bool> busy(const std::vector<double>& people, double most) {
  std::vector<bool> on(people.size());
  for (std::size_t i = 0; i < people.size(); ++i) on[i] = people[i] > 0.25 * most;
  return on;
}

/// Steps at which the thermostats ask for their lowest cooling setpoint, where these change.
std::vector<bool> thermostats_at_work(const Observation& week) {
  const auto sum = total(week.cooling_sp, week.steps());
  const auto [low, high] = std::minmax_element(sum.begin(), sum.end());
  if (sum.empty() || *high - *low < 0.5) return {};
  std::vector<bool> on(sum.size());
  for (std::size_t i = 0; i < sum.size(); ++i) on[i] = sum[i] < 0.5 * (*low + *high);
  return on;
}

std::array<PeopleHours, 7> hours_by_day(const std::vector<bool>& on, const Observation& week) {
  std::array<PeopleHours, 7> days{};
  const double step_h = 24.0 / week.steps_per_day;
  for (std::size_t i = 0; i < on.size(); ++i) {
    if (!on[i]) continue;
    PeopleHours& day = days[static_cast<std::size_t>(week.weekday(i))];
    if (day.from_h == day.to_h) day.from_h = week.hour_of_day(i);
    day.to_h = week.hour_of_day(i) + step_h;
  }
  return days;
}

/// Whether a weekend day has people in hours that differ by more than two from every working day's.
bool weekend_differs(const std::array<PeopleHours, 7>& days) {
  const auto hours = [](const PeopleHours& day) { return day.to_h - day.from_h; };
  const auto working = std::minmax_element(days.begin(), days.begin() + 5,
                                           [&](const auto& a, const auto& b) { return hours(a) < hours(b); });
  const double least = hours(*working.first) - 2, most = hours(*working.second) + 2;
  return std::any_of(days.begin() + 5, days.end(),
                     [&](const PeopleHours& day) { return hours(day) < least || hours(day) > most; });
}

void choose_hours(const Observation& summer, SiteChoices& out) {
  const auto people = total(summer.people, summer.steps());
  const double most = people.empty() ? 0 : *std::max_element(people.begin(), people.end());
  std::vector<bool> on = busy(people, most);
  out.people = most > 0;
  if (!out.people) on = thermostats_at_work(summer);
  out.assumed_hours = on.empty();
  if (out.assumed_hours) {
    out.work = {7, 19, false, false};
  } else {
    out.work = hours_of(on, summer);
    out.people_by_day = hours_by_day(on, summer);
    out.two_day_types = !out.work.weekday_only && weekend_differs(out.people_by_day);
  }
  out.fan = hours_of(fan_runs(summer), summer);
}

/// The setpoint, or where there is none the supply temperature, while the fan runs.
void own_setpoints(const Observation& week, const SiteChoices& choices, std::vector<double>& working,
                   std::vector<double>& resting) {
  const auto fan = fan_runs(week);
  for (std::size_t i = 0; i < week.steps(); ++i) {
    if (!fan[i]) continue;
    const bool set = i < week.setpoint_degc.size() && week.setpoint_degc[i] > no_setpoint;
    (works(choices, week, i) ? working : resting).push_back(set ? week.setpoint_degc[i] : week.supply_degc[i]);
  }
}

void choose_range(const Observation& summer, const Observation& winter, TerminalKind kind, SiteChoices& out) {
  constexpr double lowest = 8, highest = 35;
  std::vector<double> working, resting, cold_working, cold_resting;
  own_setpoints(summer, out, working, resting);
  own_setpoints(winter, out, cold_working, cold_resting);
  const double work = mean(working, 14);
  out.work_degc = std::clamp(round_to(work, 0.1), lowest, highest);
  out.off_degc = std::clamp(round_to(mean(resting, work), 0.1), lowest, highest);
  out.winter_degc = mean(cold_working, work);
  std::vector<double> all = working;
  all.insert(all.end(), cold_working.begin(), cold_working.end());
  const double low = quantile(all, 0.02, work), high = quantile(all, 0.98, work);
  out.min_degc = std::clamp(std::floor(2 * std::min(low, out.work_degc)) / 2, lowest, highest - 6);
  const double widest = kind == TerminalKind::fixed ? 8 : 6;
  out.max_degc = std::clamp(std::ceil(2 * std::max(high, out.min_degc + widest)) / 2, out.min_degc + 4, highest);
  out.off_degc = std::clamp(out.off_degc, out.min_degc, out.max_degc);
  out.step_k = out.max_degc - out.min_degc > 18 ? 0.2 : 0.1;
}

void choose_target(const Observation& summer, SiteChoices& out) {
  std::vector<double> rooms;
  for (std::size_t i = 0; i < summer.steps(); ++i) {
    if (works(out, summer, i)) rooms.push_back(mean_of_rooms(summer.room_degc, i));
  }
  out.target_degc = std::clamp(round_to(mean(rooms, 24), 0.25), 16.0, 30.0);
}

/// The loop's own fans and coils; of the building what a water plant takes; where the model meters none of these, the
/// whole. A building's fans are those of all its loops.
void choose_meters(const Observation& summer, const Observation& winter, const LoopMeters& meters, SiteChoices& out) {
  const auto have = [&](const std::string& meter) {
    // A coil of the loop may rest under the model's own setpoint, and work under another.
    const auto custom = meters.patch.find("Meter:Custom");
    return summer.meter_kw.contains(meter) || winter.meter_kw.contains(meter) ||
           (custom != meters.patch.end() && custom->contains(meter));
  };
  for (const std::string& meter : candidate_meters()) {
    const bool fans = meter.starts_with("Fans"), cooling = meter.starts_with("Cooling");
    const bool heating = meter.starts_with("Heating");
    if ((fans && meters.fans) || (cooling && meters.cooling) || (heating && meters.heating)) continue;
    const bool single = fans || cooling || heating || meter.starts_with("Loop ");
    if (single && have(meter) && out.powers.size() < 4) out.powers.push_back(meter);
  }
  if (!out.powers.empty()) return;
  for (const char* whole : {"Electricity:HVAC", "Electricity:Plant", "Electricity:Facility"}) {
    if (have(whole) && out.powers.empty()) out.powers.emplace_back(whole);
  }
}

struct Means {
  std::vector<double> supply, room, damper, kw;
};

Means means_of(const Observation& days, const SiteChoices& choices) {
  Means out;
  const auto fan = fan_runs(days);
  for (std::size_t i = 0; i < days.steps(); ++i) {
    if (!fan[i] || !works(choices, days, i)) continue;
    out.supply.push_back(days.supply_degc[i]);
    out.room.push_back(mean_of_rooms(days.room_degc, i));
    for (const auto& damper : days.damper) {
      if (i < damper.size()) out.damper.push_back(damper[i]);
    }
    double kw = 0;
    for (const std::string& meter : choices.powers) {
      const auto series = days.meter_kw.find(meter);
      if (series != days.meter_kw.end()) kw += series->second[i];
    }
    out.kw.push_back(kw);
  }
  return out;
}

}  // namespace

std::vector<bool> fan_runs(const Observation& week) {
  const double most = week.flow_kg_s.empty() ? 0 : *std::max_element(week.flow_kg_s.begin(), week.flow_kg_s.end());
  std::vector<bool> on(week.steps());
  for (std::size_t i = 0; i < on.size(); ++i) on[i] = most > 0 && week.flow_kg_s[i] > 0.03 * most;
  return on;
}

SiteChoices site_choices(const Observation& summer, const Observation& winter, TerminalKind kind,
                         const LoopMeters& meters) {
  SiteChoices out;
  choose_hours(summer, out);
  choose_range(summer, winter, kind, out);
  choose_target(summer, out);
  choose_meters(summer, winter, meters, out);
  std::vector<double> flow;
  const auto fan = fan_runs(summer);
  for (std::size_t i = 0; i < summer.steps(); ++i) {
    if (fan[i]) flow.push_back(summer.flow_kg_s[i]);
  }
  out.mean_flow_kg_s = mean(flow, 0);
  return out;
}

Response response_of(const Observation& low, const Observation& high, const SiteChoices& choices) {
  const Means at_low = means_of(low, choices), at_high = means_of(high, choices);
  Response out;
  const double range = choices.max_degc - choices.min_degc;
  if (at_low.supply.empty() || at_high.supply.empty() || range <= 0) return out;
  out.known = true;
  out.supply_low_degc = mean(at_low.supply, 0);
  out.supply_high_degc = mean(at_high.supply, 0);
  out.room_low_degc = mean(at_low.room, 0);
  out.room_high_degc = mean(at_high.room, 0);
  out.damper_low = mean(at_low.damper, -1);
  out.damper_high = mean(at_high.damper, -1);
  out.kw_low = mean(at_low.kw, 0);
  out.kw_high = mean(at_high.kw, 0);
  out.supply_gain = (out.supply_high_degc - out.supply_low_degc) / range;
  out.room_gain = (out.room_high_degc - out.room_low_degc) / range;
  return out;
}

}  // namespace airside::tools
