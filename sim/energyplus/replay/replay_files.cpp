#include "sim/energyplus/replay/replay_files.hpp"

#include <algorithm>
#include <cmath>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/rooms.hpp"

namespace airside::sim {
namespace {

void expect_of_recording(bool holds, const std::string& found, const char* expected) {
  if (!holds) throw hal::InputError("recording", found, expected, "choose another stretch, or the twin that fits it");
}

void check_rows(const EnergyPlusTwin& twin, const Recording& recording) {
  const auto finite = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  };
  expect_of_recording(!recording.rows.empty() && recording.station != nullptr, "no rows or no weather station",
                      "rows, and the weather of their days");
  expect_of_recording(recording.from.second_of_day() % twin.step_s == 0, "a start at " + text_of(recording.from),
                      "a start at a multiple of the time step");
  expect_of_recording(twin.loops.dampers.size() == twin.names.interior_zones.size(),
                      std::to_string(twin.loops.dampers.size()) + " dampers of the twin", "one a VAV zone");
  for (std::size_t i = 0; i < recording.rows.size(); ++i) {
    const RecordedRow& row = recording.rows[i];
    const std::string at = " at " + text_of(recording.time(i));
    expect_of_recording(
        row.vav_on.size() == twin.names.interior_zones.size() && row.fcu_on.size() == twin.names.perimeter_zones.size(),
        std::to_string(row.vav_on.size()) + " VAVs and " + std::to_string(row.fcu_on.size()) + " fan coils" + at,
        "as many as the twin has");
    const bool setpoint = std::isfinite(row.setpoint_degc) || twin.names.supply_setpoint_schedule.empty();
    expect_of_recording(setpoint && finite(row.vav_on) && finite(row.fcu_on) && finite(row.commands),
                        "a missing command" + at, "a stretch without gaps");
    const std::size_t commands = twin.own ? twin.own->commands.size() : 0;
    expect_of_recording(row.commands.size() == commands,
                        std::to_string(row.commands.size()) + " commands of further schedules" + at,
                        "as many as the twin has");
    const std::size_t zones = row.vav_on.size() + row.fcu_on.size();
    expect_of_recording(row.zone_heat_kw.empty() || (row.zone_heat_kw.size() == zones && finite(row.zone_heat_kw)),
                        "heat of " + std::to_string(row.zone_heat_kw.size()) + " zones" + at,
                        "a number for every zone");
  }
}

/// A year that is no leap year in which the day has its own weekday; the recording's own if it will do.
int engine_year(CivilTime midnight) {
  const std::string date = text_of({civil_midnight(2023, 1, 1).seconds + second_of_year(midnight)});
  const int month = std::stoi(date.substr(5, 2)), day = std::stoi(date.substr(8, 2));
  int year = std::stoi(text_of(midnight).substr(0, 4));
  const auto leap = [](int y) { return y % 4 == 0 && (y % 100 != 0 || y % 400 == 0); };
  while (leap(year) || civil_midnight(year, month, day).weekday() != midnight.weekday()) --year;
  return year;
}

std::string schedule_at(std::string pattern, int place) {
  const auto mark = pattern.find('#');
  if (mark != std::string::npos) pattern.replace(mark, 1, std::to_string(place));
  return pattern;
}

/// Of equal columns only the first is kept.
class CommandColumns {
 public:
  void add(const std::string& schedule, std::vector<double> values) {
    auto& known = commands_.values;
    const auto found = std::find(known.begin(), known.end(), values);
    commands_.schedules.push_back(schedule);
    commands_.columns.push_back(static_cast<std::size_t>(found - known.begin()));
    if (found == known.end()) known.push_back(std::move(values));
  }
  ReplayCommands commands() { return std::move(commands_); }

 private:
  ReplayCommands commands_;
};

}  // namespace

ReplayDays replay_days(const EnergyPlusTwin& twin, const Recording& recording) {
  check_rows(twin, recording);
  ReplayDays days;
  days.begin = {(recording.from.day() - replay_lead_days) * 86400};
  days.days = static_cast<int>(CivilTime{recording.to().seconds - 1}.day() - days.begin.day()) + 1;
  days.step_s = twin.step_s;
  days.first_step = static_cast<int>(second_of_year(days.begin) / days.step_s);
  days.year = engine_year(days.begin);
  expect_of_recording(days.first_step + days.steps() <= 365 * days.steps_per_day(),
                      "days from " + text_of(days.begin) + " to " + text_of(recording.to()),
                      "a stretch and the days before it within one calendar year");
  return days;
}

