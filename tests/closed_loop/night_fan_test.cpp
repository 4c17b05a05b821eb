// An AHU whose fan rests at night: the rooms warm up by kelvins, and the first hours after the start are sound.

#include <cmath>
#include <fstream>

#include "hal/site/site_settings.hpp"
#include "support/bench.hpp"
#include "support/test_folder.hpp"
#include "tools/run/training/pretraining.hpp"

namespace airside::closed_loop {
namespace {

/// Mean distance from the target in the hours from `from_h` until `to_h`, the first day left out, K.
double mean_error_k(const tools::Site& site, const tools::ControlRun& run, double from_h, double to_h) {
  double sum = 0;
  int rows = 0;
  for (const hal::LogRow& row : run.rows) {
    const double h = row.time.second_of_day() / 3600.0;
    if (row.time.seconds < run.rows.front().time.seconds + seconds_per_day || h < from_h || h >= to_h) continue;
    double mean = 0;
    for (int i = 0; i < site.counts.vavs; ++i) mean += row.value[static_cast<std::size_t>(i)] / site.counts.vavs;
    sum += std::abs(mean - site.settings.target_degc);
    ++rows;
  }
  return sum / rows;
}

TEST(NightFan, FirstHoursAfterANightOffAreNotWorseThanTheTunedIntegrals) {
  const hal::TestFolder folder("night_fan");
  const auto room = [&](const char* base, const char* name) {
    const std::string path = folder.file(name).string();
    std::ofstream(path) << "{\"base\": \"" << base << "\", \"ahu_stop_from_h\": 20, \"ahu_stop_to_h\": 6}\n";
    return path;
  };
  tools::Site site = tools::built_in_site();
  site.file.fan_start_s = 6 * 3600;
  site.file.fan_end_s = 20 * 3600;
  site.settings = hal::controller_settings(site.file, site.points);
  const tools::PlantChoice twin = rc_room(room("401", "twin.json"), "2021-07-01");
  const auto model = tools::make_plant(twin, site, 10);
  const tools::BlobBytes blob =
      tools::pretrain(site, *model, {tools::start_of(twin).seconds + 10 * seconds_per_day}, {}).blob;
  const tools::Trial trial{site, rc_room(room("401-real", "real.json")), 5, 6};
  tools::Prepared prepared = tools::prepare(trial);
  const tools::ControlRun ours = tools::run_ours(trial, prepared, {blob, true, 1000});
  tools::Prepared again = tools::prepare(trial);
  const tools::ControlRun integral = tools::run_method(trial, again, "integral-tuned");
  EXPECT_GT(mean_error_k(site, ours, 0, 6), 3.0) << "the fan does rest";
  EXPECT_LT(mean_error_k(site, ours, 6, 7), mean_error_k(site, integral, 6, 7));
  EXPECT_LT(mean_error_k(site, ours, 7, 8), mean_error_k(site, integral, 7, 8));
  EXPECT_LT(mean_error_k(site, ours, 7, 8), 0.10);
  EXPECT_LT(mean_error_k(site, ours, 7, 19), mean_error_k(site, integral, 7, 19));
  for (const hal::LogRow& row : ours.rows) {
    const double h = row.time.second_of_day() / 3600.0;
    if (h >= 6 && h < 20.1) continue;
    EXPECT_TRUE(std::isnan(row.controller.loss_strb)) << "nothing is judged in still air";
  }
}

}  // namespace
}  // namespace airside::closed_loop
