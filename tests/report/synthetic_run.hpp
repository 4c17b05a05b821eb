#pragma once
// A made-up fortnight with every part of a report filled in.

#include <cmath>

#include "airside/splitmix64.hpp"
#include "support/default_cycle.hpp"
#include "tools/report/run_report.hpp"

namespace airside::tools {

constexpr CivilTime synthetic_start{18809ll * 86400};  // 2021-07-01

inline double wave(double hours, double period_h, double phase = 0) {
  return std::sin((hours / period_h + phase) * 6.283185307179586);
}

inline Metrics synthetic_metrics(int days, double level, double unrest, double kwh) {
  Metrics m;
  for (int d = 0; d < days; ++d) {
    DayMetrics day;
    day.midnight = {synthetic_start.seconds + d * 86400};
    day.samples = 40;
    day.dae_degc = level * (1 + 0.35 * wave(d * 24, 24 * 5.3, level) + (d == 0 ? 0.4 : 0));
    m.me_degc = std::max(m.me_degc, day.dae_degc);
    m.dae_degc += day.dae_degc / days;
    m.days.push_back(day);
  }
  m.day1_dae_degc = m.days[0].dae_degc;
  m.darv_degc = unrest;
  m.degree_hours_degch = 12 * m.dae_degc;
  m.degree_hours_above_degch = 5 * m.dae_degc;
  m.cdh_degch = 470 + 10 * level;
  m.hvac_kwh_per_day = kwh;
  m.room_dae_degc = {0.21 + level, 0.12 + level, 0.08 + level, 0.17 + level, 0.26 + level};
  return m;
}

inline RunRecord synthetic_run(int days = 14) {
  RunRecord r;
  r.site = "Room 301, Hsinchu";
  r.plant = "RC rooms, variant 301";
  r.weather = "Taichung July, seed 7";
  r.seeds = "1 to 5";
  r.versions = "airside 0.1.0, plant 3";
  r.weights_digest = "b7f1c2d09a4e51f3c88d20a7b6e4f19055d1c0aa9be2734f6d18c0e7a2b93d44";
  r.command =
      "airside simulate --site room301.toml --plant rc --weights room301.blob --days 14 --seeds 1..5 --report out/";
  r.room_names = {"west 1", "west 2", "core", "east 1", "east 2"};
  SplitMix64 random(7);
  const auto noise = [&] { return (static_cast<double>(random.next() >> 11) / 9007199254740992.0 - 0.5); };
  r.room_temp_degc.resize(5);
  for (std::size_t i = 0; i < 5; ++i) r.room_temp_degc[i].name = r.room_names[i];
  r.power_kw = {{"fans", {}}, {"chiller and pump", {}}};
  r.losses = {{"total", {}}, {"short term", {}}, {"long term", {}}};
  for (int i = 0; i < days * rows_per_day; ++i) {
    const double h = i * 0.1, day_hour = std::fmod(h, 24.0);
    const CivilTime t{synthetic_start.seconds + i * row_s};
    const double bump = day_hour > 7 && day_hour < 19 ? 0.25 * wave(day_hour - 7, 12) : 0.1 * wave(h, 24);
    r.row_time.push_back(t);
    double mean = 0;
    for (std::size_t k = 0; k < 5; ++k) {
      const double v = 25.25 + 0.3 * bump + 0.14 * (static_cast<double>(k) - 2) + 0.06 * noise();
      r.room_temp_degc[k].values.push_back(v);
      mean += v / 5;
    }
    r.room_mean_degc.push_back(mean);
    r.outdoor_degc.push_back(30 + 4 * wave(h - 9, 24) + 0.4 * noise());
    r.power_kw[0].values.push_back(0.45 + 0.02 * noise());
    r.power_kw[1].values.push_back(0.5 + (day_hour > 7 && day_hour < 19 ? 0.6 : 0) + 0.2 * wave(h - 9, 24) +
                                   0.05 * noise());
    if (!starts_cycle(t)) continue;
    const bool work = day_hour >= 7 && day_hour < 19;
    const double head = 22.6 - 0.8 * wave(h - 9, 24) + 0.12 * noise();
    r.cycle_time.push_back(t);
    r.expert_setpoint_degc.push_back(work ? 20.5 : 25.0);
    r.head_setpoint_degc.push_back(head);
    r.network_setpoint_degc.push_back(head + 0.25 * wave(h, 31) + 0.1 * noise());
    r.setpoint_degc.push_back(std::round(100 * (head + 0.05 * wave(h, 17))) / 100);
    r.confidence.push_back(1 - 0.5 * std::exp(-h / 6) - 0.03 * std::abs(noise()));
    const double settle = 0.02 + 0.6 * std::exp(-h / 20);
    r.losses[0].values.push_back(settle * (1 + noise()));
    r.losses[1].values.push_back(0.4 * settle * (1 + noise()));
    r.losses[2].values.push_back(0.2 * settle * (1 + 1.5 * noise()));
  }
  const auto method = [&](const char* name, MethodResult::Kind kind, double level, double unrest, double kwh) {
    MethodResult m{name, kind, {}};
    for (int seed = 0; seed < 5; ++seed) {
      m.runs.push_back(
          synthetic_metrics(days, level * (1 + 0.04 * (seed - 2)), unrest * (1 + 0.02 * seed), kwh + 0.1 * seed));
    }
    r.methods.push_back(m);
  };
  using Kind = MethodResult::Kind;
  method("airside", Kind::ours, 0.056, 0.142, 28.7);
  method("expert schedule", Kind::schedule, 1.739, 0, 29.0);
  method("PID, spec gains", Kind::peer, 0.696, 4.15, 29.2);
  method("PID, tuned", Kind::peer, 0.095, 0.199, 28.8);
  method("integral (Ki 5/h)", Kind::peer, 0.099, 0.148, 28.8);
  method("ARX, 2 parameters", Kind::peer, 0.092, 0.178, 28.8);
  method("ARX + exogenous, RLS", Kind::peer, 0.077, 0.225, 28.8);
  method("G36 on site range", Kind::peer, 0.42, 0.31, 28.1);
  method("floor: disturbances frozen", Kind::floor, 0.071, 0.175, 28.8);
  method("floor: full forecast", Kind::floor, 0.011, 0.146, 28.8);
  return r;
}

}  // namespace airside::tools
