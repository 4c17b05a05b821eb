#include "tools/gap/explain/test_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/text/input_error.hpp"
#include "hal/text/toml_section.hpp"
#include "tools/gap/model/stretches.hpp"

namespace airside::tools::gap {

namespace {

bool acts_at(const TestPlan& plan, double hour) {
  return plan.to_h > plan.from_h ? hour >= plan.from_h && hour < plan.to_h : hour >= plan.from_h || hour < plan.to_h;
}

void command(std::vector<double>& list, int place, double value) {
  if (place < 0)
    std::fill(list.begin(), list.end(), value);
  else
    list.at(static_cast<std::size_t>(place)) = value;
}

/// Changes the row; false where it already was so.
bool apply_plan(const TestPlan& plan, double hours_since_first, sim::RecordedRow& row) {
  const sim::RecordedRow before = row;
  if (plan.setpoint_degc) row.setpoint_degc = *plan.setpoint_degc;
  if (plan.turns_with_degc && static_cast<int>(hours_since_first / 3) % 2 == 1)
    row.setpoint_degc = *plan.turns_with_degc;
  if (plan.vav_command) command(row.vav_on, plan.vav, *plan.vav_command);
  if (plan.fcu_command) command(row.fcu_on, plan.fcu, *plan.fcu_command);
  return row.setpoint_degc != before.setpoint_degc || row.vav_on != before.vav_on || row.fcu_on != before.fcu_on;
}

bool is_as_planned(const TestPlan& plan, const sim::RecordedRow& row) {
  constexpr double setpoint_tolerance_k = 0.3, command_tolerance = 0.5;
  const auto near = [](const std::optional<double>& planned, double degc) {
    return planned && std::abs(degc - *planned) <= setpoint_tolerance_k;
  };
  const auto obeys = [](const std::optional<double>& planned, const std::vector<double>& list, int place) {
    if (!planned) return true;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const bool concerned = place < 0 || static_cast<int>(i) == place;
      if (concerned && std::abs(list[i] - *planned) > command_tolerance) return false;
    }
    return true;
  };
  if (plan.setpoint_degc && !near(plan.setpoint_degc, row.setpoint_degc) &&
      !near(plan.turns_with_degc, row.setpoint_degc))
    return false;
  return obeys(plan.vav_command, row.vav_on, plan.vav) && obeys(plan.fcu_command, row.fcu_on, plan.fcu);
}

/// VAV boxes and fan coils at which members are.
void places_of_members(const sim::Channels& channels, std::span<const sim::EffectChange> members,
                       std::vector<int>& vavs, std::vector<int>& fcus) {
  const auto add = [](std::vector<int>& list, int place) {
    if (std::find(list.begin(), list.end(), place) == list.end()) list.push_back(place);
  };
  for (const sim::EffectChange& member : members) {
    const int place = member.at.place;
    switch (member.at.effect->place) {
      case sim::PlaceKind::vav: add(vavs, place); break;
      case sim::PlaceKind::fcu: add(fcus, place); break;
      case sim::PlaceKind::zone:
        if (place < channels.rooms)
          add(vavs, place);
        else
          add(fcus, place - channels.rooms);
        break;
      case sim::PlaceKind::vav_pair: {
        const auto [a, b] = sim::vav_pair(place, channels.rooms);
        add(vavs, a);
        add(vavs, b);
        break;
      }
      case sim::PlaceKind::floor:
      case sim::PlaceKind::facade: break;
    }
  }
}

}  // namespace

std::vector<TestPlan> test_plans(const sim::Channels& channels, std::span<const sim::EffectChange> members,
                                 const ExperimentRules& rules) {
  const double cold = rules.lowest_setpoint_degc, warm = rules.highest_setpoint_degc;
  const auto degc = [](double t) { return fmt::format("{:.0f} degC", t); };
  std::vector<TestPlan> plans;
  const auto add = [&plans](const char* name, std::string text, double from_h, double to_h) -> TestPlan& {
    TestPlan plan;
    plan.name = name;
    plan.text = std::move(text);
    plan.from_h = from_h;
    plan.to_h = to_h;
    return plans.emplace_back(std::move(plan));
  };
  TestPlan& purge = add("night_purge", "open all boxes from 20 to 6 h and supply air at " + degc(cold), 20, 6);
  purge.setpoint_degc = cold;
  purge.vav_command = 1;
  add("night_warm", "supply air at " + degc(warm) + " from 20 to 6 h", 20, 6).setpoint_degc = warm;
  add("day_cold", "supply air at " + degc(cold) + " from 9 to 17 h", 9, 17).setpoint_degc = cold;
  add("day_warm", "supply air at " + degc(warm) + " from 9 to 17 h", 9, 17).setpoint_degc = warm;
  TestPlan& steps =
      add("steps", "supply air at " + degc(cold) + " and " + degc(warm) + " by turns, 3 h each, day and night", 0, 24);
  steps.setpoint_degc = cold;
  steps.turns_with_degc = warm;
  add("fan_off_night", "close all boxes from 20 to 6 h", 20, 6).vav_command = 0;
  add("fan_off_noon", "close all boxes from 11 to 13 h", 11, 13).vav_command = 0;
  if (channels.fcus > 0) {
    add("fcu_off", "switch all fan coils off, day and night", 0, 24).fcu_command = 0;
    add("fcu_on_night", "run all fan coils from 20 to 6 h", 20, 6).fcu_command = 1;
  }
  TestPlan& weekend =
      add("weekend_closed", "close all boxes and switch all fan coils off from Saturday to Sunday", 0, 24);
  weekend.vav_command = 0;
  if (channels.fcus > 0) weekend.fcu_command = 0;
  weekend.weekend = true;

  std::vector<int> vavs, fcus;
  places_of_members(channels, members, vavs, fcus);
  for (const int vav : vavs) {
    TestPlan& shut = add("box_closed_night", fmt::format("close box {} from 20 to 6 h", vav + 1), 20, 6);
    shut.name += fmt::format("@{}", vav + 1);
    shut.vav_command = 0;
    shut.vav = vav;
  }
  for (const int fcu : fcus) {
    TestPlan& off = add("fcu_off", fmt::format("switch fan coil {} off, day and night", fcu + 1), 0, 24);
    off.name += fmt::format("@{}", fcu + 1);
    off.fcu_command = 0;
    off.fcu = fcu;
    TestPlan& on = add("fcu_on_night", fmt::format("run fan coil {} from 20 to 6 h", fcu + 1), 20, 6);
    on.name += fmt::format("@{}", fcu + 1);
    on.fcu_command = 1;
    on.fcu = fcu;
  }
  return plans;
}

