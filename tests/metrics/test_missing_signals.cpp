// What `airside check` says of a measured cost.

#include <gtest/gtest.h>

#include "tools/study/missing_signals.hpp"

namespace airside::tools {
namespace {

TEST(MissingSignals, ACostWithinItsSpreadOfNothingIsNotMeasurable) {
  EXPECT_EQ(cost_text({0.012, 0.004}), "+0.012 ± 0.004 °C of DAE");
  EXPECT_EQ(cost_text({0.003, 0.004}), "nothing measurable (+0.003 ± 0.004 °C of DAE)");
  EXPECT_EQ(cost_text({-0.003, 0.004}), "nothing measurable (-0.003 ± 0.004 °C of DAE)");
  EXPECT_EQ(measured_cost_degc(SignalKind::fcu_on).mean, measured_cost_degc(SignalKind::fcu_temp).mean);
}

}  // namespace
}  // namespace airside::tools
