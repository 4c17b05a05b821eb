#include "tools/study/box_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "airside/demand/band_objective.hpp"
#include "airside/demand/zone_guideline36.hpp"
#include "airside/presets.hpp"
#include "airside/supervision/envelope.hpp"
#include "sim/rc/modulating_plant.hpp"
#include "sim/weather/synthetic_weather.hpp"

namespace airside::tools {

namespace {

/// Chooses the setpoint of every 3-min step.
class BoxChooser {
 public:
  BoxChooser(const BoxRun& run, const BoxMethod& method) : run_(run), method_(method), site_(box_site_settings()) {
    objective_.reset(method.demand);
    guideline_ = guideline36_as_written(method.degc);
    guideline_.period_s = sim::ModulatingPlant::step_s;
    choice_ = {.min_degc = site_.action_min_degc,
               .max_degc = site_.action_max_degc,
               .step_k = site_.action_step_k,
               .schedule_degc = site_.expert_work_degc};
  }

  double setpoint_degc(const sim::ModulatingPlant& plant) {
    const bool before = plant.time() < run_.from;
    if (method_.kind == BoxMethod::Kind::band) return band(plant, before);
    double wanted = method_.degc;
    if (method_.kind == BoxMethod::Kind::guideline36) {
      const ZoneSignals zones{plant.sensors().room_temp_degc, plant.boxes().zone_setpoint_degc, plant.boxes().damper};
      wanted = guideline36_.setpoint_degc(guideline_, zones, plant.sensors().outdoor_temp_degc,
                                          plant.boxes().fan_runs > 0.5);
    }
    return limited(before ? site_.expert_work_degc : wanted);
  }

 private:
  double band(const sim::ModulatingPlant& plant, bool before) {
    const CivilTime t = plant.time();
    if (t.second_of_day() % row_s != 0) return last_degc_;
    const double blind_s = static_cast<double>(t.seconds - run_.from.seconds) - run_.blind_from_day * 86400;
    dampers_ = plant.boxes().damper;
    if (blind_s >= 0) std::fill(dampers_.begin(), dampers_.end(), std::numeric_limits<double>::quiet_NaN());
    DemandReading at;
    at.time = t;
    at.zones = {plant.sensors().room_temp_degc, plant.boxes().zone_setpoint_degc, dampers_,
                plant.sensors().heating_setpoint_degc};
    at.power_kw = plant.sensors().power_kw;
    at.supply_degc = plant.sensors().supply_temp_degc;
    at.outdoor_degc = plant.sensors().outdoor_temp_degc;
    at.flow_m3_s = plant.boxes().supply_flow_m3_s;
    at.flows = plant.boxes().fan_runs > 0.5;
    at.coldest = last_degc_ <= choice_.min_degc + 0.05;
    at.warmest = last_degc_ >= choice_.max_degc - 0.05;
    objective_.observe(method_.demand, at);
    if (!band_cycle.starts(t)) return last_degc_;
    choice_.last_degc = last_degc_;
    const double chosen = objective_.choose(method_.demand, at, choice_).setpoint_degc;
    return limited(before ? site_.expert_work_degc : chosen);
  }

  double limited(double wanted_degc) {
    const SafetyEnvelope envelope(site_);
    last_degc_ = envelope.limit(wanted_degc, last_degc_, site_.expert_work_degc).setpoint_degc();
    return last_degc_;
  }

  BoxRun run_;
  BoxMethod method_;
  ControllerSettings site_;
  BandObjective objective_;
  ZoneGuideline36 guideline36_;
  Guideline36Settings guideline_;
  DemandChoice choice_;
  std::vector<double> dampers_;
  double last_degc_ = std::numeric_limits<double>::quiet_NaN();
};

/// Mean |second difference| of successive cycles' setpoints, a day's sum over n - 3 terms.
class DarvCount {
 public:
  void add(double setpoint_degc) {
    if (n_ >= 2) sum_ += std::abs(setpoint_degc - 2 * last_ + before_);
    before_ = last_;
    last_ = setpoint_degc;
    ++n_;
  }
  void end_day() {
    if (n_ > 3) days_ += sum_ / (n_ - 3);
    n_ = 0;
    sum_ = 0;
  }
  double sum_of_days() const { return days_; }

 private:
  double last_ = 0, before_ = 0, sum_ = 0, days_ = 0;
  int n_ = 0;
};

}  // namespace

std::string BoxMethod::name() const {
  switch (kind) {
    case Kind::constant: return fmt::format("constant {:.1f}", degc);
    case Kind::guideline36: return fmt::format("guideline-36, {:.0f}", degc);
    case Kind::band: return "band";
  }
  return "unknown";
}

ControllerSettings box_site_settings() {
  ControllerSettings s = product_settings();
  s.action_min_degc = s.limit_min_degc = 12;
  s.action_max_degc = s.limit_max_degc = 18;
  s.expert_work_degc = s.expert_off_degc = 14;
  return s;
}

BoxFigures run_boxes(const BoxRun& run, const BoxMethod& method) {
  const sim::ModulatingRoom room = sim::modulating_room(run.scenario, run.seed);
  const CivilTime begin{run.from.seconds - run.schedule_days * seconds_per_day};
  const CivilTime end{run.from.seconds + run.days * seconds_per_day};
  sim::ModulatingPlant plant(room, sim::synthetic_weather(run.seed + 77, room.climate), begin, run.seed);
  BoxChooser chooser(run, method);
  sim::ModulatingEnergy energy;
  sim::ZoneComfort comfort;
  DarvCount darv;
  BoxFigures f;
  f.lowest_degc = HUGE_VAL;
  f.highest_degc = -HUGE_VAL;
  int samples = 0;
  while (plant.time() < end) {
    const CivilTime t = plant.time();
    if (t == run.from) energy = plant.energy(), comfort = plant.comfort();
    const double setpoint = chooser.setpoint_degc(plant);
    plant.set_setpoint(setpoint);
    f.lowest_degc = std::min(f.lowest_degc, setpoint);
    f.highest_degc = std::max(f.highest_degc, setpoint);
    if (t >= run.from && band_cycle.starts(t)) {
      if (t.second_of_day() == 0) darv.end_day();
      if (plant.boxes().occupied > 0.5) f.setpoint_degc += setpoint, ++samples, darv.add(setpoint);
    }
    plant.advance_to({t.seconds + sim::ModulatingPlant::step_s});
  }
  darv.end_day();
  const double days = run.days;
  f.fan_kwh = (plant.energy().fan_kwh - energy.fan_kwh) / days;
  f.cooling_kwh = (plant.energy().cooling_kwh - energy.cooling_kwh) / days;
  f.heat_kwh = (plant.energy().reheat_kwh - energy.reheat_kwh) / days;
  f.above_degch = (plant.comfort().above_degch - comfort.above_degch) / days;
  f.below_degch = (plant.comfort().below_degch - comfort.below_degch) / days;
  f.saturated_h = (plant.comfort().saturated_h - comfort.saturated_h) / days;
  f.setpoint_degc /= std::max(1, samples);
  f.darv_degc = darv.sum_of_days() / days;
  return f;
}

std::size_t best_constant(const std::vector<BoxFigures>& figures) {
  double fewest = HUGE_VAL;
  for (const BoxFigures& f : figures) fewest = std::min(fewest, f.above_degch);
  std::size_t best = 0;
  double least = HUGE_VAL;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    if (figures[i].above_degch > fewest + 0.25 || figures[i].total_kwh() >= least) continue;
    least = figures[i].total_kwh();
    best = i;
  }
  return best;
}

}  // namespace airside::tools
