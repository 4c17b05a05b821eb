#pragma once
// What rows say of zones whose boxes modulate: figures and lines of a site with the objective "band".

#include <string>
#include <vector>

#include "tools/report/charts/report_input.hpp"
#include "tools/run/control_run.hpp"

namespace airside::tools {

/// One zone. Means and sums run over the rows in which people are in (all rows, where the log does not say) and air
/// flows (all, where it does not say).
struct ZoneFigures {
  std::string name;
  double above_degch_per_day = 0;  ///< degree-hours above its setpoint + 0.5 K
  double most_above_k = 0;         ///< above its setpoint
  double below_degch_per_day = 0;  ///< degree-hours below its heating setpoint - 0.5 K
  double saturated_h_per_day = 0;  ///< hours with its damper above 0.95
  double mean_damper = 0;          ///< NaN where the log shows none
};

struct ZoneBand {
  std::vector<ZoneFigures> zones;            ///< empty: the rows do not show a setpoint of every zone
  std::vector<double> setpoint_degc;         ///< mean of the zones, a value a row
  std::vector<std::vector<double>> dampers;  ///< one a zone, a value a row; empty where the log shows none
  std::vector<double> most_open;             ///< of all dampers, a value a row
  double above_degch_per_day() const;        ///< sum over zones
  double below_degch_per_day() const;        ///< the same
  double saturated_h_per_day() const;        ///< zone-hours
  bool shows_heating = false;                ///< the rows show a heating setpoint of every zone
  const ZoneFigures& worst() const;          ///< most degree-hours above; zones must not be empty
};

/// Names of the site's rooms: those of its twin's zones where the site file has them, else "room 1".
std::vector<std::string> room_names(const Site& site);

ZoneBand zone_band(const Site& site, const std::vector<hal::LogRow>& rows);

/// How it went, in a sentence; no schedule and no energy.
std::string band_headline(const ZoneBand& band, const std::string& days);
/// A row a zone.
ReportTable zones_table(const ZoneBand& band);

/// Rows and columns exchanged: many zones fit below each other, not side by side.
/// Shape: every column of the table has the unit and decimals of the first.
ReportTable turned(const ReportTable& table, const std::string& row_header);

}  // namespace airside::tools
