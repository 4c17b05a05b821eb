// The objective band under every fault of what it sees, alone and in pairs: nothing unsafe is written, the schedule
// takes over where signals are lost, what was learned stays usable, and control comes back. AIRSIDE_BAND_CYCLES in the
// environment says how many cycles each pair gets (0: twelve pairs of 200).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "band_faults/band_loop.hpp"
#include "support/bench.hpp"
#include "support/default_cycle.hpp"

namespace airside::band_faults {
namespace {

constexpr int recovery_cycles = 2 * cycles_per_day + 10;

/// Runs until air flows, near noon.
void to_noon(BandLoop& loop) {
  while (loop.plant().time().second_of_day() / 3600 != 12) loop.cycles(1);
}

struct Outcome {
  BandWatch seen;
  ControlMode at_end = ControlMode::learn;
  Reason reason = Reason::none;
};

Outcome disturb(const BandFault* a, const BandFault* b, int cycles, std::uint64_t seed) {
  SplitMix64 draw(seed);
  BandLoop loop;
  loop.cycles(1 + static_cast<int>(draw.below(cycles_per_day)));
  while (static_cast<int>(loop.watch().cycles) < cycles) {
    double longest = 1;
    for (const BandFault* fault : {a, b}) {
      if (fault == nullptr) continue;
      longest = std::max(longest, fault->begin(loop, draw));
      loop.cycles(1 + static_cast<int>(draw.below(8)));
    }
    loop.cycles(static_cast<int>(longest * 60 / 18) + static_cast<int>(draw.below(20)) + 1);
  }
  loop.clear();
  loop.hand_back();
  loop.cycles(recovery_cycles);
  return {loop.watch(), loop.mode(), loop.controller().decision().reason};
}

void expect_sound(const Outcome& out, const std::string& name) {
  EXPECT_EQ(out.seen.unsafe(), 0u) << name << ": " << out.seen.first;
  EXPECT_EQ(out.seen.blind_chosen, 0u) << name << ": " << out.seen.first;
  EXPECT_EQ(out.seen.model_broken, 0u) << name << ": " << out.seen.first;
  EXPECT_LE(out.at_end, ControlMode::run) << name << ": still " << text_of(out.reason);
}

TEST(BandFaults, EachAloneWritesNothingUnsafeAndControlComesBack) {
  const int cycles = std::max(200, closed_loop::from_environment("AIRSIDE_BAND_CYCLES", 0));
  std::uint64_t seed = 1;
  for (const BandFault& fault : band_faults()) expect_sound(disturb(&fault, nullptr, cycles, ++seed), fault.name);
}

TEST(BandFaults, NoPairWritesAnythingUnsafeAndControlComesBack) {
  const int asked = closed_loop::from_environment("AIRSIDE_BAND_CYCLES", 0);
  const std::size_t apart = asked > 0 ? 1 : 37;
  const auto& faults = band_faults();
  BandWatch sum;
  std::size_t pair = 0, tried = 0;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    for (std::size_t k = i; k < faults.size(); ++k, ++pair) {
      if (pair % apart != 0) continue;
      const Outcome out = disturb(&faults[i], &faults[k], asked > 0 ? asked : 200, 1000 + pair);
      expect_sound(out, fmt::format("{} with {}", faults[i].name, faults[k].name));
      sum.add(out.seen);
      ++tried;
    }
  }
  std::printf(
      "%zu of %zu pairs of %zu faults, %llu cycles, %llu writes, %llu unsafe; %llu decisions without most dampers "
      "or zone setpoints, %llu of them not the schedule's\n",
      tried, pair, faults.size(), static_cast<unsigned long long>(sum.cycles),
      static_cast<unsigned long long>(sum.writes), static_cast<unsigned long long>(sum.unsafe()),
      static_cast<unsigned long long>(sum.blind), static_cast<unsigned long long>(sum.blind_chosen));
  EXPECT_GT(sum.blind, 50u);
}

TEST(BandFaults, WithoutAFaultItChoosesAndNothingIsBlind) {
  BandLoop loop;
  loop.cycles(3 * cycles_per_day);
  EXPECT_EQ(loop.watch().unsafe() + loop.watch().blind + loop.watch().model_broken, 0u) << loop.watch().first;
  EXPECT_EQ(loop.mode(), ControlMode::learn);
  EXPECT_GT(loop.moved(), 20) << "setpoints of its own";
}

TEST(BandFaults, TheScheduleTakesOverInTheCycleInWhichMostDampersAreLost) {
  for (const sim::FaultKind kind : {sim::FaultKind::not_a_number, sim::FaultKind::set_to}) {
    BandLoop loop;
    to_noon(loop);
    ASSERT_EQ(loop.mode(), ControlMode::learn);
    loop.begin_all(kind, 3, "damper_", 2);
    loop.cycles(1);
    EXPECT_EQ(loop.mode(), ControlMode::expert);
    EXPECT_EQ(loop.controller().decision().reason, Reason::signal_lost);
    EXPECT_EQ(loop.controller().decision().command.setpoint_degc(), 14);
    loop.cycles(12);
    EXPECT_EQ(loop.mode(), ControlMode::learn) << "they are back";
  }
}

TEST(BandFaults, OneDamperThatIsLostLeavesTheChoiceToTheOthers) {
  BandLoop loop;
  to_noon(loop);
  loop.begin(sim::FaultKind::not_a_number, 3, "damper_2");
  loop.cycles(4);
  EXPECT_LE(loop.mode(), ControlMode::run);
}

TEST(BandFaults, AFanThatTripsIsNoAlarmAndTeachesNothing) {
  BandLoop loop;
  to_noon(loop);
  const int learned = loop.controller().cycle().band.learned();
  loop.stop_fan(4);
  loop.cycles(10);
  EXPECT_LE(loop.controller().cycle().band.learned(), learned + 1) << "the cycle before";
  EXPECT_LE(loop.mode(), ControlMode::run);
  loop.cycles(10);
  EXPECT_GT(loop.controller().cycle().band.learned(), learned + 2);
}

TEST(BandFaults, DaysOfWrongDampersCostNoMoreThanTheScheduleAWeekLater) {
  const auto energy_of_a_week = [](auto&& begin) {
    BandLoop loop;
    begin(loop);
    loop.cycles(2 * cycles_per_day);
    loop.clear();
    const double before = loop.plant().energy().total_kwh();
    loop.cycles(7 * cycles_per_day);
    return loop.plant().energy().total_kwh() - before;
  };
  const double sound = energy_of_a_week([](BandLoop&) {});
  const double schedule = [] {
    sim::ModulatingPlant plant = *band_before().plant;
    plant.set_setpoint(14);
    plant.advance_to({plant.time().seconds + 2 * seconds_per_day});
    const double before = plant.energy().total_kwh();
    plant.advance_to({plant.time().seconds + 7 * seconds_per_day});
    return plant.energy().total_kwh() - before;
  }();
  std::printf("kWh in the week after two days: no fault %.1f, schedule %.1f\n", sound, schedule);
  EXPECT_LT(sound, schedule);
  using sim::FaultKind;
  const struct {
    const char* name;
    FaultKind kind;
    const char* stem;
    double magnitude;
  } cases[] = {{"dampers reversed", FaultKind::reversed, "damper_", 0},
               {"dampers frozen", FaultKind::stuck, "damper_", 0},
               {"dampers lost", FaultKind::not_a_number, "damper_", 0},
               {"zone setpoints 3 K too high", FaultKind::offset, "zone_setpoint_", 3},
               {"heating setpoints lost", FaultKind::not_a_number, "zone_heating_setpoint_", 0},
               {"heating setpoints 3 K too high", FaultKind::offset, "zone_heating_setpoint_", 3},
               {"heating setpoints 9 K too high", FaultKind::offset, "zone_heating_setpoint_", 9}};
  for (const auto& c : cases) {
    const double kwh = energy_of_a_week([&](BandLoop& loop) { loop.begin_all(c.kind, 48, c.stem, c.magnitude); });
    std::printf("  after two days of %s: %.1f\n", c.name, kwh);
    EXPECT_LT(kwh, 1.02 * schedule) << c.name;
  }
  const double meter = energy_of_a_week([](BandLoop& loop) { loop.begin(FaultKind::offset, 48, "power_1", 40); });
  std::printf("  after two days of a meter 40 kW too high: %.1f\n", meter);
  EXPECT_LT(meter, 1.02 * schedule);
}

}  // namespace
}  // namespace airside::band_faults
