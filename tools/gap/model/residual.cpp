#include "tools/gap/model/residual.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace airside::tools::gap {

namespace {

std::size_t block_of(Eigen::Index bin) {
  constexpr Eigen::Index bins_per_block = bins_per_day / 12;
  return static_cast<std::size_t>(bin % bins_per_day / bins_per_block);
}

/// Smallest believable innovation: rounding to two decimals and the mean of five samples.
double floor_of(const sim::Channels& channels, int column) {
  if (!channels.grain.empty() && channels.grain[static_cast<std::size_t>(column)].floor > 0)
    return channels.grain[static_cast<std::size_t>(column)].floor;
  const bool power = column >= channels.power() && column < channels.fcu_duty();
  const bool duty = column >= channels.fcu_duty();
  if (column == channels.supply_temp()) return 0.05;
  return duty ? 0.05 : power ? 0.02 : 0.006;
}

double mean_of(const Eigen::VectorXd& x) {
  double sum = 0;
  int count = 0;
  for (const double value : x) {
    if (!std::isfinite(value)) continue;
    sum += value;
    ++count;
  }
  return sum / std::max(1, count);
}

double root_mean_square(const Eigen::VectorXd& x) {
  double square = 0;
  int count = 0;
  for (const double value : x) {
    if (!std::isfinite(value)) continue;
    square += value * value;
    ++count;
  }
  return std::sqrt(square / std::max(1, count));
}

/// Bins of a channel's value.
std::vector<Eigen::Index> steps_of(const sim::Channels& channels, Eigen::Index duty_bins) {
  constexpr int bin_min = 24 * 60 / bins_per_day;
  std::vector<Eigen::Index> steps(static_cast<std::size_t>(channels.count()), 1);
  std::fill(steps.begin() + channels.fcu_duty(), steps.end(), duty_bins);
  for (std::size_t c = 0; c < channels.grain.size(); ++c)
    if (channels.grain[c].step_min > bin_min) steps[c] = channels.grain[c].step_min / bin_min;
  return steps;
}

/// Rows that an instant of a channel stands for.
Eigen::Index rows_held(const sim::Channels& channels, Eigen::Index column) {
  if (channels.grain.empty()) return 1;
  const sim::ChannelGrain& grain = channels.grain[static_cast<std::size_t>(column)];
  return grain.instants ? std::max<Eigen::Index>(1, grain.step_min * 60LL / row_s) : 1;
}

/// A row shows the 6 min that end at its time, so a mean over an hour begins one row after the hour.
Eigen::Index rows_late(const sim::Channels& channels, Eigen::Index column) {
  if (channels.grain.empty()) return 0;
  const sim::ChannelGrain& grain = channels.grain[static_cast<std::size_t>(column)];
  return grain.step_min > 0 && !grain.instants ? 1 : 0;
}

/// NaN where nothing was measured.
Eigen::MatrixXd known(const Eigen::MatrixXd& x, const Eigen::MatrixXd& measured) {
  return (measured.array().isFinite()).select(x, std::numeric_limits<double>::quiet_NaN());
}

/// Of innovations, shrunk towards none: few days, many channels.
Eigen::MatrixXd innovation_correlation(const Eigen::MatrixXd& innovation, const std::vector<Eigen::Index>& steps) {
  const Eigen::Index n = innovation.rows(), width = innovation.cols();
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(width, width);
  for (Eigen::Index i = 0; i < width; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      // Means of several bins are rare; what the other channels say at other times must not be counted twice.
      if (steps[static_cast<std::size_t>(i)] != steps[static_cast<std::size_t>(j)]) continue;
      double sum = 0;
      int count = 0;
      for (Eigen::Index t = NoiseModel::order; t < n; ++t) {
        const double product = innovation(t, i) * innovation(t, j);
        if (!std::isfinite(product)) continue;
        sum += product;
        ++count;
      }
      if (count > 0) correlation(i, j) = correlation(j, i) = std::clamp(0.8 * sum / count, -0.9, 0.9);
    }
  }
  return correlation;
}

}  // namespace

Eigen::MatrixXd binned(const sim::ChannelTable& table, const sim::Channels& channels) {
  const Eigen::Index bins = table.rows() / rows_per_bin;
  Eigen::MatrixXd out = Eigen::MatrixXd::Constant(bins, table.cols(), std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index c = 0; c < table.cols(); ++c) {
    const Eigen::Index held = rows_held(channels, c), late = rows_late(channels, c);
    for (Eigen::Index b = 0; b < bins; ++b) {
      double sum = 0;
      int count = 0;
      const Eigen::Index first = b * rows_per_bin + late;
      for (Eigen::Index r = first; r < std::min(first + rows_per_bin, table.rows()); ++r) {
        const double x = table(r - r % held, c);
        if (!std::isfinite(x)) continue;
        sum += x;
        ++count;
      }
      if (count >= 3) out(b, c) = sum / count;
    }
  }
  return out;
}

