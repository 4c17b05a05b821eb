#include "tools/gap/explain/day_stretch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/gap/model/residual.hpp"

namespace airside::tools::gap {

namespace {

constexpr double hours_per_bin = 24.0 / bins_per_day;

std::string clock_of(double hour) {
  const int minutes = static_cast<int>(std::lround(60 * hour)) % 1440;
  return minutes % 60 == 0 ? fmt::format("{}", minutes / 60) : fmt::format("{}:{:02}", minutes / 60, minutes % 60);
}

}  // namespace

Eigen::VectorXd mean_day(const Eigen::VectorXd& x, Eigen::Index first) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(bins_per_day), count = sum;
  for (Eigen::Index t = first; t < x.size(); ++t) {
    if (!std::isfinite(x(t))) continue;
    sum(t % bins_per_day) += x(t);
    count(t % bins_per_day) += 1;
  }
  return sum.cwiseQuotient(count.cwiseMax(1));
}

bool DayStretch::holds(Eigen::Index bin_of_day) const {
  return (bin_of_day - from + bins_per_day) % bins_per_day < length;
}

bool DayStretch::is_whole_day() const { return length == bins_per_day; }

double DayStretch::from_h() const { return hours_per_bin * static_cast<double>(from); }

double DayStretch::to_h() const {
  return is_whole_day() ? 24 : std::fmod(from_h() + hours_per_bin * static_cast<double>(length), 24.0);
}

std::string DayStretch::text() const {
  if (is_whole_day()) return "day and night";
  return fmt::format("between {} and {} h", clock_of(from_h()), clock_of(to_h()));
}

DayStretch active_stretch(const Eigen::VectorXd& day) {
  Eigen::Index peak = 0;
  day.cwiseAbs().maxCoeff(&peak);
  DayStretch stretch;
  stretch.peak = day(peak);
  const double sign = stretch.peak < 0 ? -1 : 1, half = sign * stretch.peak / 2;
  const auto above = [&](Eigen::Index bin) {
    return sign * day((bin % bins_per_day + bins_per_day) % bins_per_day) > half;
  };
  Eigen::Index from = peak, to = peak + 1;
  while (to - from < bins_per_day && above(from - 1)) --from;
  while (to - from < bins_per_day && above(to)) ++to;
  stretch.from = (from % bins_per_day + bins_per_day) % bins_per_day;
  stretch.length = to - from;
  if (stretch.length >= bins_per_day - 4) {
    stretch.from = 0;
    stretch.length = bins_per_day;
  }
  return stretch;
}

double sd_of_days(const Eigen::VectorXd& x, const sim::Recording& recording, Eigen::Index from, Eigen::Index length) {
  std::array<double, 2> count{}, sum{}, squares{};
  for (Eigen::Index d = 1; d * bins_per_day + from + length <= x.size(); ++d) {
    const double mean = x.segment(d * bins_per_day + from, length).mean();
    if (!std::isfinite(mean)) continue;
    const std::size_t kind = recording.time(static_cast<std::size_t>(d) * rows_per_day).weekday() >= 5 ? 1 : 0;
    count[kind] += 1;
    sum[kind] += mean;
    squares[kind] += mean * mean;
  }
  double scatter = 0, freedom = 0;
  for (std::size_t kind = 0; kind < 2; ++kind) {
    if (count[kind] < 2) continue;
    scatter += std::max(0.0, squares[kind] - sum[kind] * sum[kind] / count[kind]);
    freedom += count[kind] - 1;
  }
  return freedom > 0 ? std::sqrt(scatter / freedom / (count[0] + count[1])) : 0;
}

}  // namespace airside::tools::gap
