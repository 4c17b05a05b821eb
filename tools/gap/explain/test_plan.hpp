#pragma once
// Tests on site that may tell effects apart, and recordings in which they are done.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/gap/inference/selection.hpp"

namespace airside::tools::gap {

constexpr int rows_an_hour = 3600 / row_s;

/// Commands that a test gives, every day within its hours; what it does not command stays as recorded.
struct TestPlan {
  std::string name;                       ///< "night_coldest"
  std::string text;                       ///< what to do on site, a sentence without its end
  double from_h = 0, to_h = 24;           ///< hours of the day; over midnight where to_h <= from_h
  std::optional<double> setpoint_degc;    ///< held
  std::optional<double> turns_with_degc;  ///< every other 3 h this setpoint instead
  std::optional<double> vav_command;      ///< 0 closed, 1 open
  int vav = -1;                           ///< 0-based; -1: all
  std::optional<double> fcu_command;      ///< 0 off, 1 on
  int fcu = -1;                           ///< 0-based; -1: all
  bool weekend = false;                   ///< from Saturday 0:00 to Sunday 24:00
};

struct ExperimentRules {
  int days = 3;          ///< a test's, at most
  int history_days = 2;  ///< lived through before it as recorded
  double lowest_setpoint_degc = 20, highest_setpoint_degc = 26;
  double coldest_degc = 18, warmest_degc = 30;  ///< zones; a test that leads beyond is proposed last
  double margin = 12;                           ///< 2 ln likelihood that a verdict asks between two effects
  int finalists = 4;         ///< tests in which parameters are simulated too: the others have only a bound
  int most_parameters = 16;  ///< simulated in those, the most uncertain ones first
  Nuisance nuisance = {};
};

/// Tests that make sense for these members on this site: setpoint steps by night and day, all boxes closed, fan coils
/// off or on, a closed weekend; a single box or fan coil where a member is at one.
std::vector<TestPlan> test_plans(const sim::Channels& channels, std::span<const sim::EffectChange> members,
                                 const ExperimentRules& rules = {});

/// Gives the plan's commands at t to a row, if it acts then; `begin` the midnight of the test's first day.
/// Whether the row is another one now.
bool command_by(const TestPlan& plan, CivilTime begin, CivilTime t, sim::RecordedRow& row);

/// Every test that can be proposed on a site.
std::vector<TestPlan> all_plans(const sim::Channels& channels, const std::vector<sim::Effect>& effects);

/// One of them.  Errors: hal::InputError that lists the names.
TestPlan named_plan(const std::string& name, const sim::Channels& channels, const std::vector<sim::Effect>& effects);

/// A recording with a test in its last days.
struct TestRecording {
  sim::Recording recording;
  std::size_t first_row = 0;  ///< of the first command
  std::size_t changed = 0;    ///< rows whose commands differ from what was recorded
};
/// Days of the recording's end, with the test's commands in the last of them: its weather and people are the only ones
/// that are known. Empty where the recording is too short or has no weekend.
std::optional<TestRecording> test_recording(const sim::Recording& recording, const TestPlan& plan,
                                            const ExperimentRules& rules = {});

/// Whether the recording's commands are the plan's on a day at least, in four fifths of its hours.
bool was_done(const sim::Recording& recording, const TestPlan& plan);

}  // namespace airside::tools::gap
