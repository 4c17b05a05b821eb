#include "tools/study/metered_model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "tools/run/control_run.hpp"

namespace airside::tools {

namespace {

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

double BuildingFigures::total_kwh() const { return std::accumulate(kwh_per_day.begin(), kwh_per_day.end(), 0.0); }

nlohmann::json json_of(const BuildingFigures& f) {
  return {{"dae_degc", f.dae_degc},       {"above_degch", f.above_degch},     {"below_degch", f.below_degch},
          {"saturated_h", f.saturated_h}, {"setpoint_degc", f.setpoint_degc}, {"darv_degc", f.darv_degc},
          {"kwh_per_day", f.kwh_per_day}};
}

BuildingFigures figures_of(const nlohmann::json& j) {
  BuildingFigures f;
  f.dae_degc = j.at("dae_degc");
  f.above_degch = j.at("above_degch");
  f.below_degch = j.at("below_degch");
  f.saturated_h = j.at("saturated_h");
  f.setpoint_degc = j.at("setpoint_degc");
  f.darv_degc = j.at("darv_degc");
  f.kwh_per_day = j.at("kwh_per_day").get<std::vector<double>>();
  return f;
}

MeteredModel::MeteredModel(sim::PlantModel& inner, const Site& site, CivilTime from)
    : inner_(inner), site_(site), from_(from) {
  sums_.kwh_per_day.assign(inner.sensors().power_kw.size(), 0);
}

void MeteredModel::advance_to(CivilTime t) {
  while (inner_.time() < t) {
    const CivilTime now = inner_.time();
    const bool counts = !(now < from_);
    if (counts && control_cycle(site_.settings).starts(now)) count_cycle();
    const CivilTime next{std::min(t.seconds, now.seconds + step_s())};
    inner_.advance_to(next);
    if (counts) count_step(static_cast<double>(next.seconds - now.seconds) / 3600);
  }
}

void MeteredModel::count_step(double hours) {
  const sim::Sensors& now = inner_.sensors();
  counted_h_ += hours;
  for (std::size_t i = 0; i < sums_.kwh_per_day.size(); ++i) {
    if (std::isfinite(now.power_kw[i])) sums_.kwh_per_day[i] += now.power_kw[i] * hours;
  }
  const bool people =
      std::isfinite(now.occupied) ? now.occupied > 0.5 : is_scored(inner_.time(), metrics_settings(site_));
  if (people) count_comfort(now, hours);
}

void MeteredModel::count_comfort(const sim::Sensors& now, double hours) {
  const auto at = [](const std::vector<double>& list, std::size_t i) {
    return i < list.size() ? list[i] : sim::not_shown;
  };
  for (std::size_t i = 0; i < now.room_temp_degc.size(); ++i) {
    const double room = now.room_temp_degc[i];
    sums_.above_degch += too_warm_k(room, at(now.zone_setpoint_degc, i)) * hours;
    sums_.below_degch += too_cold_k(room, at(now.heating_setpoint_degc, i)) * hours;
    if (at(now.damper, i) > open_damper) sums_.saturated_h += hours;
  }
}

void MeteredModel::count_cycle() {
  const sim::Sensors& now = inner_.sensors();
  cycles_.push_back({inner_.time(), mean_of(now.room_temp_degc), now.room_temp_degc, now.setpoint_degc});
}

BuildingFigures MeteredModel::figures() const {
  if (counted_h_ < 24) throw std::logic_error("figures of less than a day");
  const MetricsSettings scored = metrics_settings(site_);
  const Metrics metrics = compute_metrics(cycles_, {}, scored);
  BuildingFigures f = sums_;
  f.dae_degc = metrics.dae_degc;
  f.darv_degc = metrics.darv_degc;
  std::vector<double> setpoints;
  for (const CycleSample& cycle : cycles_) {
    if (is_scored(cycle.time, scored)) setpoints.push_back(cycle.setpoint_degc);
  }
  f.setpoint_degc = mean_of(setpoints);
  const double days = counted_h_ / 24;
  for (double& kwh : f.kwh_per_day) kwh /= days;
  f.above_degch /= days;
  f.below_degch /= days;
  f.saturated_h /= days;
  return f;
}

}  // namespace airside::tools
