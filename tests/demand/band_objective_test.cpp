// The setpoint that the objective "band" chooses.

#include <gtest/gtest.h>

#include <type_traits>

#include "airside/demand/band_objective.hpp"
#include "demand/zone_fixture.hpp"
#include "support/default_cycle.hpp"

namespace {

using namespace airside;
using demand_test::FormulaBuilding;

constexpr CivilTime noon{9 * seconds_per_day + 43200};
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

BandObjective learned_objective(FormulaBuilding& building, int days = 9) {
  BandObjective objective;
  objective.reset({});
  building.live({}, objective, days);
  return objective;
}

double chosen(BandObjective& objective, FormulaBuilding& building, const DemandSettings& s = {},
              const DemandChoice& c = {}) {
  return objective.choose(s, building.read(noon), c).setpoint_degc;
}

/// The learned objective at an instant whose loads and weather the test sets.
double chosen_at(FormulaBuilding building, double outdoor, double load_factor) {
  BandObjective objective = learned_objective(building);
  building.outdoor_degc = outdoor;
  for (double& q : building.load_k) q *= load_factor;
  return chosen(objective, building);
}

TEST(BandObjective, TheFootprintIsFixedAndSmall) {
  static_assert(std::is_trivially_copyable_v<BandObjective>);
  EXPECT_LE(sizeof(BandObjective), 12u * 1024);
}

TEST(BandObjective, WithoutAnEconomizerTheColdestAirIsCheapest) {
  FormulaBuilding building;
  building.economizer = false;
  EXPECT_LT(chosen_at(building, 30, 1), 12.5);
}

TEST(BandObjective, ColdOutdoorAirMakesWarmSupplyAirPay) {
  const FormulaBuilding building;
  EXPECT_GT(chosen_at(building, 16, 0.6), 13.5);
  EXPECT_GT(chosen_at(building, 16, 0.6), chosen_at(building, 30, 0.6) + 1);
}

TEST(BandObjective, ADearerFanNeverMakesTheAirWarmer) {
  double before = 18;
  for (const double fan_kw : {1.0, 3.0, 6.0, 12.0}) {
    FormulaBuilding building;
    building.fan_kw = fan_kw;
    const double now = chosen_at(building, 16, 0.6);
    EXPECT_LE(now, before + 0.1) << fan_kw << " kW";
    before = now;
  }
}

TEST(BandObjective, MoreLoadNeverMakesTheAirWarmerInWarmWeather) {
  FormulaBuilding building;
  building.fan_kw = 0.5;
  double before = 18;
  for (const double factor : {0.6, 1.0, 1.3, 1.6}) {
    const double now = chosen_at(building, 17, factor);
    EXPECT_LE(now, before + 0.1) << factor;
    before = now;
  }
}

TEST(BandObjective, NoZoneIsLeftShortOfColdAirForAFewWatts) {
  FormulaBuilding building;
  building.fan_kw = 0.01;  // flow costs nothing, so that warm air would always pay
  BandObjective objective = learned_objective(building);
  building.outdoor_degc = 17;
  building.load_k = {10, 4, 4, 4};
  const double setpoint = chosen(objective, building);
  // The load that was learned is yesterday noon's; the neediest zone is the one whose damper it opens furthest.
  EXPECT_LT(objective.evaluate({}, building.read(noon), {}, setpoint).most_open, 1.05);
}

TEST(BandObjective, WithoutDampersOrSetpointsTheScheduleHolds) {
  FormulaBuilding building;
  BandObjective objective = learned_objective(building);
  DemandReading at = building.read(noon);
  ASSERT_TRUE(std::isfinite(objective.choose({}, at, {}).setpoint_degc));
  for (std::vector<double>* signal : {&building.damper, &building.set, &building.room}) {
    const std::vector<double> whole = *signal;
    signal->assign(4, unknown);
    EXPECT_TRUE(std::isnan(objective.choose({}, at, {}).setpoint_degc));
    *signal = whole;
  }
  at.supply_degc = unknown;
  EXPECT_TRUE(std::isnan(objective.choose({}, at, {}).setpoint_degc));
  at = building.read(noon);
  at.outdoor_degc = unknown;
  EXPECT_TRUE(std::isnan(objective.choose({}, at, {}).setpoint_degc));
  at = building.read(noon);
  at.flows = false;
  EXPECT_TRUE(std::isnan(objective.choose({}, at, {}).setpoint_degc));
  at.zones = {};
  EXPECT_TRUE(std::isnan(objective.choose({}, at, {}).setpoint_degc));
}

TEST(BandObjective, OneLostDamperOfFourIsBorne) {
  FormulaBuilding building;
  BandObjective objective = learned_objective(building);
  const DemandReading at = building.read(noon);
  building.damper[2] = unknown;
  EXPECT_TRUE(std::isfinite(objective.choose({}, at, {}).setpoint_degc));
}

TEST(BandObjective, BeforeItHasLearnedEnoughTheScheduleHolds) {
  FormulaBuilding building;
  BandObjective objective;
  objective.reset({});
  EXPECT_TRUE(std::isnan(chosen(objective, building)));
  building.live({}, objective, 1);  // 80 cycles, of which 20 make the prior
  EXPECT_EQ(objective.is_ready({}), objective.learned() >= 60);
  DemandSettings patient;
  patient.ready_cycles = 1000;
  EXPECT_TRUE(std::isnan(chosen(objective, building, patient)));
}

TEST(BandObjective, LostPowerMetersTeachNothingAndHarmNothing) {
  FormulaBuilding building;
  BandObjective objective = learned_objective(building);
  const double before = chosen(objective, building);
  const int learned_before = objective.learned();
  for (int row = 0; row < rows_per_day; ++row) {
    DemandReading at = building.read({noon.seconds + (row + 1) * row_s});
    building.power.assign(2, unknown);
    objective.observe({}, at);
  }
  EXPECT_EQ(objective.learned(), learned_before);
  EXPECT_TRUE(std::isfinite(before));
  EXPECT_TRUE(std::isfinite(chosen(objective, building)));
}

TEST(BandObjective, TheChoiceStaysOnTheGridOfItsRange) {
  FormulaBuilding building;
  BandObjective objective = learned_objective(building);
  for (const double low : {12.0, 13.3, 15.0}) {
    const DemandChoice c{.min_degc = low, .max_degc = low + 1.5};
    const double a = chosen(objective, building, {}, c);
    EXPECT_GE(a, low);
    EXPECT_LE(a, low + 1.5);
    EXPECT_NEAR((a - low) / 0.1, std::round((a - low) / 0.1), 1e-6);
  }
}

TEST(BandObjective, ACostlyMoveKeepsTheSetpointCalm) {
  FormulaBuilding building;
  BandObjective objective = learned_objective(building);
  DemandSettings calm;
  calm.move_cost = 1000;
  EXPECT_NEAR(chosen(objective, building, calm, {.last_degc = 16.0}), 16.0, 0.11);
}

TEST(BandObjective, ABoxInForeverTroubleDoesNotHoldTheAirCold) {
  FormulaBuilding building;
  building.fan_kw = 1;
  BandObjective objective = learned_objective(building);
  building.outdoor_degc = 16;
  for (double& q : building.load_k) q *= 0.5;
  const double healthy = chosen(objective, building);
  building.room_degc[3] = 30;  // its damper is open, nothing helps
  building.load_k[3] = 40;
  for (int row = 1; row <= 2 * rows_per_day; ++row) {
    DemandReading at = building.read({noon.seconds + row * row_s});
    at.coldest = true;
    objective.observe({}, at);
  }
  EXPECT_GT(chosen(objective, building), healthy - 0.6);
}

TEST(BandObjective, TheFanStartsOnTheFirstChoiceAfterItsLastRest) {
  FormulaBuilding building;
  BandObjective objective = learned_objective(building);
  DemandReading rests = building.read(noon);
  rests.flows = false;
  EXPECT_TRUE(std::isnan(objective.choose({}, rests, {}).setpoint_degc)) << "no start is known yet";
  const double first = chosen(objective, building);
  building.outdoor_degc = 30;  // later choices are others
  EXPECT_NE(chosen(objective, building), first);
  EXPECT_EQ(objective.choose({}, rests, {}).setpoint_degc, first);
  const DemandChoice narrow{.min_degc = first + 0.5, .max_degc = 18};
  EXPECT_EQ(objective.choose({}, rests, narrow).setpoint_degc, first + 0.5) << "within the range of today";
}

TEST(BandObjective, AChoiceLongAfterTheStartIsNoStart) {
  for (const bool blind : {false, true}) {
    SCOPED_TRACE(blind ? "without outdoor temperature at the start" : "down at the start");
    FormulaBuilding building;
    BandObjective objective = learned_objective(building);
    DemandReading rests = building.read(noon);
    rests.flows = false;
    (void)objective.choose({}, rests, {});
    if (blind) {
      DemandReading start = building.read({noon.seconds + cycle_s});
      start.outdoor_degc = unknown;
      EXPECT_TRUE(std::isnan(objective.choose({}, start, {}).setpoint_degc));
    }
    const std::int64_t later_s = blind ? 2 * cycle_s : 3 * cycle_s;
    EXPECT_TRUE(std::isfinite(objective.choose({}, building.read({noon.seconds + later_s}), {}).setpoint_degc));
    EXPECT_TRUE(std::isnan(objective.choose({}, rests, {}).setpoint_degc)) << "no start is known yet";
  }
}

TEST(BandObjective, ASavingThatIsTooSmallMovesNothing) {
  FormulaBuilding building;
  BandObjective objective = learned_objective(building);
  const double best = chosen(objective, building);
  const DemandChoice near{.last_degc = best + 0.1}, far{.last_degc = best + 3};
  DemandSettings eager, lazy;
  lazy.stay_share = 0.05;
  EXPECT_EQ(chosen(objective, building, lazy, near), best + 0.1);
  EXPECT_LT(chosen(objective, building, lazy, far), best + 2.5);
  eager.stay_share = 0;
  EXPECT_NEAR(chosen(objective, building, eager, near), best, 0.051);
}

/// Ten days without flow, after which no night of late was cooler than the reading is.
CivilTime after_warm_nights(BandObjective& objective, DemandReading rests) {
  constexpr int days = 10;
  rests.flows = false;
  for (int row = 0; row < days * rows_per_day; ++row) {
    rests.time = {noon.seconds + row * row_s};
    objective.observe({}, rests);
  }
  return {noon.seconds + days * seconds_per_day};
}

TEST(BandObjective, WhereNoNightCoolsColderAirIsNotHeldBack) {
  FormulaBuilding building;
  building.economizer = false;
  BandObjective objective = learned_objective(building);
  building.outdoor_degc = 32;
  DemandSettings lazy;
  lazy.stay_share = 0.05;
  const DemandChoice near{.last_degc = 12.3};
  EXPECT_EQ(chosen(objective, building, lazy, near), 12.3) << "nights were cool";
  const CivilTime later = after_warm_nights(objective, building.read(noon));
  EXPECT_EQ(objective.choose(lazy, building.read(later), near).setpoint_degc, 12);
}

TEST(BandObjective, WhereNoNightCoolsDoubtKeepsToTheColdestAirNotToTheSchedule) {
  FormulaBuilding building;
  building.economizer = false;
  BandObjective objective = learned_objective(building);
  building.outdoor_degc = 32;
  DemandSettings doubtful;
  doubtful.caution = 200;
  const DemandChoice schedule{.schedule_degc = 14};
  EXPECT_NEAR(chosen(objective, building, doubtful, schedule), 14, 0.051) << "nights were cool";
  const CivilTime later = after_warm_nights(objective, building.read(noon));
  EXPECT_EQ(objective.choose(doubtful, building.read(later), schedule).setpoint_degc, 12);
}

TEST(BandObjective, WhereEverySetpointLeavesAZoneShortTheColdestIsChosen) {
  FormulaBuilding building;
  BandObjective objective = learned_objective(building);
  building.outdoor_degc = 10;  // warm air would pay
  building.load_k[1] = 14;     // a load that full flow of the coldest air does not carry
  building.room_degc[1] = 26.5;
  building.supply_degc = 17;
  for (int row = 0; row < 3 * 8; ++row) {
    const CivilTime t{noon.seconds + row * row_s};
    objective.observe({}, building.read(t));
  }
  EXPECT_LT(objective.choose({}, building.read({noon.seconds + 8 * cycle_s}), {}).setpoint_degc, 12.6);
}

TEST(BandObjective, TheAirWarmsByStepsAndCoolsAtOnce) {
  FormulaBuilding building;
  BandObjective objective = learned_objective(building);
  building.outdoor_degc = 16;
  for (double& q : building.load_k) q *= 0.6;
  const double free = chosen(objective, building);
  ASSERT_GT(free, 13.5);
  DemandChoice from_cold;
  from_cold.last_degc = 12;
  EXPECT_LE(chosen(objective, building, {}, from_cold), 12 + DemandSettings{}.warm_step_k + 1e-9);
  DemandChoice from_warm;
  from_warm.last_degc = 18;
  building.setpoint_degc = 22;  // every zone is 2 K too warm
  EXPECT_LT(chosen(objective, building, {}, from_warm), 18 - 2 * DemandSettings{}.warm_step_k);
}

}  // namespace
