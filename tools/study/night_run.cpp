#include "tools/study/night_run.hpp"

#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "hal/site/site_settings.hpp"
#include "tools/run/training/pretraining.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools {

namespace {

/// Mean of what was added.
struct MeanError {
  double sum = 0;
  int rows = 0;
  void add(double error) {
    sum += error;
    ++rows;
  }
  double value() const {
    if (rows == 0) throw std::invalid_argument("night_figures: no row in the hours after the fan's start");
    return sum / rows;
  }
};

PlantChoice resting(PlantChoice room, const NightRun& run) {
  room.fan_start_h = run.fan_start_h;
  room.fan_stop_h = run.fan_stop_h;
  return room;
}

}  // namespace

NightFigures night_figures(const Site& site, std::span<const hal::LogRow> rows, double fan_start_h) {
  MeanError first_hour, three_hours, working, first_day;
  const auto vavs = static_cast<std::size_t>(site.counts.vavs);
  for (const hal::LogRow& row : rows) {
    const double h = row.time.second_of_day() / 3600.0;
    double mean = 0;
    for (std::size_t i = 0; i < vavs; ++i) mean += row.value[i] / static_cast<double>(vavs);
    const double error = std::abs(mean - site.settings.target_degc);
    const double since = h - fan_start_h;
    if (since >= 0 && since < 1) first_hour.add(error);
    if (since >= 0 && since < 3) three_hours.add(error);
    if (h >= site.settings.work_start_h && h < site.settings.work_end_h) working.add(error);
    if (since >= 0 && since < 3 && row.time.seconds < rows.front().time.seconds + seconds_per_day) first_day.add(error);
  }
  return {first_hour.value(), three_hours.value(), working.value(), first_day.value()};
}

Site resting_site(double fan_start_h, double fan_stop_h) {
  Site site = built_in_site();
  site.file.fan_start_s = static_cast<int>(std::lround(fan_start_h * 3600));
  site.file.fan_end_s = static_cast<int>(std::lround(fan_stop_h * 3600));
  site.settings = hal::controller_settings(site.file, site.points);
  return site;
}

NightFigures run_nights(const NightRun& run, const std::string& method) {
  Trial trial{resting_site(run.fan_start_h, run.fan_stop_h), resting(run.room, run), run.expert_days, run.days};
  trial.site.file.seed = run.room.seed;
  Prepared prepared = prepare(trial);
  if (method != "ours-product")
    return night_figures(trial.site, run_method(trial, prepared, method).rows, run.fan_start_h);
  const PlantChoice choice = resting(run.twin, run);
  const auto twin = make_plant(choice, trial.site, run.pretrain_days);
  PretrainOptions options;
  options.seed = choice.seed;
  const CivilTime until{twin->time().seconds + run.pretrain_days * seconds_per_day};
  const BlobBytes blob = pretrain(trial.site, *twin, until, options).blob;
  return night_figures(trial.site, run_ours(trial, prepared, {blob, true, run.steps}).rows, run.fan_start_h);
}

}  // namespace airside::tools
