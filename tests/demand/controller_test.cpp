// The controller itself under the objective "band", on a room whose boxes modulate.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "airside/controller/controller.hpp"
#include "airside/controller/cycle.hpp"
#include "airside/network/kernels/kernels.hpp"
#include "airside/presets.hpp"
#include "sim/rc/modulating_plant.hpp"
#include "sim/simulated_plant.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "support/default_cycle.hpp"

namespace {

using namespace airside;
using Site = UpTo8;

/// The room as lib's Plant, with all side signals.
struct BoxPlant {
  sim::ModulatingPlant& model;
  bool blind = false;
  std::int64_t poll_s = 0;  ///< the reading comes so long after its row began

  Expected<Reading<Site>> sense() const {
    const sim::Sensors& s = model.sensors();
    const sim::BoxSensors& boxes = model.boxes();
    Reading<Site> reading;
    reading.time = {model.time().seconds + poll_s};
    const Shape shape{8, 0, 2};
    for (int i = 0; i < Layout<Site>::signals; ++i) {
      if (is_present<Site>(shape, i)) reading.value(i) = sim::sensor_value(s, signal_id<Site>(i));
    }
    for (Eigen::Index i = 0; i < 8; ++i) {
      const auto k = static_cast<std::size_t>(i);
      reading.damper(i) = blind ? std::numeric_limits<double>::quiet_NaN() : boxes.damper[k];
      reading.zone_setpoint_degc(i) = boxes.zone_setpoint_degc[k];
    }
    reading.setpoint_degc = s.setpoint_degc;
    reading.supply_temp_degc = s.supply_temp_degc;
    reading.supply_flow_m3s = boxes.supply_flow_m3_s;
    reading.flows = boxes.fan_runs;
    return reading;
  }
  Expected<Applied> actuate(const Command& command) const {
    model.set_setpoint(command.setpoint_degc());
    return Applied{command.setpoint_degc()};
  }
};

struct Rig {
  sim::ModulatingPlant model;
  BoxPlant plant{model};
  std::unique_ptr<Controller<Site>> controller = std::make_unique<Controller<Site>>();
  std::vector<double> setpoints;
  int experts = 0, alarms = 0;
  ActiveMode last;

  explicit Rig(const char* scenario, int month)
      : model(sim::modulating_room(scenario, 2), sim::synthetic_weather(79, sim::modulating_room(scenario, 2).climate),
              sim::civil_midnight(2021, month, 1), 2) {
    ControllerSettings s = product_settings();
    s.objective = Objective::band;
    s.shape = {8, 0, 2};
    s.action_min_degc = s.limit_min_degc = 12;
    s.action_max_degc = s.limit_max_degc = 18;
    s.expert_work_degc = s.expert_off_degc = 14;
    controller->configure(s, default_limits<Site>(), strict_kernels<float>(), 1);
  }

  bool row(CivilTime t, const Expected<Reading<Site>>&, const Controller<Site>& c) {
    if (!starts_cycle(t)) return true;
    setpoints.push_back(c.decision().command.setpoint_degc());
    last = c.control_mode(t);
    experts += last.mode == ControlMode::expert ? 1 : 0;
    alarms += c.cycle().mode_arbiter.active(Reason::authority_lost, t) ? 1 : 0;
    return true;
  }

