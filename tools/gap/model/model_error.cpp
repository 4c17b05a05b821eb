#include "tools/gap/model/model_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "hal/text/civil_text.hpp"

namespace airside::tools::gap {

namespace {

/// Mean and mean square of the finite values.
struct ErrorSum {
  double sum = 0, square = 0;
  int count = 0;
  void add(double x) {
    if (!std::isfinite(x)) return;
    sum += x;
    square += x * x;
    ++count;
  }
  double mean() const { return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN(); }
  double rmse() const { return count > 0 ? std::sqrt(square / count) : std::numeric_limits<double>::quiet_NaN(); }
};

/// `belongs(bin, group)`.
ErrorMap map_of(const Eigen::MatrixXd& residual, std::vector<std::string> groups, Eigen::Index first,
                const std::function<bool(Eigen::Index, std::size_t)>& belongs) {
  ErrorMap map;
  const Eigen::Index width = std::ssize(groups);
  map.rmse = map.mean = Eigen::MatrixXd::Zero(residual.cols(), width);
  for (Eigen::Index c = 0; c < residual.cols(); ++c) {
    for (Eigen::Index g = 0; g < width; ++g) {
      ErrorSum sum;
      for (Eigen::Index t = first; t < residual.rows(); ++t) {
        if (belongs(t, static_cast<std::size_t>(g))) sum.add(residual(t, c));
      }
      map.rmse(c, g) = sum.rmse();
      map.mean(c, g) = sum.mean();
    }
  }
  map.groups = std::move(groups);
  return map;
}

/// Two half hours; not known unless both are.
double hour_mean(double a, double b) { return (a + b) / 2; }

class Guideline14Sum {
 public:
  void add(double measured, double error) {
    if (!std::isfinite(measured) || !std::isfinite(error)) return;
    measured_ += measured;
    error_ += error;
    square_ += error * error;
    ++count_;
  }
  Guideline14 figures() const {
    Guideline14 g;
    g.count = count_;
    if (count_ < 2 || measured_ == 0) return g;
    const double mean = measured_ / count_, freedom = count_ - 1;
    g.cv_rmse_percent = 100 * std::sqrt(square_ / freedom) / mean;
    g.nmbe_percent = 100 * error_ / freedom / mean;
    return g;
  }

 private:
  double measured_ = 0, error_ = 0, square_ = 0;
  int count_ = 0;
};

}  // namespace

ChannelErrors errors_of(const Eigen::MatrixXd& residual, Eigen::Index first, Eigen::Index last) {
  ChannelErrors errors;
  errors.rmse = errors.mean = Eigen::VectorXd::Zero(residual.cols());
  for (Eigen::Index c = 0; c < residual.cols(); ++c) {
    ErrorSum sum;
    for (Eigen::Index t = first; t < last; ++t) sum.add(residual(t, c));
    errors.rmse(c) = sum.rmse();
    errors.mean(c) = sum.mean();
  }
  return errors;
}

double joint_rmse(const ChannelErrors& errors, int first_channel, int last_channel) {
  ErrorSum sum;
  for (int c = first_channel; c < last_channel; ++c) sum.add(errors.rmse(c));
  return sum.count > 0 ? sum.rmse() : 0;
}

ErrorMap errors_by_hour(const Eigen::MatrixXd& residual, Eigen::Index first) {
  std::vector<std::string> hours;
  for (int h = 0; h < 24; ++h) hours.push_back(fmt::format("{:02}", h));
  constexpr Eigen::Index bins_per_hour = bins_per_day / 24;
  return map_of(residual, std::move(hours), first, [](Eigen::Index t, std::size_t h) {
    return t % bins_per_day / bins_per_hour == static_cast<Eigen::Index>(h);
  });
}

ErrorMap errors_by_day(const Eigen::MatrixXd& residual, const sim::Recording& recording) {
  std::vector<std::string> days;
  for (Eigen::Index d = 0; d < residual.rows() / bins_per_day; ++d) {
    days.push_back(hal::civil_text(recording.time(static_cast<std::size_t>(d) * rows_per_day)).substr(5, 5));
  }
  return map_of(residual, std::move(days), 0,
                [](Eigen::Index t, std::size_t d) { return t / bins_per_day == static_cast<Eigen::Index>(d); });
}

ErrorMap errors_by_weather(const Eigen::MatrixXd& residual, const sim::Recording& recording, Eigen::Index first) {
  enum : std::size_t { night, dull, sunny, cool, mild, warm, rain, kinds };
  static const std::vector<std::string> names{"night", "dull", "sunny", "cool", "mild", "warm", "rain"};
  const auto bins = static_cast<std::size_t>(residual.rows());
  std::vector<std::vector<bool>> is(kinds, std::vector<bool>(bins, false));
  std::vector<double> outdoor(bins, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t b = 0; b < bins; ++b) {
    const std::size_t row = b * rows_per_bin + rows_per_bin / 2;
    if (row >= recording.rows.size()) continue;
    outdoor[b] = recording.rows[row].outdoor_temp_degc;
    is[rain][b] = recording.rows[row].rain > 0.5;
    const sim::WeatherRecord w = recording.station->at(recording.time(row));
    is[night][b] = w.global_horizontal_w_m2 < 10;
    // Clear skies send most of their light straight.
    is[sunny][b] = !is[night][b] && w.direct_normal_w_m2 > 300;
    is[dull][b] = !is[night][b] && !is[sunny][b];
  }
  std::vector<double> sorted;
  std::copy_if(outdoor.begin(), outdoor.end(), std::back_inserter(sorted), [](double x) { return std::isfinite(x); });
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t b = 0; b < bins && !sorted.empty(); ++b) {
    is[cool][b] = outdoor[b] < sorted[sorted.size() / 3];
    is[warm][b] = outdoor[b] >= sorted[2 * sorted.size() / 3];
    is[mild][b] = std::isfinite(outdoor[b]) && !is[cool][b] && !is[warm][b];
  }
  std::vector<std::string> present;
  std::vector<std::size_t> kind_of;
  for (std::size_t k = 0; k < kinds; ++k) {
    if (std::find(is[k].begin() + first, is[k].end(), true) == is[k].end()) continue;
    present.push_back(names[k]);
    kind_of.push_back(k);
  }
  return map_of(residual, std::move(present), first,
                [&](Eigen::Index t, std::size_t g) { return is[kind_of[g]][static_cast<std::size_t>(t)]; });
}

