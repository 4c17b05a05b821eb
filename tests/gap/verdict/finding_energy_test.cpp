// What a finding costs: kWh of each meter with it less without it, with the interval of its size.

#include "tools/gap/explain/finding_energy.hpp"

#include <gtest/gtest.h>

namespace airside::tools::gap {
namespace {

/// Two days of two rooms with two meters; the second meter takes `more_kw` more than 3 kW on the second day, and
/// something else on the first, which does not count.
Eigen::MatrixXd curve(const sim::Channels& at, double more_kw) {
  Eigen::MatrixXd table = Eigen::MatrixXd::Constant(2 * bins_per_day, at.count(), 24);
  table.col(at.power()).setConstant(2);
  table.col(at.power() + 1).setConstant(3 + more_kw);
  table.col(at.power() + 1).head(bins_per_day).setConstant(50 + 7 * more_kw);
  return table;
}

class FindingEnergyTest : public ::testing::Test {
 protected:
  FindingEnergyTest() {
    fan.name = "fan_power";
    fan.null_value = 1;
    fan.low = 0.5;
    fan.high = 3;
    found.at = {&fan, 0};
    found.magnitude = 1.5;
    found.sd = 0.1;
  }
  FindingEnergy energy(double with_kw, double without_kw) const {
    return energy_of(found, curve(at, with_kw), curve(at, without_kw), at);
  }

  sim::Channels at{2, 0, 2};
  sim::Effect fan;
  Finding found;
};

TEST_F(FindingEnergyTest, IsTheDifferenceADayByMeterWithTheIntervalOfTheSize) {
  const FindingEnergy e = energy(0.5, 0);
  ASSERT_EQ(e.by_meter.size(), 2U);
  EXPECT_DOUBLE_EQ(e.by_meter[0], 0);
  EXPECT_DOUBLE_EQ(e.by_meter[1], 12);
  EXPECT_DOUBLE_EQ(e.total, 12);
  EXPECT_DOUBLE_EQ(e.without, 24 * 5);
  EXPECT_NEAR(e.low, 12 * (0.5 - 0.196) / 0.5, 1e-9);
  EXPECT_NEAR(e.high, 12 * (0.5 + 0.196) / 0.5, 1e-9);
  EXPECT_EQ(sentence_of(e, {}), "it takes 12.0 kWh a day more (7.3 to 16.7)");
  EXPECT_EQ(sentence_of(e, {0.25, "EUR"}), "it takes 12.0 kWh a day more (7.3 to 16.7), 3.00 EUR");
}

TEST_F(FindingEnergyTest, SaysWhatIsSavedAndKeepsItsEndsInOrder) {
  const FindingEnergy e = energy(0, 0.5);
  EXPECT_DOUBLE_EQ(e.total, -12);
  EXPECT_LT(e.low, e.high);
  EXPECT_EQ(sentence_of(e, {}), "it takes 12.0 kWh a day less (7.3 to 16.7)");
}

TEST_F(FindingEnergyTest, SaysNothingWhereTheSignIsNotSureOrNothingIsMetered) {
  found.sd = 0.4;
  EXPECT_EQ(sentence_of(energy(0.5, 0), {}), "");
  found.sd = 0.1;
  at.powers = 0;
  const Eigen::MatrixXd table = Eigen::MatrixXd::Constant(2 * bins_per_day, at.count(), 24);
  const FindingEnergy none = energy_of(found, table, table, at);
  EXPECT_TRUE(none.by_meter.empty());
  EXPECT_EQ(sentence_of(none, {}), "");
}

TEST_F(FindingEnergyTest, NamesMetersAndMoneyInJson) {
  const nlohmann::json j = json_of(energy(0.5, 0), found, at, {0.25, "EUR"});
  EXPECT_EQ(j["id"], "fan_power");
  EXPECT_EQ(j["by_meter"]["power_2_kw"], 12);
  EXPECT_EQ(j["cost_per_day"], (nlohmann::json{{"cost", 3.0}, {"currency", "EUR"}}));
  EXPECT_TRUE(json_of(energy(0.5, 0), found, at, {})["cost_per_day"].is_null());
}

}  // namespace
}  // namespace airside::tools::gap
