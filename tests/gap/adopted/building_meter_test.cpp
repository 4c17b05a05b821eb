// A meter of a whole building beside a small air loop: its kilowatts are not taken for watts.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "gap/clean_up_case.hpp"

namespace airside::tools::gap {
namespace {

bool has_wrong_unit(const CleanLog& log) {
  return std::any_of(log.remarks.begin(), log.remarks.end(),
                     [](const Remark& r) { return r.defect == Defect::wrong_unit && r.column == "power_1_kw"; });
}

TEST(BuildingMeter, IsTakenAsItIsWhereMetersMayBeOfAWholeBuilding) {
  const Logged small = log_of(sim::make_room(1, 0, 1), 7, sim::civil_midnight(2023, 7, 3), true);
  Rows rows = small.rows;
  for (hal::LogRow& row : rows) row.value[1 + 1] *= 100;  // room, box, power
  CleanUpContext context = small.context;
  EXPECT_TRUE(has_wrong_unit(clean_up(rows, context))) << "no room of one zone takes that";
  context.largest_zone_kw = std::numeric_limits<double>::infinity();
  const CleanLog log = clean_up(rows, context);
  EXPECT_FALSE(has_wrong_unit(log));
  ASSERT_EQ(log.rows.size(), rows.size());
  EXPECT_EQ(log.rows[100].value[2], rows[100].value[2]);
}

}  // namespace
}  // namespace airside::tools::gap
