#pragma once
// A learned environment as tools/learn_environment writes it: the network, and the log whose last days it replays.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "hal/log/log_csv.hpp"

namespace airside::sim {

/// A fully connected network that gives the change of each room temperature within a row of 6 min.
struct LearnedNetwork {
  struct Layer {
    Eigen::MatrixXd weight;  ///< outputs x inputs
    Eigen::VectorXd bias;
  };
  std::vector<Layer> layers;
  double slope = 0.2;           ///< of LeakyReLU below zero, after every layer but the last
  Eigen::VectorXd mean, scale;  ///< of the inputs [S E A]: degC, 0/1, kW, degC
  Eigen::VectorXd out_scale_k;  ///< K a row for an output of 1

  /// Change of each room temperature until the next row, K.  Shape: inputs [S E A] in physical units.
  Eigen::VectorXd change_k(const Eigen::VectorXd& inputs) const;
};

struct LearnedEnvironment {
  LearnedNetwork network;
  std::vector<hal::LogRow> rows;  ///< the days that did not teach it, without gaps
  std::string description;        ///< for complaints and reports
};

/// The first replayed day, such as "2021-07-25".  Errors: as read_environment(), of that field alone.
std::string environment_start(const std::string& file);

/// Errors: hal::InputError naming file and field for what is not there, has another shape, or is no number; for a log
/// that cannot be read, lacks the days, or has a gap.
LearnedEnvironment read_environment(const std::string& file, const hal::TopologyCounts& counts);

}  // namespace airside::sim