Weather replay_weather(const Recording& recording, const ReplayDays& days) {
  const std::shared_ptr<const Weather> measured = measured_weather(recording, days.step_s);
  const auto& known = measured->records();
  const auto whole = static_cast<std::size_t>(days.steps());
  const auto before = static_cast<std::size_t>(days.first_step - measured->first_interval());
  std::vector<WeatherRecord> records(whole);
  for (std::size_t i = 0; i < whole; ++i) {
    std::size_t there = before + i;
    while (there >= known.size()) there -= static_cast<std::size_t>(days.steps_per_day());
    records[i] = known[there];
  }
  return {measured->location(), measured->description(), days.step_s, days.first_step, std::move(records)};
}

ReplayCommands replay_commands(const EnergyPlusTwin& twin, const Recording& recording, const ReplayDays& days,
                               bool thermostats) {
  const int vavs = static_cast<int>(twin.names.interior_zones.size());
  const int fcus = static_cast<int>(twin.names.perimeter_zones.size());
  const auto steps = static_cast<std::size_t>(days.steps());
  // Setpoint lag and people are the room loops' own, on a day like every other.
  RoomLoopOptions quiet = twin.loops;
  quiet.occupancy_noise = 0;
  quiet.vav_off_per_day = 0;
  RoomLoops loops(quiet, vavs, fcus, 0, recording.at(days.begin).setpoint_degc);
  const std::vector<double> any_temps(static_cast<std::size_t>(fcus), twin.loops.fcu_setpoint_degc);

  std::vector<double> supply(steps);
  std::vector<std::vector<double>> vav_on(static_cast<std::size_t>(vavs), supply), fcu_on, people;
  fcu_on.assign(static_cast<std::size_t>(fcus), supply);
  people.assign(static_cast<std::size_t>(vavs + fcus), supply);
  for (std::size_t step = 0; step < steps; ++step) {
    const CivilTime t{days.begin.seconds + static_cast<std::int64_t>(step) * days.step_s};
    const RecordedRow& row = recording.at(t);
    const RoomCommands& commands = loops.step(t, days.step_s, row.setpoint_degc, any_temps);
    supply[step] = commands.supply_setpoint_degc;
    for (std::size_t i = 0; i < vav_on.size(); ++i) vav_on[i][step] = row.vav_on[i];
    for (std::size_t i = 0; i < fcu_on.size(); ++i) fcu_on[i][step] = row.fcu_on[i];
    for (std::size_t z = 0; z < people.size(); ++z) people[z][step] = commands.occupancy[z];
  }

  // Heat that the model does not know: only where the recording has some.
  const bool heated = std::any_of(recording.rows.begin(), recording.rows.end(),
                                  [](const RecordedRow& row) { return !row.zone_heat_kw.empty(); });
  std::vector<std::vector<double>> heat(heated ? people.size() : 0, std::vector<double>(steps)), cold = heat;
  for (std::size_t step = 0; heated && step < steps; ++step) {
    const RecordedRow& row = recording.at({days.begin.seconds + static_cast<std::int64_t>(step) * days.step_s});
    for (std::size_t z = 0; z < row.zone_heat_kw.size(); ++z) {
      heat[z][step] = std::max(0.0, row.zone_heat_kw[z]);
      cold[z][step] = std::max(0.0, -row.zone_heat_kw[z]);
    }
  }

  CommandColumns columns;
  if (!twin.names.supply_setpoint_schedule.empty()) columns.add(twin.names.supply_setpoint_schedule, std::move(supply));
  const auto add_each = [&columns](const std::string& pattern, auto first, auto last) {
    for (int place = 1; first != last; ++first, ++place) columns.add(schedule_at(pattern, place), std::move(*first));
  };
  if (!twin.own) {
    std::vector<std::vector<double>> dampers;
    for (const double damper : twin.loops.dampers) dampers.emplace_back(steps, damper);
    add_each(twin.names.vav_on_schedule, vav_on.begin(), vav_on.end());
    add_each(twin.names.vav_damper_schedule, dampers.begin(), dampers.end());
    if (!thermostats) add_each(twin.names.fcu_on_schedule, fcu_on.begin(), fcu_on.end());
    add_each(twin.names.interior_occupancy_schedule, people.begin(), people.begin() + vavs);
    add_each(twin.names.perimeter_occupancy_schedule, people.begin() + vavs, people.end());
  }
  for (std::size_t i = 0; twin.own && i < twin.own->commands.size(); ++i) {
    std::vector<double> values(steps);
    for (std::size_t step = 0; step < steps; ++step)
      values[step] = recording.at({days.begin.seconds + static_cast<std::int64_t>(step) * days.step_s}).commands[i];
    columns.add(twin.own->commands[i], std::move(values));
  }
  add_each(std::string(heat_schedule_prefix) + "#", heat.begin(), heat.end());
  add_each(std::string(cold_schedule_prefix) + "#", cold.begin(), cold.end());
  return columns.commands();
}

}  // namespace airside::sim
