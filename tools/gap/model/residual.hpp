#pragma once
// Residuals as a stack of channels: half-hour means, a noise model that whitens them, and vectors in which a distance
// is a likelihood.

#include <Eigen/Dense>
#include <vector>

#include "sim/weather/recording.hpp"

namespace airside::tools::gap {

constexpr int rows_per_bin = 5;  ///< 30 min
constexpr int bins_per_day = rows_per_day / rows_per_bin;

/// Means of successive bins. A channel whose log has instants more than half an hour apart holds each until the next:
/// what lies between them was not measured. Of one with means over hours a bin is the half hour itself, the row at its
/// end included.
/// Shape: bins x channels. Row 0 is a midnight.  NaN where fewer than three rows of a bin are numbers.
Eigen::MatrixXd binned(const sim::ChannelTable& table, const sim::Channels& channels);

/// How the residual of a right model behaves, channel by channel: x_t = sum_i phi_i x_{t-i} + e_t, with innovations e
/// that are correlated across channels and larger at the hours at which people come, go and move.
/// A thermostat's duty is compared in means of 3 h: when within them a fan coil ran is a matter of chance, and a sum of
/// squares of chance differs by more from one run to the next than effects gain. So is a channel whose log has values
/// more than half an hour apart: it is compared as it was measured.
/// Source: docs/gap-workflow.md, "3. Reference period".
class NoiseModel {
 public:
  static constexpr int order = 2;

  /// Fitted to the residual of a right model.  Shape: bins x channels; NaN: missing.
  /// A channel that never varies gets the sensor's own resolution.
  static NoiseModel fit(const Eigen::MatrixXd& residual, const sim::Channels& channels);

  /// Whitened rows, stacked: the innovations of t = order .., each time step rotated to unit covariance; 0 where a
  /// value is missing. `kept[t]` false leaves a bin out. Row 0 is a midnight. Shape: (bins - order) * channels.
  Eigen::VectorXd whiten(const Eigen::MatrixXd& x, const std::vector<bool>& kept, const Eigen::MatrixXd& missing) const;

  /// Standard deviation of a residual in each channel (not of its innovations).  K, kW, -.
  const Eigen::VectorXd& spread() const { return spread_; }

 private:
  static constexpr int blocks = 12;          ///< of the day
  static constexpr int duty_bins = 6;        ///< a duty's mean
  static constexpr double memory_bins = 24;  ///< longest: a room forgets within half a day

  Eigen::Index step_of(Eigen::Index channel) const { return steps_[static_cast<std::size_t>(channel)]; }
  /// Channels of several bins as means, each in the last of its bins, NaN in the others.
  Eigen::MatrixXd comparable(Eigen::MatrixXd x) const;

  Eigen::MatrixXd phi_;              // channels x order
  Eigen::MatrixXd scale_;            // channels x blocks, sd of the innovations
  std::vector<Eigen::Index> steps_;  // channel; bins of a value
  Eigen::MatrixXd unit_;             // inverse Cholesky factor of the scaled innovations' correlation
  Eigen::VectorXd spread_;
};

}  // namespace airside::tools::gap
