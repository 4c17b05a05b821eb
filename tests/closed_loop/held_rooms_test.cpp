// Which value of the rooms is held decides which rooms are near the target (docs/method.md 16.7).

#include <gtest/gtest.h>

#include <cstdio>

#include "support/bench.hpp"
#include "tools/run/training/pretraining.hpp"

namespace airside::closed_loop {
namespace {

/// Four days of control after five under the schedule, by weights that were pretrained on the twin under the same rule.
tools::Metrics four_days(const HeldRooms& held) {
  tools::Trial trial{tools::built_in_site(), rc_room("701-real"), 5, 4};
  trial.site.file.held = trial.site.settings.held = held;
  const tools::PlantChoice twin = rc_room("701", "2021-07-01");
  const auto model = tools::make_plant(twin, trial.site, 5);
  const auto blob = tools::pretrain(trial.site, *model, {tools::start_of(twin).seconds + 5 * 86400}, {}).blob;
  tools::Prepared prepared = tools::prepare(trial);
  return tools::metrics_of(
      trial.site, tools::run_controller(trial.site, *prepared.model, blob, prepared.history, prepared.until, 1));
}

TEST(HeldRooms, MiddleBringsTheWorstRoomNearerAndAWeightBringsItsRoomNearer) {
  const tools::Metrics mean = four_days({}), middle = four_days({HoldRule::middle});
  std::size_t worst = 0;
  for (std::size_t r = 1; r < mean.room_dae_degc.size(); ++r) {
    if (mean.room_dae_degc[r] > mean.room_dae_degc[worst]) worst = r;
  }
  HeldRooms one{HoldRule::weighted, {1, 1, 1, 1, 1}};
  one.weights[worst] = 4;
  const tools::Metrics weighted = four_days(one);
  std::printf(
      "mean: DAE %.3f, worst room %.3f; middle: DAE %.3f, worst room %.3f; room %zu: %.3f, with weight 4 %.3f\n",
      mean.dae_degc, mean.worst_room_dae_degc, middle.dae_degc, middle.worst_room_dae_degc, worst + 1,
      mean.room_dae_degc[worst], weighted.room_dae_degc[worst]);
  EXPECT_LT(middle.worst_room_dae_degc, mean.worst_room_dae_degc);
  EXPECT_LT(mean.dae_degc, middle.dae_degc) << "what is not held is further off";
  EXPECT_LT(weighted.room_dae_degc[worst], mean.room_dae_degc[worst]);
}

}  // namespace
}  // namespace airside::closed_loop
