#include "tools/adopt/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace airside::tools {

namespace {

constexpr double band_k = 0.5;
constexpr double people_are_there = 0.1;    ///< share of the most people; fewer clean at night
constexpr double no_thermostat_degc = 0.1;  ///< the engine shows 0 where a zone has no such setpoint

std::vector<bool> people_there(const Observation& days, const SiteChoices& choices) {
  std::vector<bool> there(days.steps(), false);
  if (!choices.people) {
    for (std::size_t i = 0; i < there.size(); ++i) there[i] = works(choices, days, i);
    return there;
  }
  for (const std::vector<double>& zone : days.people) {
    if (zone.empty()) continue;
    const double most = *std::ranges::max_element(zone);
    for (std::size_t i = 0; i < there.size(); ++i) there[i] = there[i] || zone[i] > people_are_there * most;
  }
  return there;
}

double outside_k(double room_degc, const std::vector<double>& heating, const std::vector<double>& cooling,
                 std::size_t step) {
  double outside = 0;
  if (!cooling.empty() && cooling[step] > no_thermostat_degc)
    outside = std::max(outside, room_degc - cooling[step] - band_k);
  if (!heating.empty() && heating[step] > no_thermostat_degc)
    outside = std::max(outside, heating[step] - band_k - room_degc);
  return outside;
}

std::vector<double> power_kw(const Observation& days, const SiteChoices& choices) {
  std::vector<double> sum(days.steps(), 0.0);
  for (const std::string& meter : choices.powers) {
    const auto series = days.meter_kw.find(meter);
    if (series == days.meter_kw.end()) continue;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += series->second[i];
  }
  return sum;
}

double total(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Of a series a step, in units of hours a day.
double hours_a_day(const std::vector<double>& series) {
  return series.empty() ? 0 : 24 * total(series) / static_cast<double>(series.size());
}

/// The first `steps` of a longer observation.
Observation first_steps(Observation days, std::size_t steps) {
  const auto cut = [steps](std::vector<double>& series) { series.resize(std::min(series.size(), steps)); };
  for (auto* zones : {&days.room_degc, &days.cooling_sp, &days.heating_sp, &days.people, &days.damper})
    std::ranges::for_each(*zones, cut);
  for (auto* series : {&days.setpoint_degc, &days.supply_degc, &days.flow_kg_s, &days.outdoor_degc}) cut(*series);
  for (auto& [name, series] : days.meter_kw) cut(series);
  return days;
}

/// Zone degrees outside the band, a step: the sum over the zones while people are there, else 0.
std::vector<double> degrees_outside(const Observation& days, const SiteChoices& choices) {
  const std::vector<bool> there = people_there(days, choices);
  std::vector<double> outside(days.steps(), 0.0);
  for (std::size_t z = 0; z < days.room_degc.size(); ++z) {
    for (std::size_t i = 0; i < outside.size(); ++i) {
      if (there[i]) outside[i] += outside_k(days.room_degc[z][i], days.heating_sp[z], days.cooling_sp[z], i);
    }
  }
  return outside;
}

}  // namespace

const char* text_of(Season season) {
  switch (season) {
    case Season::winter: return "winter";
    case Season::autumn: return "autumn";
    case Season::summer: break;
  }
  return "summer";
}

DayFigures day_figures(const Observation& days, const SiteChoices& choices) {
  return {hours_a_day(power_kw(days, choices)), hours_a_day(degrees_outside(days, choices))};
}

const HeldDays& Comparison::best() const {
  double fewest = HUGE_VAL;
  for (const HeldDays& held : constants) fewest = std::min(fewest, held.figures.outside_degch);
  const double most = fewest + allowance_degch();
  const auto cost = [most](const HeldDays& held) {
    return held.figures.outside_degch > most ? HUGE_VAL : held.figures.kwh;
  };
  return *std::ranges::min_element(constants, {}, cost);
}

Comparison comparison_of(const Observation& own, const Observation& schedule,
                         const std::vector<HeldObservation>& constants, const SiteChoices& choices) {
  Comparison out;
  out.zones = own.room_degc.size();
  out.own = day_figures(first_steps(own, schedule.steps()), choices);
  out.schedule = day_figures(schedule, choices);
  for (const HeldObservation& held : constants)
    out.constants.push_back({held.setpoint_degc, day_figures(held.days, choices)});
  return out;
}

}  // namespace airside::tools
