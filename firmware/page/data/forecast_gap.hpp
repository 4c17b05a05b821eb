#pragma once
// How far the controller's forecasts were from the measured rooms, by day, as far as the log says.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "firmware/page/data/trend_store.hpp"
#include "hal/site/site_file.hpp"

namespace airside::page {

/// Of the newest 14 days of the log, working hours alone: error = measured at the end of a cycle - forecast at its
/// begin. The log has the forecast of the held value. A room is expected to move as the held value does:
/// e_room = (room(t + cycle) - room(t)) - (forecast(t) - held(t)).
/// Lists have the held value first, then each room. {cycle_min, days: [{date, n, bias_k, rms_k}], n, bias_k, rms_k,
/// recent_days, before_days, recent_rms_k, before_rms_k, grows, enough, reference_days}. `grows`: in the newest 3 days
/// with at least 10 forecasts the root mean square is above 1.5 times that of the days before, and by more than 0.05 K;
/// `enough`: there are 4 such days before them. `reference_days`: of the log's first days, those that can be taken for
/// good: 2 to 7. A cycle with another setpoint within, a missing row, or a number that is not known is left out. Units:
/// K. Cost: linear in rows and rooms.
nlohmann::json forecast_gap(const TrendStore& store);

/// The commands that find out why forecasts have become worse, on a computer with the host tools and copies of site
/// file, point map and log folder in its working folder.
class GapHint {
 public:
  explicit GapHint(const hal::SiteFile& site);
  /// To be typed in a POSIX shell one after the other. A site without [twin] has a room fitted to its log first; where
  /// no weather is named, STATION.epw stands for it.
  std::vector<std::string> commands(int reference_days) const;

 private:
  std::string files_;    ///< the options with the site file and the log folder, by their last names
  std::string weather_;  ///< the option with the weather, "" where the site names it
  bool has_twin_ = false;
};

}  // namespace airside::page
