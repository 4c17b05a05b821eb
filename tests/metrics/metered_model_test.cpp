// The figures of an adopted building, against numbers computed by hand.

#include "tools/study/metered_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "airside/settings.hpp"
#include "sim/weather/weather.hpp"
#include "support/default_cycle.hpp"

namespace airside::tools {
namespace {

/// Two rooms that show the same all day.
class SteadyPlant final : public sim::PlantModel {
 public:
  explicit SteadyPlant(CivilTime begin) : time_(begin) {
    shown_.room_temp_degc = {25.0, 20.0};
    shown_.zone_setpoint_degc = {24.0, 24.0};
    shown_.heating_setpoint_degc = {21.0, 21.0};
    shown_.damper = {1.0, 0.2};
    shown_.power_kw = {2.0, sim::not_shown, 0.5};
    shown_.setpoint_degc = 14;
  }
  CivilTime time() const override { return time_; }
  int step_s() const override { return 360; }
  void advance_to(CivilTime t) override { time_ = t; }
  void set_setpoint(double setpoint_degc) override { shown_.setpoint_degc = setpoint_degc; }
  const sim::Sensors& sensors() const override { return shown_; }
  std::string description() const override { return "steady"; }
  sim::Sensors& shown() { return shown_; }

 private:
  CivilTime time_;
  sim::Sensors shown_;
};

const CivilTime july_5 = sim::civil_midnight(2021, 7, 5);
CivilTime after(double hours) { return {july_5.seconds + static_cast<std::int64_t>(hours * 3600)}; }

class MeteredModelTest : public testing::Test {
 protected:
  MeteredModelTest() {
    site_.settings.target_degc = 22;
    site_.settings.work_start_h = 7;
    site_.settings.work_end_h = 19;
  }
  Site site_ = built_in_site();
  SteadyPlant plant_{{july_5.seconds - 86400}};
  MeteredModel metered_{plant_, site_, july_5};
};

TEST_F(MeteredModelTest, CountsWorkingHoursWhereNoPeopleAreShown) {
  metered_.advance_to(after(48));
  const BuildingFigures f = metered_.figures();
  EXPECT_NEAR(f.above_degch, 0.5 * 12, 0.11) << "25.0 above 24.0 + 0.5, a row more or less";
  EXPECT_NEAR(f.below_degch, 0.5 * 12, 0.11);
  EXPECT_NEAR(f.saturated_h, 12, 0.11);
  EXPECT_NEAR(f.dae_degc, 0.5, 1e-12) << "the mean is 22.5";
  EXPECT_NEAR(f.setpoint_degc, 14, 1e-12);
  EXPECT_EQ(f.darv_degc, 0);
  ASSERT_EQ(f.kwh_per_day.size(), 3U);
  EXPECT_NEAR(f.kwh_per_day[0], 48, 1e-9) << "all hours count";
  EXPECT_EQ(f.kwh_per_day[1], 0) << "a meter that shows nothing";
  EXPECT_NEAR(f.total_kwh(), 60, 1e-9);
}

TEST_F(MeteredModelTest, CountsTheHoursInWhichPeopleAreThere) {
  plant_.shown().occupied = 0;
  metered_.advance_to(after(20));
  plant_.shown().occupied = 1;
  metered_.advance_to(after(24));
  EXPECT_NEAR(metered_.figures().above_degch, 0.5 * 4, 1e-9);
}

TEST_F(MeteredModelTest, AZoneWithoutASetpointIsInItsBand) {
  plant_.shown().zone_setpoint_degc = {sim::not_shown, 24.0};
  plant_.shown().heating_setpoint_degc = {};
  metered_.advance_to(after(24));
  EXPECT_EQ(metered_.figures().outside_degch(), 0);
}

TEST_F(MeteredModelTest, SecondDifferencesOfTheSetpointAreCountedDayByDay) {
  for (int k = 0; k < 2 * 80; ++k) {  // 80 cycles a day; it goes up and down by 1 K in each
    metered_.set_setpoint(14 + k % 2);
    metered_.advance_to({july_5.seconds + (k + 1) * cycle_s});
  }
  EXPECT_NEAR(metered_.figures().darv_degc, 2.0 * 38 / 37, 1e-9) << "40 scored cycles: 38 terms, divided by 37";
}

TEST_F(MeteredModelTest, LessThanADayHasNoFigures) {
  metered_.advance_to(after(5));
  EXPECT_THROW((void)metered_.figures(), std::logic_error);
}

}  // namespace
}  // namespace airside::tools
