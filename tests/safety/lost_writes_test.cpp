// What would go on unseen: writes that never arrive, a reason that nobody judges any more, a step from a setpoint that
// only another state knew.

#include "support/controller_rig.hpp"

namespace airside {
namespace {

using Rig = ControllerRig;
using T = FiveZone;

bool altered(const Rig& rig) { return rig.controller->cycle().mode_arbiter.active(Reason::setpoint_altered, rig.now); }

TEST(LostWrites, AreAnAlarmFromTheSecondOnAndEndWithTheFirstThatArrives) {
  Rig rig;
  rig.cycles(6);
  for (const int lost : {1, 2, 3}) {
    rig.cycles(1, {}, true);
    EXPECT_EQ(altered(rig), lost > 1) << lost;
  }
  EXPECT_EQ(rig.decision().mode, ControlMode::learn) << "and control goes on as far as it can";
  EXPECT_EQ(rig.decision().reason, Reason::setpoint_altered);
  rig.cycles(1);
  EXPECT_FALSE(altered(rig));
  rig.cycles(1, {}, true);
  EXPECT_FALSE(altered(rig)) << "one is none yet";
}

TEST(LostWrites, OfAnAhuThatCannotBeReadHaveAnAlarmOfTheirOwn) {
  Rig rig;
  rig.cycles(6);
  const auto silent = [](const Reading<T>&) -> Expected<Reading<T>> { return tl::unexpected(Fault::no_reading); };
  rig.cycles(4, silent, true);
  EXPECT_FALSE(altered(rig));
  EXPECT_EQ(rig.decision().reason, Reason::no_reading);
}

TEST(GainReversed, EndsWhereTheHeadThatJudgesItIsSwitchedOff) {
  ControllerSettings settings = product_settings();
  settings.head = 0;
  Rig rig(settings);
  rig.cycles(3);
  rig.controller->report(Reason::gain_reversed, true, rig.now);
  EXPECT_EQ(rig.controller->control_mode(rig.now).reason, Reason::gain_reversed);
  rig.cycles(1);
  EXPECT_NE(rig.decision().reason, Reason::gain_reversed);
  EXPECT_LT(rig.decision().mode, ControlMode::expert);
}

TEST(StoredSetpoint, OfAnotherStateIsWhereTheNextStepBegins) {
  ControllerSettings settings = product_settings();
  settings.limit_change_k = 1;
  const auto first_command = [&](const StoredSetpoint& stored) {
    Rig rig(settings);
    rig.controller->take_stored(stored);
    Reading<T> unread = rig.reading();
    unread.setpoint_degc = Rig::nan;
    return rig.controller->decide(rig.now, Expected<Reading<T>>(unread)).command.setpoint_degc();
  };
  const StoredSetpoint nothing;
  const double free = first_command(nothing);
  const double low = free - 4;
  StoredSetpoint known;
  known.is(low);
  EXPECT_LE(first_command(known), low + 1 + 1e-9);
  EXPECT_GT(free, low + 1) << "else this shows nothing";
}

}  // namespace
}  // namespace airside
