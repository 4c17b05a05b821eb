#pragma once
// A building of four zones by formula: each holds its temperature by its damper at once, power follows known laws.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "airside/demand/band_objective.hpp"

namespace airside::demand_test {

struct FormulaBuilding {
  double fan_kw = 3.0;       ///< at full flow, by F^3
  double thermal_kw = 20.0;  ///< all dampers open, 10 K
  double cop = 4.0;
  bool economizer = true;
  double supply_degc = 14.0;
  double outdoor_degc = 18.0;
  std::array<double, 4> load_k = {5.0, 6.0, 4.0, 5.5};
  std::array<double, 4> room_degc = {24, 24, 24, 24};
  double setpoint_degc = 24;
  double smallest = 0.15;

  std::vector<double> room, set, damper, power;

  double damper_of(std::size_t i, double supply) const {
    return std::clamp(load_k[i] / (room_degc[i] - supply), smallest, 1.0);
  }
  double flow(double supply) const {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += damper_of(i, supply);
    return sum / 4;
  }
  double fan(double supply) const { return fan_kw * std::pow(flow(supply), 3); }
  double cooling(double supply) const {
    const double f = flow(supply), lift = room_degc[0] - supply;
    const double saved = economizer ? std::clamp(room_degc[0] - outdoor_degc, 0.0, lift) : 0.0;
    return thermal_kw / cop * f * (lift - saved) / 10;
  }
  double total(double supply) const { return fan(supply) + cooling(supply); }

  DemandReading read(CivilTime t) {
    room.assign(room_degc.begin(), room_degc.end());
    set.assign(4, setpoint_degc);
    damper.clear();
    for (std::size_t i = 0; i < 4; ++i) damper.push_back(damper_of(i, supply_degc));
    power = {fan(supply_degc), cooling(supply_degc)};
    DemandReading at;
    at.time = t;
    at.zones = {room, set, damper};
    at.power_kw = power;
    at.supply_degc = supply_degc;
    at.outdoor_degc = outdoor_degc;
    return at;
  }

  /// `days` whose loads and outdoor temperatures go up and down, under constant supply temperature.
  void live(const DemandSettings& s, BandObjective& objective, int days, CivilTime from = {}) {
    const std::array<double, 4> usual = load_k;
    for (int row = 0; row < days * rows_per_day; ++row) {
      const CivilTime t{from.seconds + row * row_s};
      const double hour = t.second_of_day() / 3600.0;
      for (std::size_t i = 0; i < 4; ++i) {
        const double phase = hour + 2 * static_cast<double>(i);
        load_k[i] = usual[i] * (0.7 + 0.4 * std::sin(phase * 0.2618) + 0.1 * std::sin(phase * 1.7));
      }
      outdoor_degc = 19 + 7 * std::sin((hour - 9) * 0.2618) + 2 * std::sin(static_cast<double>(row) / rows_per_day);
      objective.observe(s, read(t));
    }
    load_k = usual;
  }
};

}  // namespace airside::demand_test
