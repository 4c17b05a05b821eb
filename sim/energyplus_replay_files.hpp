#pragma once
// The three files of a replay: the model with its outputs and schedules, the commands, and the weather. Together
// they are the run.

#include <filesystem>
#include <string>

#include "sim/energyplus_replay.hpp"

namespace airside::sim {

constexpr int replay_step_s = 180;
constexpr const char* heat_schedule_prefix = "Unknown Heat ";  ///< kW; followed by the 1-based zone, VAV zones first

/// The whole days that a replay simulates, and where they lie in the engine's calendar of 365 days.
struct ReplayDays {
  CivilTime begin;  ///< a midnight
  int days = 0;
  int first_step = 0;  ///< steps from 1 January to `begin`
  int year = 2021;     ///< a label: no leap year, and `begin` falls on its own weekday
  int steps() const { return days * (86400 / replay_step_s); }
  /// Steps from `begin` to t.
  int step_at(CivilTime t) const { return static_cast<int>((t.seconds - begin.seconds) / replay_step_s); }
};

/// Errors: hal::InputError for a recording that is empty, off the time step or shaped unlike the twin.
ReplayDays replay_days(const EnergyPlusTwin& twin, const Recording& recording);

/// Measured weather of the whole days: what lies outside the measured stretch is the nearest day's.
Weather replay_weather(const Recording& recording, const ReplayDays& days);

/// What of commands.csv is not repetition: its heading, and one line a step of the replayed days.
struct CommandText {
  std::string heading;
  std::vector<std::string> days;       ///< the lines of a day
  std::vector<std::string> schedules;  ///< names of the schedules that read the file ..
  std::vector<int> columns;            ///< .. and the 1-based column of each; equal columns are one
};

CommandText replay_commands(const EnergyPlusTwin& twin, const Recording& recording, const ReplayDays& days,
                            bool thermostats);

/// The whole calendar year: before the replayed days the first of them is repeated, after them the last, since the
/// engine reads no shorter file.
/// Errors: hal::InputError if the file cannot be written.
void write_commands(const CommandText& commands, const ReplayDays& days, const std::filesystem::path& file);

/// The twin's model with the replay's dates, outputs, schedules and, if asked, thermostats.
/// Errors: hal::InputError for a schedule that the model has not.
nlohmann::json replay_model(const EnergyPlusTwin& twin, const ReplayDays& days, const CommandText& commands,
                            bool thermostats);

}  // namespace airside::sim
