// A transfer is never worse than none: the days that were held back choose between fine-tuned weights and the source's.

#include "tools/run/training/transfer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <span>

#include "airside/controller/instances.hpp"
#include "sim/rc/rc_plant.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/run/site.hpp"
#include "tools/run/training/pretraining.hpp"

namespace airside::tools {
namespace {

constexpr CivilTime start{1'627'776'000};  // 2021-08-01

std::vector<hal::LogRow> schedule_days(const Site& site, const sim::RcRoom& room, int days) {
  sim::RcPlant plant(room, sim::synthetic_weather(3), start, 5, 25);
  return run_schedule(site, plant, {start.seconds + days * 86400LL}).rows;
}

std::vector<float> weights_of(const BlobBytes& blob) {
  auto payload = std::make_unique<WeightBlob<FiveZone>::Payload>();
  EXPECT_TRUE(WeightBlob<FiveZone>::decode(blob, {}, *payload));
  return {payload->weights.begin(), payload->weights.end()};
}

class Transfer : public testing::Test {
 protected:
  const Site site = built_in_site();
  BlobBytes source;
  FineTuneOptions options;

  void SetUp() override {
    sim::RcPlant twin(sim::make_room(), sim::synthetic_weather(3), start, 9, 25);
    PretrainOptions pretrained;
    pretrained.provenance = "test";
    source = pretrain(site, twin, {start.seconds + 6 * 86400LL}, pretrained).blob;
    options.steps = 40;
    options.provenance = "fine-tuned";
  }
};

TEST_F(Transfer, KeepsTheSourceWhereItPredictsTheHeldBackRowsBetter) {
  // The room of the source itself, and a short log: what it learned in days of moving setpoints is better.
  const auto rows = schedule_days(site, sim::make_room(), 1);
  const Transferred made = transfer(site, source, rows, options);
  EXPECT_GT(made.source_error_k, 0);
  EXPECT_LT(made.source_error_k, made.tuned_error_k);
  EXPECT_TRUE(made.source_kept);
  EXPECT_EQ(weights_of(made.blob), weights_of(source));
}

TEST_F(Transfer, FineTunesWhereThatPredictsTheHeldBackDayBetter) {
  sim::RcRoom other = sim::perturbed_room(sim::make_room(), 77);
  other.occupancy_shift_h = 3;
  other.gain_occupied_w_m2 = 40;
  const auto rows = schedule_days(site, other, 6);
  const Transferred made = transfer(site, source, rows, options);
  EXPECT_GT(made.source_error_k, made.tuned_error_k);
  EXPECT_FALSE(made.source_kept);
  EXPECT_EQ(made.blob, fine_tune(site, source, rows, options)) << "all rows, the held-back ones too";
}

TEST_F(Transfer, ComparesNothingFromScratchOrWithoutARoomHead) {
  const auto rows = schedule_days(site, sim::make_room(), 1);
  const Transferred scratch = transfer(site, {}, rows, options);
  EXPECT_TRUE(std::isnan(scratch.tuned_error_k));
  EXPECT_FALSE(scratch.source_kept);
  const Site paper = with_preset(site, hal::ControllerPreset::paper);
  EXPECT_TRUE(std::isnan(transfer(paper, source, rows, options).tuned_error_k));
}

TEST_F(Transfer, ForecastErrorTellsTheRoomsOwnWeightsFromThoseOfAnother) {
  sim::RcRoom other = sim::perturbed_room(sim::make_room(), 77);
  other.occupancy_shift_h = 3;
  other.gain_occupied_w_m2 = 40;
  const BlobBytes of_other = fine_tune(site, source, schedule_days(site, other, 6), options);
  const auto rows = schedule_days(site, sim::make_room(), 2);
  EXPECT_LT(forecast_error_k(site, source, rows), forecast_error_k(site, of_other, rows));
  EXPECT_TRUE(std::isnan(forecast_error_k(site, source, std::span(rows).first(1)))) << "nothing to foretell";
}

}  // namespace
}  // namespace airside::tools
