#pragma once
// The part of the day in which something happens, of a series of half-hour means.

#include <Eigen/Core>
#include <string>

#include "sim/weather/recording.hpp"

namespace airside::tools::gap {

/// Mean of each bin of the day, from bin `first` on; what is not finite does not count.  Shape: bins_per_day.
Eigen::VectorXd mean_day(const Eigen::VectorXd& x, Eigen::Index first);

/// The stretch about the peak of a mean day in which it stays above half of it. It may go over midnight; from 22 h on
/// it is the whole day.
struct DayStretch {
  Eigen::Index from = 0, length = 0;  ///< bins of the day
  double peak = 0;

  bool holds(Eigen::Index bin_of_day) const;
  bool is_whole_day() const;
  /// Hours of the clock; 0 and 24 of a whole day.
  double from_h() const;
  double to_h() const;
  /// "between 8 and 18 h", "day and night".
  std::string text() const;
};
DayStretch active_stretch(const Eigen::VectorXd& day);

/// Standard deviation of the mean over days, from how these scatter about working days' and weekends' own mean; 0
/// where no two are alike. The first day does not count; a stretch over midnight belongs to the day on which it begins.
double sd_of_days(const Eigen::VectorXd& x, const sim::Recording& recording, Eigen::Index from, Eigen::Index length);

}  // namespace airside::tools::gap
