#include "tools/adopt/season_runs.hpp"

#include <fmt/format.h>

#include <cmath>

namespace airside::tools {

namespace {

using nlohmann::json;

constexpr const char* constant_type = "Schedule:Constant";

/// Of 2021.
struct Monday {
  int month, day;
};

Monday monday_of(Season season, bool north) {
  if (season == Season::autumn) return north ? Monday{10, 11} : Monday{4, 12};
  return (season == Season::summer) == north ? Monday{7, 12} : Monday{1, 11};
}

std::string until(double hours) {
  const int minutes = static_cast<int>(std::lround(hours * 60));
  return fmt::format("Until: {:02}:{:02}", minutes / 60, minutes % 60);
}

/// A day's fields of a Schedule:Compact.
void add_day(json& fields, const char* days, const SiteChoices& choices, bool works) {
  const auto add = [&fields](const auto& value) { fields.push_back({{"field", value}}); };
  add(std::string("For: ") + days);
  if (works && choices.work.to_h > choices.work.from_h) {
    if (choices.work.from_h > 0) {
      add(until(choices.work.from_h));
      add(choices.off_degc);
    }
    add(until(choices.work.to_h));
    add(choices.work_degc);
    if (choices.work.to_h >= 24) return;
  }
  add(until(24));
  add(choices.off_degc);
}

}  // namespace

Observation SeasonRuns::run(const json& model, const AirLoop& loop, Season season, int days, const std::string& what) {
  if (progress_) progress_(done_, planned_, fmt::format("{}: {}", text_of(season), what));
  const Monday monday = monday_of(season, weather_.latitude_deg >= 0);
  const ObservationPlan plan{&model, &loop, weather_.file, monday.month, monday.day, days};
  Observation seen = observe(plan, install_, folder(), place_);
  ++done_;
  return seen;
}

json held_at(json patched, const std::string& schedule, double degc) {
  patched[constant_type][schedule]["hourly_value"] = degc;
  return patched;
}

json scheduled(json patched, const std::string& schedule, const SiteChoices& choices) {
  json fields = json::array({{{"field", "Through: 12/31"}}});
  if (choices.work.weekday_only) {
    add_day(fields, "Weekdays", choices, true);
    add_day(fields, "AllOtherDays", choices, false);
  } else {
    add_day(fields, "AllDays", choices, true);
  }
  json& constants = patched[constant_type];
  constants.erase(schedule);
  if (constants.empty()) patched.erase(constant_type);
  patched["Schedule:Compact"][schedule] = {{"data", fields}};
  return patched;
}

}  // namespace airside::tools
