#pragma once
// Who operates a measured room on the days of a test on site: the test's commands within the site's safety envelope,
// and as ever in all other hours.

#include <vector>

#include "airside/supervision/envelope.hpp"
#include "sim/energyplus/options.hpp"
#include "tools/gap/explain/test_plan.hpp"

namespace airside::tools::gap {

/// A test on whole days.
struct TestDays {
  TestPlan plan;
  CivilTime from, to;  ///< midnights of its first day and after its last
};

/// The plan's next days after rules.history_days from `free` on, a midnight; those of a weekend wait for Saturday.
TestDays next_days(const TestPlan& plan, CivilTime free, const ExperimentRules& rules = {});

class TestCommands {
 public:
  /// `from`: from then on every setpoint, the usual ones too, passes the envelope.
  TestCommands(std::vector<TestDays> tests, const SafetyEnvelope& envelope, CivilTime from)
      : tests_(std::move(tests)), envelope_(envelope), from_(from) {}

  /// What the cycle at t sends; `usual` without a test, `last` the cycle before.  degC.
  double setpoint_degc(CivilTime t, double usual, double last) const;

  /// Boxes and fan coils: 0 or 1 where a test commands it at t, NaN where none does.  Shape: one a VAV, one an FCU.
  sim::RecordedRow commands(CivilTime t, int vavs, int fcus) const;
  /// Whether a test commands one of them at t; nullopt: none does.
  std::optional<bool> box(int vav, CivilTime t) const;
  std::optional<bool> fan_coil(int fcu, CivilTime t) const;
  const std::vector<TestDays>& tests() const { return tests_; }

 private:
  std::vector<TestDays> tests_;
  SafetyEnvelope envelope_;
  CivilTime from_;
};

/// What tests command of fan coils that follow their thermostats, by a clock behind the log's by `ahead_s`.
std::vector<sim::SwitchedFanCoil> switched_by_tests(const TestCommands& tests, int fcus, std::int64_t ahead_s);

}  // namespace airside::tools::gap