std::vector<TestPlan> all_plans(const sim::Channels& channels, const std::vector<sim::Effect>& effects) {
  std::vector<sim::EffectChange> members;
  for (const sim::PlaceKind kind : {sim::PlaceKind::vav, sim::PlaceKind::fcu}) {
    const auto one = std::find_if(effects.begin(), effects.end(), [&](const auto& e) { return e.place == kind; });
    const int places = kind == sim::PlaceKind::vav ? channels.rooms : channels.fcus;
    for (int place = 0; one != effects.end() && place < places; ++place) members.push_back({{&*one, place}, 0});
  }
  return test_plans(channels, members);
}

TestPlan named_plan(const std::string& name, const sim::Channels& channels, const std::vector<sim::Effect>& effects) {
  const std::vector<TestPlan> plans = all_plans(channels, effects);
  const auto found = std::find_if(plans.begin(), plans.end(), [&](const TestPlan& p) { return p.name == name; });
  if (found != plans.end()) return *found;
  std::vector<std::string> names;
  for (const TestPlan& p : plans) names.push_back(p.name);
  const std::string near = hal::nearest_name(name, names);
  throw hal::InputError(
      "--test " + name, "no such test", fmt::format("one of {}", fmt::join(names, ", ")),
      near.empty() ? "the earlier report lists those that it proposes" : fmt::format("did you mean {}?", near));
}

bool command_by(const TestPlan& plan, CivilTime begin, CivilTime t, sim::RecordedRow& row) {
  const double since_h = static_cast<double>(t.seconds - begin.seconds) / 3600 - plan.from_h;
  return since_h >= 0 && acts_at(plan, t.second_of_day() / 3600.0) && apply_plan(plan, since_h, row);
}

std::optional<TestRecording> test_recording(const sim::Recording& recording, const TestPlan& plan,
                                            const ExperimentRules& rules) {
  const int whole = static_cast<int>(recording.rows.size()) / rows_per_day;
  const int days = plan.weekend ? 2 : rules.days;
  int last = whole;  // the day after the test's last
  if (plan.weekend) {
    const auto sunday_before = [&](int day) {
      return recording.time(static_cast<std::size_t>(day - 1) * rows_per_day).weekday() == 6;
    };
    while (last > 0 && !sunday_before(last)) --last;
  }
  const int first = last - days;
  const int history = std::min(rules.history_days, first);
  if (history < 1) return std::nullopt;
  TestRecording test;
  const auto begin = static_cast<std::size_t>(first - history) * rows_per_day;
  test.recording = part_of(recording, begin, static_cast<std::size_t>(last) * rows_per_day - begin);
  const auto first_of_test = static_cast<std::size_t>(history) * rows_per_day;
  const CivilTime begin_of_test = test.recording.time(first_of_test);
  test.first_row = test.recording.rows.size();
  for (std::size_t row = first_of_test; row < test.recording.rows.size(); ++row) {
    if (!command_by(plan, begin_of_test, test.recording.time(row), test.recording.rows[row])) continue;
    test.first_row = std::min(test.first_row, row);
    ++test.changed;
  }
  return test;
}

bool was_done(const sim::Recording& recording, const TestPlan& plan) {
  const std::size_t days = recording.rows.size() / rows_per_day;
  for (std::size_t day = 0; day < days; ++day) {
    std::size_t in_hours = 0, as_planned = 0;
    for (std::size_t row = day * rows_per_day; row < (day + 1) * rows_per_day; ++row) {
      const CivilTime t = recording.time(row);
      if (!acts_at(plan, t.second_of_day() / 3600.0) || (plan.weekend && t.weekday() < 5)) continue;
      ++in_hours;
      if (is_as_planned(plan, recording.rows[row])) ++as_planned;
    }
    if (in_hours > 0 && 10 * as_planned >= 8 * in_hours) return true;
  }
  return false;
}

}  // namespace airside::tools::gap
