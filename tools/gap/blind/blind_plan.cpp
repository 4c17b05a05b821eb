#include "tools/gap/blind/blind_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "sim/stateless_draw.hpp"

namespace airside::tools::gap {

CivilTime start_of_window(int window) {
  constexpr int month_day[blind_windows][2] = {{5, 10}, {6, 20}, {7, 15}, {8, 20}, {9, 25}};
  return sim::civil_midnight(2021, month_day[window][0], month_day[window][1]);
}

PlannedCase planned_case(const BlindPlan& plan, int i) {
  constexpr double wanted_ratios[] = {0.5, 1.0, 3.0};
  PlannedCase c;
  c.window = plan.window > 0 ? BlindWindow{plan.window - 1, i % 2 == 0}
                             : BlindWindow{i % blind_windows, i / blind_windows % 2 == 0};
  int at = i;
  const auto belongs = [&at](int count) {
    if (at < count) return true;
    at -= count;
    return false;
  };
  c.set = belongs(plan.single) ? "single" : belongs(plan.null) ? "null" : belongs(plan.outside) ? "outside" : "pair";
  if (c.set == "single") c.ratio = plan.ratio > 0 ? plan.ratio : wanted_ratios[at / blind_windows % 3];
  if (c.set == "pair") c.ratio = 3;
  c.energyplus = plan.engine == BlindEngine::energyplus || (plan.engine == BlindEngine::mixed && at % 4 == 3);
  c.turn = plan.engine != BlindEngine::mixed ? at : c.energyplus ? at / 4 : at - at / 4;
  return c;
}

std::uint64_t seed_of_case(std::uint64_t plan_seed, int i) {
  return plan_seed * 1'000'003 + static_cast<std::uint64_t>(i) * 2;
}

std::filesystem::path weather_of_window(const std::filesystem::path& folder, int window) {
  return folder / "weather" / fmt::format("{}.epw", window + 1);
}

std::vector<int> in_order_of_name(std::uint64_t plan_seed, int total) {
  std::vector<int> order(static_cast<std::size_t>(total));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [plan_seed](int a, int b) {
    return sim::draw_bits(plan_seed, draw_name, 0, a) < sim::draw_bits(plan_seed, draw_name, 0, b);
  });
  return order;
}

BlindPlan plan_of(int cases, std::uint64_t seed) {
  BlindPlan plan;
  plan.seed = seed;
  const auto share = [cases](int of) { return static_cast<int>(std::lround(cases * of / 760.0)); };
  plan.null = share(300);
  plan.outside = share(60);
  plan.pairs = share(100);
  plan.single = std::max(0, cases - plan.null - plan.outside - plan.pairs);
  return plan;
}

int blind_steps(const BlindPlan& plan) {
  std::set<std::pair<bool, BlindWindow>> shared;
  for (int i = 0; i < plan.total(); ++i) {
    const PlannedCase c = planned_case(plan, i);
    shared.insert({c.energyplus, c.window});
  }
  return plan.total() + static_cast<int>(shared.size());
}

}  // namespace airside::tools::gap
