#pragma once
// What an adopted site has as its settings, from what its model did: hours, target, schedule, range, meters.

#include <array>
#include <string>
#include <vector>

#include "tools/adopt/loop/loop_meters.hpp"
#include "tools/adopt/observation.hpp"

namespace airside::tools {

/// From hour to hour of a day.
struct DayHours {
  double from_h = 0, to_h = 24;
  bool weekday_only = false;
  bool interrupted = false;  ///< the pattern has more pieces than one: these hours are an approximation
};

/// First and last hour of a day with people; none: from_h = to_h.
struct PeopleHours {
  double from_h = 0, to_h = 0;
  friend bool operator==(const PeopleHours&, const PeopleHours&) = default;
};

struct SiteChoices {
  double target_degc = 24;
  DayHours work, fan;
  std::array<PeopleHours, 7> people_by_day{};  ///< from Monday on, of the summer week
  bool two_day_types = false;                  ///< weekends have people, and other hours of them than working days
  bool people = false;  ///< the hours are those of the people; else of the thermostats, or assumed
  bool assumed_hours = false;
  double min_degc = 12, max_degc = 20, step_k = 0.1;
  double work_degc = 14, off_degc = 14;  ///< the model's own setpoint, as the schedule to fall back to
  double winter_degc = 14;               ///< the same at work in the winter week
  std::vector<std::string> powers;       ///< meters, at most 4
  double outdoor_share = 0;              ///< least outdoor air, share of the design flow; 0: unknown
  double mean_flow_kg_s = 0;             ///< while the fan runs
};

/// From a week of summer and one of winter under the model's own control.
SiteChoices site_choices(const Observation& summer, const Observation& winter, TerminalKind kind,
                         const LoopMeters& meters);

/// Whether a step is in the site's working hours.
bool works(const SiteChoices& choices, const Observation& week, std::size_t step);

/// Steps at which the supply fan runs: more than 3 % of its largest flow.
std::vector<bool> fan_runs(const Observation& week);

/// What two runs with constant setpoints, the range's ends, differ in, over working hours with the fan on.
struct Response {
  bool known = false;
  double supply_low_degc = 0, supply_high_degc = 0;  ///< means of what was reached
  double room_low_degc = 0, room_high_degc = 0;
  double damper_low = -1, damper_high = -1;  ///< means; -1: none
  double kw_low = 0, kw_high = 0;            ///< sum of the site's meters
  double supply_gain = 0, room_gain = 0;     ///< K per K of setpoint
  bool has_authority() const { return supply_gain > 0.3; }
};
Response response_of(const Observation& low, const Observation& high, const SiteChoices& choices);

}  // namespace airside::tools
