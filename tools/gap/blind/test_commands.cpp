#include "tools/gap/blind/test_commands.hpp"

#include <cmath>
#include <limits>

namespace airside::tools::gap {

namespace {

constexpr int most_places = 64;

std::optional<bool> switched(double commanded) {
  return std::isfinite(commanded) ? std::optional(commanded > 0.5) : std::nullopt;
}

}  // namespace

TestDays next_days(const TestPlan& plan, CivilTime free, const ExperimentRules& rules) {
  constexpr int saturday = 5;
  TestDays days{plan, {free.seconds + rules.history_days * seconds_per_day}, {}};
  while (plan.weekend && days.from.weekday() != saturday) days.from.seconds += seconds_per_day;
  days.to.seconds = days.from.seconds + (plan.weekend ? 2 : rules.days) * seconds_per_day;
  return days;
}

double TestCommands::setpoint_degc(CivilTime t, double usual, double last) const {
  if (t < from_) return usual;
  sim::RecordedRow row;
  row.setpoint_degc = usual;
  for (const TestDays& test : tests_) {
    // Places do not matter to a setpoint.
    TestPlan plan = test.plan;
    plan.vav_command = plan.fcu_command = std::nullopt;
    if (!(t < test.from) && t < test.to) command_by(plan, test.from, t, row);
  }
  return envelope_.limit(row.setpoint_degc, last, usual).setpoint_degc();
}

std::optional<bool> TestCommands::box(int vav, CivilTime t) const {
  return switched(commands(t, most_places, most_places).vav_on.at(static_cast<std::size_t>(vav)));
}

std::optional<bool> TestCommands::fan_coil(int fcu, CivilTime t) const {
  return switched(commands(t, most_places, most_places).fcu_on.at(static_cast<std::size_t>(fcu)));
}

sim::RecordedRow TestCommands::commands(CivilTime t, int vavs, int fcus) const {
  constexpr double nobody = std::numeric_limits<double>::quiet_NaN();
  sim::RecordedRow row;
  row.vav_on.assign(static_cast<std::size_t>(vavs), nobody);
  row.fcu_on.assign(static_cast<std::size_t>(fcus), nobody);
  for (const TestDays& test : tests_) {
    if (!(t < test.from) && t < test.to) command_by(test.plan, test.from, t, row);
  }
  return row;
}

std::vector<sim::SwitchedFanCoil> switched_by_tests(const TestCommands& tests, int fcus, std::int64_t ahead_s) {
  std::vector<sim::SwitchedFanCoil> list;
  for (const TestDays& days : tests.tests()) {
    for (int f = 0; f < fcus; ++f) {
      for (CivilTime t = days.from; t < days.to; t.seconds += row_s) {
        const std::optional<bool> on = tests.fan_coil(f, t);
        const std::int64_t now_s = t.seconds - ahead_s;
        if (!on) continue;
        if (list.empty() || list.back().fcu != f || list.back().to_s != now_s || list.back().on != *on)
          list.push_back({f, now_s, now_s, *on});
        list.back().to_s = now_s + row_s;
      }
    }
  }
  return list;
}

}  // namespace airside::tools::gap
