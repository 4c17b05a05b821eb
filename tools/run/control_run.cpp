#include "tools/run/control_run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "hal/weights/blob_file.hpp"
#include "tools/run/control_loop.hpp"

namespace airside::tools {

MetricsSettings metrics_settings(const Site& site) {
  MetricsSettings m;
  m.target_degc = site.settings.target_degc;
  m.work_start_s = static_cast<int>(std::lround(site.settings.work_start_h * 3600));
  m.work_end_s = static_cast<int>(std::lround(site.settings.work_end_h * 3600));
  m.cycle_s = control_cycle(site.settings).seconds();
  m.weekdays_only = site.settings.weekday_only != 0;
  return m;
}

Metrics metrics_of(const Site& site, const ControlRun& run) {
  return compute_metrics(run.cycles, run.energy, metrics_settings(site));
}

ControlRun run_schedule(const Site& site, sim::PlantModel& plant, CivilTime until, const OnProgress& progress) {
  ControlRun run;
  for_topology_of(site, [&]<class T>(T) {
    run = run_chooser<T>(
        site, site.settings, plant, until, progress, control_cycle(site.settings).seconds(),
        [&site](CivilTime t, const Reading<T>&, double) { return expert_setpoint_degc(site.settings, t); });
  });
  return run;
}

ControlRun run_controller(const Site& site, sim::PlantModel& plant, const BlobBytes& blob,
                          const std::vector<hal::LogRow>& history, CivilTime until, std::uint64_t seed,
                          const OnProgress& progress) {
  ControlRun run;
  for_topology_of(site, [&]<class T>(T) {
    auto controller = make_controller<T>(site, site.settings, seed);
    if (!blob.empty()) {
      auto payload = std::make_unique<SitePayload<T>>();
      payload->site = shape_of<T>(site);
      payload->cycle = control_cycle(site.settings);
      hal::decode_blob<T>(blob, site.file.scope, "weights", *payload);
      take_payload<T>(*controller, *payload);
    }
    if (uses_history(site.settings, !blob.empty()))
      read_history<T>(site, *controller, history, HistoryReader<T>::Head::leave);
    run = control<T>(site, plant, *controller, until, progress);
  });
  return run;
}

ControlRun run_baseline(const Site& site, sim::PlantModel& plant, BaselineController& baseline,
                        const std::vector<hal::LogRow>& history, CivilTime until, const OnProgress& progress) {
  const int cycle_s = control_cycle(site.settings).seconds();
  const int period_s = baseline.decision_period_s(cycle_s);
  if (period_s <= 0 || period_s % row_s != 0 || cycle_s % period_s != 0) {
    throw std::logic_error(fmt::format("{}: a period of {} s; rows are {} s apart, cycles {} s", baseline.name(),
                                       period_s, row_s, cycle_s));
  }
  ControllerSettings limits = site.settings;
  if (!baseline.keeps_to_site()) {
    limits.limit_min_degc = 0;
    limits.limit_max_degc = limits.limit_change_k = 50;
  }
  ControlRun run;
  for_topology_of(site, [&]<class T>(T) {
    using L = Layout<T>;
    const auto sensors_of = [&site](const typename Reading<T>::Vector& value) {
      sim::Sensors s;
      const auto part = [&value](int at, int n) {
        return std::vector<double>(value.data() + at, value.data() + at + n);
      };
      const hal::TopologyCounts& n = site.counts;
      s.room_temp_degc = part(L::room_temp, n.vavs);
      s.fcu_temp_degc = part(L::fcu_temp, n.fcus);
      s.vav_on = part(L::vav_on, n.vavs);
      s.fcu_on = part(L::fcu_on, n.fcus);
      s.power_kw = part(L::power, n.powers);
      s.mau_temp_degc = value[L::mau_temp];
      s.outdoor_temp_degc = value[L::outdoor_temp];
      s.rain = value[L::rain];
      return s;
    };
    std::vector<HistoryRow> past;
    for (const hal::LogRow& row : history) {
      past.push_back({row.time, sensors_of(hal::signals_of<T>(row, shape_of<T>(site))), row.setpoint_degc});
    }
    baseline.observe_history(past);
    double last_known = history.empty() ? plant.sensors().setpoint_degc : history.back().setpoint_degc;
    run = run_chooser<T>(site, limits, plant, until, progress, period_s,
                         [&](CivilTime t, const Reading<T>& reading, double last) {
                           CycleObservation now;
                           now.time = t;
                           now.sensors = sensors_of(reading.value);
                           now.sensors.setpoint_degc = reading.setpoint_degc;
                           now.sensors.supply_temp_degc = reading.supply_temp_degc;
                           now.previous_setpoint_degc = std::isfinite(last) ? last : last_known;
                           now.target_degc = site.settings.target_degc;
                           return baseline.decide(now);
                         });
  });
  return run;
}

ControlRun run_setpoints(const Site& site, sim::PlantModel& plant, const std::function<double()>& choose,
                         CivilTime until, const OnProgress& progress) {
  ControlRun run;
  for_topology_of(site, [&]<class T>(T) {
    run = run_chooser<T>(site, site.settings, plant, until, progress, control_cycle(site.settings).seconds(),
                         [&](CivilTime, const Reading<T>&, double) { return choose(); });
  });
  return run;
}

BlobBytes read_blob(const std::string& path, const Site& site) {
  BlobBytes bytes = hal::read_blob_file(path);
  for_topology_of(site, [&]<class T>(T) {
    auto payload = std::make_unique<SitePayload<T>>();
    payload->site = shape_of<T>(site);
    payload->cycle = control_cycle(site.settings);
    hal::decode_blob<T>(bytes, site.file.scope, path, *payload);
  });
  return bytes;
}

std::size_t most_blob_bytes(const Site& site) {
  std::size_t bytes = 0;
  for_topology_of(site, [&]<class T>(T) { bytes = sizeof(BlobHeader) + sizeof(SitePayload<T>); });
  return bytes;
}

}  // namespace airside::tools
