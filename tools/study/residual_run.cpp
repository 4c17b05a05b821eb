#include "tools/study/residual_run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>

#include "hal/text/civil_text.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/rc/disturbance.hpp"
#include "sim/rc/rc_plant.hpp"
#include "sim/weather/epw.hpp"

namespace airside::tools {

namespace {

constexpr int training_steps = 300;  // the head is what is looked at, not the network
constexpr int cycles_ahead = 3;

std::shared_ptr<const sim::Weather> weather_of(const Trial& trial) {
  if (!trial.plant.weather.empty()) return sim::read_epw(trial.plant.weather);
  if (!is_energyplus(trial.plant, trial.site)) return made_up_weather(trial.plant);
  return sim::read_epw(sim::default_weather(sim::find_energyplus()).string());
}

/// NaN where the room is none of whose people anything is known.
double people_w(const sim::RcPlant* plant, std::uint64_t seed, CivilTime t) {
  if (plant == nullptr) return std::numeric_limits<double>::quiet_NaN();
  sim::Disturbance at;
  sim::disturb(plant->room(), plant->weather(), sim::seed_in_room(plant->room(), seed), t, at);
  return std::accumulate(at.gain_w.begin(), at.gain_w.end(), 0.0);
}

void add_number(std::string& line, double value) {
  line += ',';
  if (std::isfinite(value)) line += fmt::format("{:.6g}", value);
}

std::string header_of(const hal::TopologyCounts& counts, int signals, int cycle_min) {
  std::string line = "time,setpoint_degc,head_error_k";
  for (const char* before : {"", "before_"}) {
    for (int i = 0; i < signals; ++i) line += fmt::format(",{}{}", before, hal::column_of(counts, i));
  }
  for (int i = 0; i <= cycles_ahead; ++i) line += fmt::format(",outdoor_{0}_degc,sun_{0}_w_m2", i * cycle_min);
  return line + fmt::format(",people_w,people_{}_w\n", cycle_min);
}

}  // namespace

std::string residual_csv(const Trial& trial) {
  Prepared prepared = prepare(trial);
  const ControlRun run = run_ours(trial, prepared, {{}, true, training_steps});
  const auto* rc = dynamic_cast<const sim::RcPlant*>(prepared.model.get());
  const auto weather = weather_of(trial);
  const int signals = static_cast<int>(run.rows.front().value.size());
  const ControlCycle cycle = control_cycle(trial.site.settings);
  std::string text = header_of(trial.site.counts, signals, cycle.minutes());
  for (std::size_t i = 1, k = 0; i < run.rows.size(); ++i) {
    const hal::LogRow &row = run.rows[i], &before = run.rows[i - 1];
    if (!cycle.starts(row.time)) continue;
    while (k + 1 < run.cycles.size() && run.cycles[k].time.seconds < row.time.seconds) ++k;
    text += hal::civil_text(row.time);
    add_number(text, row.setpoint_degc);
    add_number(text, run.cycles[k].head_error_k);
    for (const double v : row.value) add_number(text, v);
    for (const double v : before.value) add_number(text, v);
    for (int ahead = 0; ahead <= cycles_ahead; ++ahead) {
      const sim::WeatherRecord then = weather->at({row.time.seconds + ahead * cycle.seconds()});
      add_number(text, then.outdoor_temp_degc);
      add_number(text, then.global_horizontal_w_m2);
    }
    for (int ahead = 0; ahead <= 1; ++ahead)
      add_number(text, people_w(rc, trial.plant.seed, {row.time.seconds + ahead * cycle.seconds()}));
    text += '\n';
  }
  return text;
}

}  // namespace airside::tools
