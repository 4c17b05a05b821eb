// The objective takes nothing from the heap.

#include <gtest/gtest.h>

#include <memory>

#include "demand/zone_fixture.hpp"
#include "support/allocation_guard.hpp"

namespace {

using namespace airside;

TEST(BandObjective, LearnsAndChoosesWithoutTheHeap) {
  demand_test::FormulaBuilding building;
  const auto objective = std::make_unique<BandObjective>();
  objective->reset({});
  building.live({}, *objective, 3);
  const DemandReading at = building.read({3 * seconds_per_day});
  double chosen = 0;
  {
    footprint::AllocationGuard guard("a row and a decision of the objective");
    objective->observe({}, at);
    chosen = objective->choose({}, at, {}).setpoint_degc;
  }
  EXPECT_TRUE(std::isfinite(chosen));
}

}  // namespace
