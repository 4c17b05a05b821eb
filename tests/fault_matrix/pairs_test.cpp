// Every two rows of the matrix at once, on the RC plant: nothing unsafe is written, nothing bad is learned, and control
// comes back. AIRSIDE_FAULT_PAIRS and AIRSIDE_FAULT_CYCLES in the environment say how many pairs and how many cycles
// each.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "fault_matrix/fault_loop.hpp"
#include "support/bench.hpp"
#include "support/default_cycle.hpp"

namespace airside::fault_matrix {
namespace {

constexpr int recovery_cycles = 2 * cycles_per_day + 10;  ///< holds of a day end within

struct Outcome {
  Watchman seen;
  bool came_back = false;
  std::string stands;  ///< control mode and reason at the end
};

/// Faults of both rows begin within three hours of each other, again and again; then all is well.
Outcome disturb(const MatrixRow* a, const MatrixRow* b, int cycles, std::uint64_t seed) {
  SplitMix64 draw(seed);
  FaultLoop loop(prepared_room());
  loop.cycles(1 + static_cast<int>(draw.below(cycles_per_day)));
  while (static_cast<int>(loop.watchman().cycles) < cycles - recovery_cycles) {
    double longest = 1;
    if (a != nullptr) longest = std::max(longest, a->begin(loop, draw));
    double after = 3 * draw.uniform();
    if (b != nullptr) {
      // The other one comes while the first acts, or soon after it.
      const std::uint64_t own = draw.next();
      loop.in_hours(after, [&loop, b, own] {
        SplitMix64 details(own);
        (void)b->begin(loop, details);
      });
    }
    const int rest = cycles - recovery_cycles - static_cast<int>(loop.watchman().cycles);
    loop.cycles(std::clamp(static_cast<int>((longest + after) * 60 / 18) + static_cast<int>(draw.below(30)), 1,
                           std::max(1, rest)));
    if (draw.below(3) == 0) loop.controller().hand_back();
  }
  loop.clear();
  loop.controller().hand_back();
  loop.cycles(recovery_cycles);
  const Decision& d = loop.decision();
  return {loop.watchman(), d.mode <= ControlMode::run, fmt::format("{}: {}", text_of(d.mode), text_of(d.reason))};
}

TEST(FaultPairs, NoPairWritesAnythingUnsafeAndControlComesBack) {
  const int only = closed_loop::from_environment("AIRSIDE_FAULT_ROW", 0);
  std::vector<const MatrixRow*> acting;
  for (const MatrixRow& row : matrix_rows()) {
    if (row.begin != nullptr) acting.push_back(&row);
  }
  std::vector<std::pair<const MatrixRow*, const MatrixRow*>> pairs;
  for (std::size_t i = 0; i < acting.size(); ++i) {
    for (std::size_t k = i + 1; k < acting.size(); ++k) {
      if (only == 0 || acting[i]->row == only || acting[k]->row == only) pairs.emplace_back(acting[i], acting[k]);
    }
  }
  const int all = static_cast<int>(pairs.size());
  const int count = std::min(all, closed_loop::from_environment("AIRSIDE_FAULT_PAIRS", 16));
  const int cycles = closed_loop::from_environment("AIRSIDE_FAULT_CYCLES", 300);
  const int seed = closed_loop::from_environment("AIRSIDE_FAULT_SEED", 1);
  const int part = closed_loop::from_environment("AIRSIDE_FAULT_PART", 0);
  const int parts = closed_loop::from_environment("AIRSIDE_FAULT_PARTS", 1);
  SplitMix64 draw(static_cast<std::uint64_t>(seed));
  Watchman sum;
  int stayed = 0;
  for (int i = part; i < count; i += parts) {
    // All of them in order, or as many that are spread over all.
    const auto& [a, b] = pairs[count == all ? static_cast<std::size_t>(i)
                                            : static_cast<std::size_t>(static_cast<std::int64_t>(i) * all / count) +
                                                  draw.below(static_cast<std::uint32_t>(all / count))];
    const Outcome out = disturb(a, b, cycles, static_cast<std::uint64_t>(seed) * 1'000'003U + static_cast<unsigned>(i));
    const std::string name = fmt::format("{} ({}) with {} ({})", a->row, a->fault, b->row, b->fault);
    EXPECT_EQ(out.seen.unsafe(), 0u) << name << ": " << out.seen.first;
    EXPECT_EQ(out.seen.learned_bad, 0u) << name << ": " << out.seen.first;
    EXPECT_EQ(out.seen.weights_broken, 0u) << name << ": " << out.seen.first;
    EXPECT_TRUE(out.came_back) << name << ": still " << out.stands;
    stayed += !out.came_back;
    sum.cycles += out.seen.cycles;
    sum.writes += out.seen.writes;
    if (count > 100 && i % 25 == part) {
      std::printf("%d of %d pairs, %.0f cycles\n", i + 1, count, static_cast<double>(sum.cycles));
      std::fflush(stdout);
    }
  }
  std::printf("%d of %d pairs of %d rows, %llu cycles, %llu writes, %d did not come back\n", count, all,
              static_cast<int>(acting.size()), static_cast<unsigned long long>(sum.cycles),
              static_cast<unsigned long long>(sum.writes), stayed);
}

TEST(FaultPairs, WithoutAFaultTheRigDecidesAsTheSimulation) {
  const Outcome calm = disturb(nullptr, nullptr, 300, 1);
  EXPECT_EQ(calm.seen.unsafe() + calm.seen.learned_bad + calm.seen.weights_broken, 0u);
  FaultLoop loop(prepared_room());
  loop.cycles(3 * cycles_per_day);
  EXPECT_EQ(loop.gravest(), ControlMode::learn);
  tools::Trial trial = prepared_room().trial;
  trial.days = 3;
  tools::Prepared again = tools::prepare(trial);
  const tools::ControlRun run = tools::run_ours(trial, again, {{}, true, 300});
  ASSERT_EQ(run.cycles.size(), loop.setpoint_degc.size());
  for (std::size_t i = 0; i < run.cycles.size(); ++i) {
    ASSERT_EQ(run.cycles[i].setpoint_degc, loop.setpoint_degc[i]) << i;
  }
}

TEST(FaultPairs, TheWatchmanSeesWhatIsUnsafe) {
  FaultLoop loop(prepared_room());
  loop.cycles(3);
  ASSERT_EQ(loop.watchman().unsafe(), 0u) << loop.watchman().first;
  loop.look_at_write(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(loop.watchman().not_finite, 1u);
  loop.look_at_write(27.5);
  EXPECT_EQ(loop.watchman().outside, 1u);
  loop.begin(sim::FaultKind::setpoint_by_hand, 0, -1, 20);
  loop.cycles(1);  // it has been seen
  loop.look_at_write(26.5);
  EXPECT_EQ(loop.watchman().beyond_a_step, 1u);
  EXPECT_EQ(loop.watchman().while_released, 1u) << "and it was left to the other hand";
  inside(loop.controller()).replay.push(typename ReplayRing<T, float>::Row{1e9F});
  loop.cycles(1);
  EXPECT_EQ(loop.watchman().learned_bad, 1u);
  inside(loop.controller()).learning.weights.values[7] = std::numeric_limits<float>::infinity();
  loop.cycles(1);
  EXPECT_EQ(loop.watchman().weights_broken, 1u);
}

}  // namespace
}  // namespace airside::fault_matrix
