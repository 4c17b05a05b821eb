#pragma once
// The two files of a replay: the model with its outputs and the commands as schedules, and the weather. Together they
// are the run.

#include <filesystem>
#include <string>

#include "sim/energyplus/replay/replay.hpp"

namespace airside::sim {

constexpr int replay_step_s = 180;
constexpr int replay_steps_per_day = 86400 / replay_step_s;
/// Days that are simulated before the recording, on top of the engine's warm-up, which repeats the first of them three
/// times or more until its own criterion holds.
constexpr int replay_lead_days = 2;
static_assert(replay_lead_days < lead_days, "the measured weather reaches back so far");
constexpr const char* heat_schedule_prefix = "Unknown Heat ";  ///< kW; followed by the 1-based zone, VAV zones first
constexpr const char* cold_schedule_prefix = "Unknown Cold ";  ///< the same, taken from it: no schedule may be negative

/// The whole days that a replay simulates, and where they lie in the engine's calendar of 365 days.
struct ReplayDays {
  CivilTime begin;  ///< a midnight
  int days = 0;
  int first_step = 0;  ///< steps from 1 January to `begin`
  int year = 2021;     ///< a label: no leap year, and `begin` falls on its own weekday
  int step_s = replay_step_s;
  int steps_per_day() const { return 86400 / step_s; }
  int steps() const { return days * steps_per_day(); }
  /// Steps from `begin` to t.
  int step_at(CivilTime t) const { return static_cast<int>((t.seconds - begin.seconds) / step_s); }
};

/// Errors: hal::InputError for a recording that is empty, off the time step or shaped unlike the twin.
ReplayDays replay_days(const EnergyPlusTwin& twin, const Recording& recording);

/// Measured weather of the whole days: what lies outside the measured stretch is the nearest day's.
Weather replay_weather(const Recording& recording, const ReplayDays& days);

/// What a replay commands: for each schedule of the model the column that holds its values, one a step of the replayed
/// days; of equal columns there is one.
struct ReplayCommands {
  std::vector<std::string> schedules;
  std::vector<std::size_t> columns;         ///< of each schedule
  std::vector<std::vector<double>> values;  ///< column, step
};

ReplayCommands replay_commands(const EnergyPlusTwin& twin, const Recording& recording, const ReplayDays& days,
                               bool thermostats);

/// The twin's model with the replay's dates, outputs and, if asked, thermostats; the schedules of the commands are
/// constant. Warm-up days end by the engine's own criterion. Errors: hal::InputError for a schedule that the model has
/// not.
nlohmann::json replay_model(const EnergyPlusTwin& twin, const ReplayDays& days, const ReplayCommands& commands,
                            bool thermostats);

/// Lets the model's schedules follow the commands: a day that occurs, in whichever column, is one schedule of days.
/// What never changes stays a constant.  Values reach the engine with all their digits. Errors: hal::InputError for
/// more than 53 days where the model has holidays: its schedules have 53 places, of weeks then, and a week says nothing
/// of which holiday.
void follow_commands(nlohmann::json& model, const ReplayDays& days, const ReplayCommands& commands);

}  // namespace airside::sim