bool Guideline14::passes() const {
  return count > 1 && cv_rmse_percent <= cv_rmse_limit_percent && std::abs(nmbe_percent) <= nmbe_limit_percent;
}

bool Guideline14::passes_monthly() const {
  return count > 1 && cv_rmse_percent <= monthly_cv_rmse_limit_percent &&
         std::abs(nmbe_percent) <= monthly_nmbe_limit_percent;
}

Guideline14 guideline_14_room_temp(const Eigen::MatrixXd& measured, const Eigen::MatrixXd& residual,
                                   const sim::Channels& channels, Eigen::Index first, Eigen::Index last) {
  Guideline14Sum sum;
  for (Eigen::Index c = 0; c < channels.rooms; ++c) {
    for (Eigen::Index t = first; t + 1 < last; t += 2) {
      sum.add(hour_mean(measured(t, c), measured(t + 1, c)), hour_mean(residual(t, c), residual(t + 1, c)));
    }
  }
  return sum.figures();
}

Guideline14 guideline_14_power(const Eigen::MatrixXd& measured, const Eigen::MatrixXd& residual,
                               const sim::Channels& channels, Eigen::Index first, Eigen::Index last) {
  Guideline14Sum sum;
  for (Eigen::Index t = first; t + 1 < last; t += 2) {
    double kw = 0, error = 0;
    for (Eigen::Index c = channels.power(); c < channels.fcu_duty(); ++c) {
      kw += hour_mean(measured(t, c), measured(t + 1, c));
      error += hour_mean(residual(t, c), residual(t + 1, c));
    }
    sum.add(kw, error);
  }
  return sum.figures();
}

MeterFigures guideline_14_meter(const Eigen::MatrixXd& measured, const Eigen::MatrixXd& residual,
                                const sim::Recording& recording, int c, Eigen::Index first, Eigen::Index last) {
  struct Month {
    double kwh = 0, error_kwh = 0;
    int hours = 0;
  };
  Guideline14Sum hourly, monthly;
  std::map<std::string, Month> months;
  for (Eigen::Index t = first; t + 1 < last; t += 2) {
    const double kw = hour_mean(measured(t, c), measured(t + 1, c));
    const double error = hour_mean(residual(t, c), residual(t + 1, c));
    hourly.add(kw, error);
    if (!std::isfinite(kw) || !std::isfinite(error)) continue;
    Month& month = months[hal::civil_text(recording.time(static_cast<std::size_t>(t) * rows_per_bin)).substr(0, 7)];
    month.kwh += kw;
    month.error_kwh += error;
    ++month.hours;
  }
  for (const auto& [name, month] : months) {
    if (month.hours >= 24 * MeterFigures::least_days) monthly.add(month.kwh, month.error_kwh);
  }
  return {hourly.figures(), monthly.figures()};
}

}  // namespace airside::tools::gap