  /// kWh that the days took.
  double live(int days) {
    const double before = model.energy().total_kwh();
    sim::SimulatedClock clock(model);
    const CivilTime until{model.time().seconds + days * seconds_per_day};
    run_cycles<Site>(plant, clock, *controller, *this, next_row(model.time()), until);
    (void)clock.sleep_until(until);
    return model.energy().total_kwh() - before;
  }
};

TEST(BandController, LearnsUnderTheScheduleThenSavesWithoutAnyWeights) {
  Rig rig("reheat", 4);
  (void)rig.live(2);
  EXPECT_EQ(rig.controller->cycle().has_weights, 0);
  const auto moved = [&](std::size_t from) {
    return std::any_of(rig.setpoints.begin() + static_cast<std::ptrdiff_t>(from), rig.setpoints.end(),
                       [](double a) { return std::abs(a - 14) > 0.3; });
  };
  EXPECT_FALSE(moved(0));
  (void)rig.live(4);
  sim::ModulatingPlant schedule = rig.model;
  schedule.set_setpoint(14);
  const double began = schedule.energy().total_kwh();
  const std::size_t first = rig.setpoints.size();
  const double ours = rig.live(10);
  schedule.advance_to(rig.model.time());
  EXPECT_LT(ours, 0.98 * (schedule.energy().total_kwh() - began));
  EXPECT_TRUE(moved(first));
  EXPECT_GE(*std::min_element(rig.setpoints.begin(), rig.setpoints.end()), 12);
  EXPECT_LE(*std::max_element(rig.setpoints.begin(), rig.setpoints.end()), 18);
  EXPECT_EQ(rig.experts, 0);
}

TEST(BandController, APollThatTakesSecondsChangesNothing) {
  Rig at_once("reheat", 4), slow("reheat", 4);
  slow.plant.poll_s = 3;
  (void)at_once.live(6);
  (void)slow.live(6);
  EXPECT_GT(slow.controller->cycle().band.learned(), 60);
  EXPECT_EQ(slow.setpoints, at_once.setpoints);
}

TEST(BandController, ASetpointAtItsLimitIsAChoice) {
  Rig rig("duct", 7);  // cold air is right all day, and rooms are nowhere near the target of the other objective
  (void)rig.live(8);
  EXPECT_GT(std::count(rig.setpoints.end() - 80, rig.setpoints.end(), 12.0), 20);
  EXPECT_EQ(rig.alarms, 0);
}

TEST(BandController, ReasonsOfAnEarlierObjectiveEndWithIt) {
  Rig rig("mild", 4);
  for (const Reason r : {Reason::gain_reversed, Reason::forecasts_doubted, Reason::worse_than_schedule}) {
    rig.controller->report(r, true, rig.model.time());
  }
  rig.controller->hold(Reason::worse_for_long, rig.model.time(), 30 * std::int64_t{seconds_per_day});
  (void)rig.live(1);
  EXPECT_EQ(rig.last, (ActiveMode{ControlMode::learn, Reason::none}));
}

TEST(BandController, ASetpointThatRestsIsNoAlarmThoughThereAreWeights) {
  Rig rig("mild", 4);
  rig.controller->start(Scaler<Site>());
  (void)rig.live(2);  // the schedule's setpoint all the time
  EXPECT_NE(rig.controller->cycle().has_weights, 0);
  EXPECT_EQ(rig.last, (ActiveMode{ControlMode::learn, Reason::none}));
}

TEST(BandController, LostDampersGiveTheScheduleAndTheReason) {
  Rig rig("mild", 10);
  (void)rig.live(6);
  rig.plant.blind = true;
  (void)rig.live(1);
  rig.setpoints.clear();
  sim::SimulatedClock clock(rig.model);
  const CivilTime noon{rig.model.time().seconds + 43200};
  run_cycles<Site>(rig.plant, clock, *rig.controller, rig, next_row(rig.model.time()), noon);
  EXPECT_EQ(rig.last, (ActiveMode{ControlMode::expert, Reason::signal_lost}));
  EXPECT_EQ(rig.setpoints.back(), 14);
  rig.plant.blind = false;
  (void)clock.sleep_until(noon);
  (void)rig.live(1);
  EXPECT_EQ(rig.last.mode, ControlMode::learn);
}

TEST(BandController, WhatItLearnedIsInTheStateOfACycle) {
  Rig rig("mild", 4);
  (void)rig.live(5);
  const auto other = std::make_unique<Controller<Site>>();
  other->configure(rig.controller->settings(), rig.controller->limits(), strict_kernels<float>(), 1);
  const CycleState<Site> saved = rig.controller->cycle();
  EXPECT_EQ(saved.band.learned(), rig.controller->cycle().band.learned());
  EXPECT_GT(saved.band.learned(), 60);
  sim::ModulatingPlant branch = rig.model;
  const auto same = [&](Controller<Site>& controller, sim::ModulatingPlant& model) {
    std::vector<double> chosen;
    const BoxPlant plant{model};
    for (int row = 0; row < 100; ++row) {
      const CivilTime t = model.time();
      const auto sensed = plant.sense();
      if (starts_cycle(t)) {
        const auto decision = controller.decide(t, sensed);
        chosen.push_back(decision.command.setpoint_degc());
        controller.absorb(decision, plant.actuate(decision.command));
      } else {
        controller.observe(t, sensed);
      }
      model.advance_to({t.seconds + row_s});
    }
    return chosen;
  };
  (void)other->restore(saved, 0, rig.controller->decision());
  EXPECT_EQ(same(*rig.controller, rig.model), same(*other, branch));
}

}  // namespace
