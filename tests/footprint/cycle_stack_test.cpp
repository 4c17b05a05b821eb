// A whole decision with learning, in every topology, stays within the stack budget of the ledger.

#include <gtest/gtest.h>

#include <cstdio>
#include <memory>

#include "airside/controller/footprint.hpp"
#include "airside/controller/instances.hpp"
#include "airside/presets.hpp"
#include "hal/weights/blob_file.hpp"
#include "support/default_cycle.hpp"
#include "support/stack_probe.hpp"

namespace airside {
namespace {

template <Topology T>
Reading<T> office_at(CivilTime t, int k, double setpoint_degc) {
  using L = Layout<T>;
  Reading<T> r;
  r.time = t;
  r.value.setConstant(25.0 + 0.01 * (k % 7));
  for (int i = 0; i < L::signals; ++i) {
    const SignalKind kind = signal_id<T>(i).kind;
    if (is_status(kind)) r.value(i) = kind == SignalKind::rain ? 0 : 1;
    if (kind == SignalKind::power) r.value(i) = 5 + 0.1 * (k % 5);
  }
  r.setpoint_degc = setpoint_degc;
  return r;
}

template <Topology T>
std::size_t deepest_cycle() {
  auto controller = std::make_unique<Controller<T>>();
  ControllerSettings settings = product_settings();
  settings.batch = max_batch;  // the largest that a site may choose
  controller->configure(settings, default_limits<T>(), hal::box_kernels(), 1);
  SplitMix64 init(1);
  controller->draw_weights(init);
  ScalerFit<T> fit;
  for (int k = 0; k < 9; ++k) fit.add(office_at<T>({}, k, 22.5).value);
  controller->start(fit.fit(settings));
  const std::int64_t day = 18000 * std::int64_t{86400};
  std::size_t deepest = 0;
  double applied_degc = settings.expert_off_degc;
  for (int k = 0; k < 40; ++k) {
    const CivilTime t{day + k * std::int64_t{cycle_s}};
    const Expected<Reading<T>> sensed = office_at<T>(t, k, applied_degc);
    auto cycle = [&] {
      const auto d = controller->decide(t, sensed);
      applied_degc = d.command.setpoint_degc();
      controller->absorb(d, Applied{applied_degc});
    };
    deepest = std::max(deepest, footprint::stack_used(cycle));
  }
  EXPECT_GT(controller->learning().learner.steps(), 0u) << "nothing was learned, so the probe saw too little";
  EXPECT_GT(controller->learning().head.updates(), 0u);
  std::printf("%s: %zu bytes of stack at most, budget %zu\n", T::name, deepest, stack_budget_bytes);
  return deepest;
}

TEST(CycleStack, StaysWithinTheLedgersBudgetInEveryTopology) {
  for_each_topology([]<class T>(T) { EXPECT_LE(deepest_cycle<T>(), stack_budget_bytes) << T::name; });
}

}  // namespace
}  // namespace airside