NoiseModel NoiseModel::fit(const Eigen::MatrixXd& all, const sim::Channels& channels) {
  const Eigen::Index n = all.rows(), width = all.cols();
  NoiseModel model;
  model.steps_ = steps_of(channels, duty_bins);
  model.phi_ = Eigen::MatrixXd::Zero(width, order);
  model.spread_ = Eigen::VectorXd::Zero(width);
  const Eigen::MatrixXd residual = model.comparable(all);
  Eigen::MatrixXd innovation = Eigen::MatrixXd::Constant(n, width, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index c = 0; c < width; ++c) {
    // About its mean: an error that stays is not noise that happens to be slow, and a fit must not be free to leave it.
    const Eigen::VectorXd x = residual.col(c).array() - mean_of(residual.col(c));
    const Eigen::Index step = model.step_of(c);
    Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    int count = 0;
    const auto whole = [&x, step](Eigen::Index t) {
      return std::isfinite(x(t)) && std::isfinite(x(t - step)) && std::isfinite(x(t - 2 * step));
    };
    for (Eigen::Index t = order * step; t < n; ++t) {
      if (!whole(t)) continue;
      const Eigen::Vector2d past(x(t - step), x(t - 2 * step));
      a += past * past.transpose();
      b += past * x(t);
      ++count;
    }
    const double lowest = floor_of(channels, static_cast<int>(c));
    model.spread_(c) = std::max(lowest, root_mean_square(all.col(c)));
    if (count < 20) {
      if (step > duty_bins) innovation.col(c) = x;  // means of many hours: too few for a memory
      continue;
    }
    // A little ridge: a channel without noise must not get a pole at one.
    const double ridge = count * lowest * lowest;
    Eigen::Vector2d phi = (a + ridge * Eigen::Matrix2d::Identity()).ldlt().solve(b);
    phi *= std::min(1.0, std::exp(-static_cast<double>(step) / memory_bins) / std::max(1e-9, phi.sum()));
    model.phi_.row(c) = phi.transpose();
    for (Eigen::Index t = order * step; t < n; ++t) {
      if (whole(t)) innovation(t, c) = x(t) - phi(0) * x(t - step) - phi(1) * x(t - 2 * step);
    }
  }
  model.scale_ = Eigen::MatrixXd::Ones(width, blocks);
  for (Eigen::Index c = 0; c < width; ++c) {
    std::array<double, blocks> square{}, count{};
    double all_square = 0, all_count = 0;
    for (Eigen::Index t = order; t < n; ++t) {
      const double e = innovation(t, c);
      if (!std::isfinite(e)) continue;
      square[block_of(t)] += e * e;
      count[block_of(t)] += 1;
      all_square += e * e;
      all_count += 1;
    }
    const double lowest = floor_of(channels, static_cast<int>(c));
    const double whole_day = all_count > 0 ? all_square / all_count : 0;
    constexpr double prior_count = 12;  // a block of few samples leans on the whole day
    for (std::size_t b = 0; b < blocks; ++b) {
      const double variance = (square[b] + prior_count * whole_day) / (count[b] + prior_count);
      model.scale_(c, static_cast<Eigen::Index>(b)) = std::sqrt(variance + lowest * lowest);
    }
    for (Eigen::Index t = order; t < n; ++t)
      innovation(t, c) /= model.scale_(c, static_cast<Eigen::Index>(block_of(t)));
  }
  Eigen::MatrixXd correlation = innovation_correlation(innovation, model.steps_);
  correlation.diagonal().array() += 0.02;
  Eigen::LLT<Eigen::MatrixXd> factor(correlation);
  if (factor.info() != Eigen::Success) factor.compute(Eigen::MatrixXd::Identity(width, width));
  const Eigen::MatrixXd lower = factor.matrixL();
  model.unit_ = lower.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(width, width));
  return model;
}

Eigen::MatrixXd NoiseModel::comparable(Eigen::MatrixXd x) const {
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    const Eigen::Index step = step_of(c);
    if (step == 1) continue;
    const Eigen::VectorXd bins = x.col(c);
    x.col(c).setConstant(std::numeric_limits<double>::quiet_NaN());
    for (Eigen::Index end = step; end <= x.rows(); end += step) {
      double sum = 0;
      int count = 0;
      for (Eigen::Index t = end - step; t < end; ++t) {
        if (!std::isfinite(bins(t))) continue;
        sum += bins(t);
        ++count;
      }
      if (count > step / 2) x(end - 1, c) = sum / count;
    }
  }
  return x;
}

Eigen::VectorXd NoiseModel::whiten(const Eigen::MatrixXd& all, const std::vector<bool>& kept,
                                   const Eigen::MatrixXd& missing) const {
  const Eigen::Index n = all.rows(), width = all.cols();
  const Eigen::MatrixXd x = comparable(known(all, missing));
  Eigen::MatrixXd e = Eigen::MatrixXd::Zero(width, std::max<Eigen::Index>(0, n - order));
  for (Eigen::Index c = 0; c < width; ++c) {
    const Eigen::Index step = step_of(c);
    // A mean of several bins reaches back to the first of them.
    const Eigen::Index reach = (order + 1) * step - 1;
    for (Eigen::Index t = reach; t < n; ++t) {
      if (!kept[static_cast<std::size_t>(t)] || !kept[static_cast<std::size_t>(t - reach)]) continue;
      const double value = x(t, c) - phi_(c, 0) * x(t - step, c) - phi_(c, 1) * x(t - 2 * step, c);
      if (std::isfinite(value)) e(c, t - order) = value / scale_(c, static_cast<Eigen::Index>(block_of(t)));
    }
  }
  const Eigen::MatrixXd unit = unit_ * e;
  return Eigen::Map<const Eigen::VectorXd>(unit.data(), unit.size());
}

}  // namespace airside::tools::gap
