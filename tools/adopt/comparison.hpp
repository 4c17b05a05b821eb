#pragma once
// The same days under the model's own control, under the site's schedule, and with the setpoint held: what a setpoint
// could be worth on this loop.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/adopt/choices.hpp"
#include "tools/adopt/observation.hpp"

namespace airside::tools {

enum class Season : std::uint8_t { summer, winter, autumn };
const char* text_of(Season season);

/// Means a day.
struct DayFigures {
  double kwh = 0;  ///< sum of the site's meters
  /// Zone degree-hours above cooling setpoint + 0.5 K and below heating setpoint - 0.5 K while people are there, sum
  /// over zones; without people in the model, in working hours.
  double outside_degch = 0;
};

struct HeldDays {
  double setpoint_degc = 0;
  DayFigures figures;
};

/// One season.
struct Comparison {
  Season season = Season::summer;
  Response response;
  DayFigures own, schedule;
  std::vector<HeldDays> constants;  ///< from the coldest to the warmest of the site's range
  std::size_t zones = 0;

  /// Where the fan does not run in working hours nothing can be said.
  bool known() const { return response.known && !constants.empty(); }
  /// Allowance: 0.05 degree-hours a zone and day.
  double allowance_degch() const { return 0.05 * static_cast<double>(zones); }
  /// The constant of least energy among those whose zones leave their band by no more than the allowance above the
  /// constant where they do so least. Errors: none; there must be a constant.
  const HeldDays& best() const;
};

DayFigures day_figures(const Observation& days, const SiteChoices& choices);

/// Days with the setpoint held at a value.
struct HeldObservation {
  double setpoint_degc = 0;
  Observation days;
};

/// Observations of the same days. `own` may be longer: its first days count. Season and response are the caller's.
Comparison comparison_of(const Observation& own, const Observation& schedule,
                         const std::vector<HeldObservation>& constants, const SiteChoices& choices);

}  // namespace airside::tools
