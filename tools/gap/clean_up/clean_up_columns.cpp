// Columns that are not what their names say: another unit, or another column's values.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tools/gap/clean_up/clean_up_table.hpp"

namespace airside::tools::gap {

namespace {

/// shown = value * scale + offset, in the log; the column should hold `value`.
struct UnitSlip {
  const char* text;
  double scale, offset;
  bool scaled_integer;  ///< a register that was not divided
  double value(double shown) const { return (shown - offset) / scale; }
};
constexpr std::array<UnitSlip, 4> temperature_slips{{
    {"degrees Fahrenheit", 1.8, 32, false},
    {"kelvin", 1, 273.15, false},
    {"tenths of a degree", 10, 0, true},
    {"hundredths of a degree", 100, 0, true},
}};
constexpr UnitSlip watt{"W", 1000, 0, false};

/// What a column shows, in short.
struct Shown {
  double low, middle, high;
  double spread() const { return high - low; }
};

Shown shown_of(const LogColumn& column) {
  const auto sorted = sorted_finite(column.value);
  return {quantile_of_sorted(sorted, 0.05), quantile_of_sorted(sorted, 0.5), quantile_of_sorted(sorted, 0.95)};
}

bool is_integer(double v) { return std::abs(v - std::round(v)) < 1e-9; }
bool is_flag(double v) { return v == 0 || v == 1; }

Remark remark_of(Defect defect, Action action, const LogColumn& column, const LogTable& table, std::string text) {
  return {defect,          action, column.name, table.time.front(), table.time.back(), count_finite(column.value),
          std::move(text), "",     ""};
}

Remark refusal(Defect defect, const LogColumn& column, const LogTable& table, std::string text, std::string expected,
               std::string remedy) {
  Remark r = remark_of(defect, Action::refused, column, table, std::move(text));
  r.expected = std::move(expected);
  r.remedy = std::move(remedy);
  return r;
}

/// Median over columns of their medians, those only that are in their unit's band.
double usual_indoor_degc(const LogTable& table, const LogColumn* without = nullptr) {
  std::vector<double> medians;
  for (const LogColumn& c : table.columns) {
    if (!c.facts().indoor || &c == without) continue;
    const double m = median_of(c.value);
    if (m >= c.facts().low && m <= c.facts().high) medians.push_back(m);
  }
  return median_of(medians);
}

double station_difference_k(const LogTable& table, const LogColumn& column, const UnitSlip& slip) {
  std::vector<double> k;
  for (std::size_t i = 0; i < column.value.size(); ++i) {
    k.push_back(std::abs(slip.value(column.value[i]) - table.station.at(table.time[i])));
  }
  return median_of(k);
}

/// Slips after which the column would be what it should be.
std::vector<UnitSlip> possible_slips(const LogTable& table, const LogColumn& column) {
  const Shown shown = shown_of(column);
  const RoleFacts& facts = column.facts();
  std::vector<UnitSlip> possible;
  for (const UnitSlip& slip : temperature_slips) {
    const double m = slip.value(shown.middle);
    const auto in_limits = [&](double v) {
      return slip.value(v) >= column.limits.min && slip.value(v) <= column.limits.max;
    };
    if (m < facts.low || m > facts.high || share_of(column.value, in_limits) < 0.95) continue;
    // A room that moves by less than 0.15 K in two weeks is a number in another unit.
    if (slip.scaled_integer && shown.spread() / slip.scale < (column.role == Role::outdoor ? 1.5 : 0.15)) continue;
    if (column.role == Role::outdoor && !table.station.empty() && station_difference_k(table, column, slip) > 8) {
      continue;
    }
    possible.push_back(slip);
  }
  if (possible.size() > 1) {
    const bool integers = share_of(column.value, is_integer) > 0.95;
    std::erase_if(possible, [integers](const UnitSlip& s) { return s.scaled_integer != integers; });
  }
  return possible;
}

bool outside_band(const LogTable& table, const LogColumn& column) {
  const double m = median_of(column.value);
  if (column.role == Role::outdoor && !table.station.empty()) {
    return station_difference_k(table, column, {"", 1, 0, false}) > 12;
  }
  return m < column.facts().low || m > column.facts().high;
}

void convert(LogTable& table, LogColumn& column, const UnitSlip& slip, const char* unit, std::vector<Remark>& remarks) {
  const double before = median_of(column.value);
  for (double& v : column.value) v = slip.value(v);
  remarks.push_back(remark_of(Defect::wrong_unit, Action::fixed, column, table,
                              fmt::format("values about {:.4g} are {}; converted to {:.4g} {}", before, slip.text,
                                          median_of(column.value), unit)));
}

void check_temperature_unit(LogTable& table, LogColumn& column, std::vector<Remark>& remarks) {
  if (!outside_band(table, column)) return;
  const auto possible = possible_slips(table, column);
  if (possible.empty()) return;  // no unit: the checks of columns and limits have their say
  const double indoor = usual_indoor_degc(table, &column);
  const double converted = possible.front().value(median_of(column.value));
  const bool strange = column.facts().indoor && std::isfinite(indoor) && std::abs(converted - indoor) > 8;
  if (possible.size() == 1 && !strange) {
    convert(table, column, possible.front(), "degC", remarks);
  } else {
    remarks.push_back(
        refusal(Defect::wrong_unit, column, table,
                fmt::format("values about {:.4g}, perhaps {}", median_of(column.value), possible.front().text),
                "degrees Celsius", "convert the column to degC"));
  }
}

void check_power_unit(LogTable& table, LogColumn& column, const CleanUpContext& context, std::vector<Remark>& remarks) {
  std::vector<double> running;
  std::copy_if(column.value.begin(), column.value.end(), std::back_inserter(running), [](double v) { return v > 0; });
  const double m = median_of(running);
  const double ceiling_kw = context.largest_zone_kw * (context.counts.vavs + context.counts.fcus);
  if (!(m > std::min(ceiling_kw, column.limits.max)) || running.size() < least_values) return;
  if (watt.value(m) >= 0.02 && watt.value(m) <= ceiling_kw) {
    convert(table, column, watt, "kW", remarks);
  } else {
    remarks.push_back(refusal(
        Defect::wrong_unit, column, table, fmt::format("values about {:.4g}", m),
        fmt::format("kW, at most {:.0f} in a room of {} zones", ceiling_kw, context.counts.vavs + context.counts.fcus),
        "convert the column to kW"));
  }
}

/// A status written as percent or as a byte.
void check_status_unit(LogTable& table, LogColumn& column, std::vector<Remark>& remarks) {
  const auto sorted = sorted_finite(column.value);
  if (sorted.empty() || is_flag(sorted.back())) return;
  const double on = sorted.back();
  if ((on != 100 && on != 255) || share_of(column.value, [on](double v) { return v == 0 || v == on; }) < 1) return;
  for (double& v : column.value) v = v / on;
  remarks.push_back(remark_of(Defect::wrong_unit, Action::fixed, column, table,
                              fmt::format("a status of 0 and {:g}; converted to 0 and 1", on)));
}

// ---- swapped columns

std::string name_pair(const LogColumn& a, const LogColumn& b) { return a.name + " and " + b.name; }

void refuse_pair(const LogTable& table, const LogColumn& a, const LogColumn& b, const std::string& why,
                 std::vector<Remark>& remarks) {
  remarks.push_back(refusal(Defect::swapped, a, table, fmt::format("{} look swapped: {}", name_pair(a, b), why),
                            "each column under its own name",
                            "exchange the names " + name_pair(a, b) + " in the header"));
}

/// A status holds 0 and 1 only, nothing else does.
void check_status_types(const LogTable& table, std::vector<Remark>& remarks) {
  std::vector<const LogColumn*> flags, numbers;
  for (const LogColumn& c : table.columns) {
    if (count_finite(c.value) < least_values) continue;
    const double share = share_of(c.value, is_flag);
    if (!c.facts().status && share > 0.99) flags.push_back(&c);
    if (c.facts().status && share < 0.95) numbers.push_back(&c);
  }
  const double indoor = usual_indoor_degc(table);
  for (const LogColumn* flag : flags) {
    const double usual = flag->facts().indoor && std::isfinite(indoor) ? indoor : flag->facts().temperature ? 20 : 3;
    const auto nearest = std::min_element(numbers.begin(), numbers.end(), [usual](const auto* a, const auto* b) {
      return std::abs(median_of(a->value) - usual) < std::abs(median_of(b->value) - usual);
    });
    if (nearest != numbers.end()) {
      refuse_pair(table, *flag, **nearest, "the first holds a status, the second a number", remarks);
      numbers.erase(nearest);
    } else if (flag->facts().temperature) {
      remarks.push_back(refusal(Defect::swapped, *flag, table, "a status of 0 and 1", "temperatures in degC",
                                "find the column that holds " + flag->name));
    }
  }
  for (const LogColumn* number : numbers) {
    const double m = median_of(number->value);
    if (m >= 0 && m <= 1) continue;  // a share of the time, or a few wrong values
    remarks.push_back(refusal(Defect::swapped, *number, table, fmt::format("numbers about {:.4g}", m),
                              "a status of 0 and 1", "find the column that holds " + number->name));
  }
}

/// The column that looks like an indoor temperature where it should not, if `column` could be what it should be.
const LogColumn* best_exchange(LogTable& table, const LogColumn& column, double indoor_degc) {
  const double shown = median_of(column.value), setpoint = median_of(table.only(Role::setpoint).value);
  const LogColumn* best = nullptr;
  double best_k = 3;
  for (const LogColumn& c : table.columns) {
    const Shown other = shown_of(c);
    const double k = std::abs(other.middle - indoor_degc);
    if (!(k <= best_k) || other.spread() >= 10) continue;
    const bool fits = c.role == Role::power ? shown >= 0
                      : c.role == Role::mau ? shown >= c.facts().low && shown <= c.facts().high
                      : c.role == Role::supply  // which is near its setpoint, and may well be near the rooms
                          ? std::abs(shown - setpoint) < 1 && std::abs(other.middle - setpoint) > 2
                          : false;
    if (fits) best = &c, best_k = k;
  }
  return best;
}

/// An indoor temperature far from all others, and another column where it should be.
void check_indoor_level(LogTable& table, std::vector<Remark>& remarks) {
  const auto indoors = std::count_if(table.columns.begin(), table.columns.end(),
                                     [](const LogColumn& c) { return c.facts().indoor && count_finite(c.value) > 0; });
  const double indoor = usual_indoor_degc(table);
  if (indoors < 3 || !std::isfinite(indoor)) return;
  for (LogColumn& column : table.columns) {
    if (!column.facts().indoor || count_finite(column.value) < least_values) continue;
    const double away_k = std::abs(median_of(column.value) - indoor);
    if (away_k <= 5 || share_of(column.value, is_flag) > 0.99) continue;
    const LogColumn* partner = best_exchange(table, column, indoor);
    const auto in_limits = [&column](double v) { return v >= column.limits.min && v <= column.limits.max; };
    if (partner != nullptr) {
      refuse_pair(table, column, *partner,
                  fmt::format("the other rooms are about {:.1f} degC, as the second is", indoor), remarks);
    } else if (away_k > 10 && share_of(column.value, in_limits) > 0.5) {
      remarks.push_back(remark_of(Defect::implausible, Action::left_out, column, table,
                                  fmt::format("values about {:.4g} where the other rooms are about {:.1f} degC; the "
                                              "column was left out",
                                              median_of(column.value), indoor)));
      std::fill(column.value.begin(), column.value.end(), no_value);
    }
  }
}

/// Share of a column's changes that fall on one of the rows of a cycle; 1/rows for what is measured.
double share_in_step(const LogTable& table, const LogColumn& column, ControlCycle cycle) {
  constexpr std::size_t least_changes = 20;
  std::array<std::size_t, most_rows_per_cycle> changes{};
  std::size_t all = 0;
  const auto& v = column.value;
  for (std::size_t i = 1; i < v.size(); ++i) {
    if (!std::isfinite(v[i] - v[i - 1]) || v[i] == v[i - 1]) continue;
    if (table.time[i].seconds - table.time[i - 1].seconds != row_s) continue;
    ++all;
    ++changes[static_cast<std::size_t>(table.time[i].second_of_day() / row_s % cycle.rows)];
  }
  if (all < least_changes) return no_value;
  return static_cast<double>(*std::max_element(changes.begin(), changes.end())) / static_cast<double>(all);
}

/// A setpoint steps once a control cycle; no measured temperature does, where a cycle is more than a row or two.
void check_setpoint_steps(LogTable& table, ControlCycle cycle, std::vector<Remark>& remarks) {
  if (cycle.rows < default_cycle.rows) return;
  const LogColumn& setpoint = table.only(Role::setpoint);
  if (!(share_in_step(table, setpoint, cycle) < 0.6)) return;
  for (const LogColumn& c : table.columns) {
    if (!c.facts().temperature || c.role == Role::setpoint || !(share_in_step(table, c, cycle) > 0.9)) continue;
    refuse_pair(table, setpoint, c,
                fmt::format("the second steps every {} min, as setpoints do, the first does not", cycle.minutes()),
                remarks);
    return;
  }
}

/// How far a column is from the station's temperature: 90 % of the hours are nearer, as a standard deviation.
double misfit_k(const LogTable& table, const LogColumn& column, int lag_min) {
  constexpr double site_offset_k = 6;  // a sensor or a site may differ by so much
  std::vector<double> k;
  for (std::size_t i = 0; i < column.value.size(); ++i) {
    k.push_back(column.value[i] - table.station.at({table.time[i].seconds - 60 * lag_min}));
  }
  const double offset = std::clamp(median_of(k), -site_offset_k, site_offset_k);
  for (double& v : k) v = std::abs(v - offset);
  return quantile_of_sorted(sorted_finite(k), 0.9) / 1.645;
}

/// No weather stands still for days; where the outdoor column does, another one that swings is the outdoors.
bool refuse_still_outdoor(LogTable& table, std::vector<Remark>& remarks) {
  constexpr double still_k = 1.5, swinging_k = 4;
  const LogColumn& outdoor = table.only(Role::outdoor);
  const double spread_k = shown_of(outdoor).spread();
  if (!(spread_k > 0 && spread_k < still_k) || count_finite(outdoor.value) < 5 * rows_per_day) return false;
  const LogColumn* widest = nullptr;
  double widest_k = swinging_k;
  for (const LogColumn& c : table.columns) {
    const bool measured = c.facts().indoor || c.role == Role::mau;
    if (measured && shown_of(c).spread() > widest_k) widest = &c, widest_k = shown_of(c).spread();
  }
  if (widest == nullptr) return false;
  refuse_pair(table, outdoor, *widest,
              fmt::format("the first stays within {:.1f} K for days, the second moves by {:.1f} K", spread_k, widest_k),
              remarks);
  return true;
}

/// Outdoor temperatures follow the station's; another column that does so much better is theirs.
void check_outdoor(LogTable& table, std::vector<Remark>& remarks) {
  const LogColumn& outdoor = table.only(Role::outdoor);
  if (count_finite(outdoor.value) < least_values || refuse_still_outdoor(table, remarks) || table.station.empty()) {
    return;
  }
  const Following own = follow(table.time, outdoor.value, table.station);
  const double own_misfit_k = misfit_k(table, outdoor, own.known ? own.lag_min : 0);
  if (!(own_misfit_k > 0.8)) return;
  const LogColumn* best = nullptr;
  double best_misfit_k = 0.5 * own_misfit_k;
  for (const LogColumn& c : table.columns) {
    if (!c.facts().temperature || c.role == Role::outdoor) continue;
    const Following f = follow(table.time, c.value, table.station);
    if (!f.known || f.unexplained > 0.36 || f.unexplained > 0.5 * own.unexplained) continue;
    const double k = misfit_k(table, c, f.lag_min);
    if (k < best_misfit_k) best = &c, best_misfit_k = k;
  }
  if (best == nullptr) return;
  refuse_pair(table, outdoor, *best,
              fmt::format("the second follows the station's temperature within {:.1f} K, the first within {:.1f} K",
                          best_misfit_k, own_misfit_k),
              remarks);
}

}  // namespace

void check_units(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks) {
  for (LogColumn& column : table.columns) {
    if (column.facts().status) {
      check_status_unit(table, column, remarks);
    } else if (count_finite(column.value) >= least_values) {
      if (column.facts().temperature)
        check_temperature_unit(table, column, remarks);
      else
        check_power_unit(table, column, context, remarks);
    }
  }
}

void check_swapped(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks) {
  check_status_types(table, remarks);
  check_indoor_level(table, remarks);
  check_setpoint_steps(table, context.cycle, remarks);
  check_outdoor(table, remarks);
}

}  // namespace airside::tools::gap
