#pragma once
// Where and when a model is wrong: by channel, hour of day, day and weather; and the usual figures beside them.

#include <string>
#include <vector>

#include "tools/gap/model/responses.hpp"

namespace airside::tools::gap {

/// Errors of a stretch, one entry a channel.  Units: of the channel.  NaN: nothing measured.
struct ChannelErrors {
  Eigen::VectorXd rmse, mean;
};

/// Bins from `first` to before `last`.  Shape: residual: bins x channels.
ChannelErrors errors_of(const Eigen::MatrixXd& residual, Eigen::Index first, Eigen::Index last);

/// RMSE over several channels, each counted alike; 0 for none.
double joint_rmse(const ChannelErrors& errors, int first_channel, int last_channel);

/// Errors of every channel in each of several groups of bins.  Shape: channels x groups.
struct ErrorMap {
  std::vector<std::string> groups;
  Eigen::MatrixXd rmse, mean;
};

/// `first`: bins before are left out, since the model does not know how the room began.
ErrorMap errors_by_hour(const Eigen::MatrixXd& residual, Eigen::Index first);
/// All days; groups are named "07-15".
ErrorMap errors_by_day(const Eigen::MatrixXd& residual, const sim::Recording& recording);
/// Night, dull and sunny hours; cool, mild and warm ones (thirds of the measured outdoor temperatures); rain.
/// Groups without a bin are left out.
ErrorMap errors_by_weather(const Eigen::MatrixXd& residual, const sim::Recording& recording, Eigen::Index first);

/// The figures by which models of buildings are usually accepted, of hourly means or of monthly energies.
///   CV(RMSE) = sqrt(sum e^2 / (n - 1)) / mean(measured),  NMBE = sum e / (n - 1) / mean(measured)
/// Source: ASHRAE Guideline 14-2014; hourly limits: 30 % and 10 %, monthly ones 15 % and 5 %.
struct Guideline14 {
  static constexpr double cv_rmse_limit_percent = 30, nmbe_limit_percent = 10;
  static constexpr double monthly_cv_rmse_limit_percent = 15, monthly_nmbe_limit_percent = 5;
  double cv_rmse_percent = 0, nmbe_percent = 0;
  int count = 0;  ///< hours or months
  bool passes() const;
  bool passes_monthly() const;
};

/// Room temperatures of all rooms, each hour of each room one value.
Guideline14 guideline_14_room_temp(const Eigen::MatrixXd& measured, const Eigen::MatrixXd& residual,
                                   const sim::Channels& channels, Eigen::Index first, Eigen::Index last);
/// The sum of all powers.
Guideline14 guideline_14_power(const Eigen::MatrixXd& measured, const Eigen::MatrixXd& residual,
                               const sim::Channels& channels, Eigen::Index first, Eigen::Index last);

/// One meter, hour by hour and month by month. A month counts from 20 days with measured hours on; months need two.
struct MeterFigures {
  static constexpr int least_days = 20;
  Guideline14 hourly, monthly;
};
/// Of the power channel `c`.
MeterFigures guideline_14_meter(const Eigen::MatrixXd& measured, const Eigen::MatrixXd& residual,
                                const sim::Recording& recording, int c, Eigen::Index first, Eigen::Index last);

}  // namespace airside::tools::gap
