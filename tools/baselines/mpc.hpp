#pragma once
// Model predictive control on a grey-box model of the room: what a modern engineer builds with days of logged data.

#include <Eigen/Core>
#include <optional>

#include "tools/baselines/arx.hpp"
#include "tools/baselines/baseline.hpp"

namespace airside::tools {

struct MpcSettings {
  int horizon = 10;                ///< cycles, 3 h of 18 min
  double move_weight = 0.1;        ///< of a squared setpoint move against a squared error
  double disturbance_share = 0.5;  ///< of an innovation that is taken for a lasting disturbance, (0, 1]
  double noise_sd_k = 0.06;        ///< of the identification
};

/// Minimises a strictly convex quadratic on a box by projected coordinate descent.
///   min 1/2 x' H x + f' x,  low <= x <= high
/// Shape: H n x n, symmetric, positive definite; f, x: n. `x`: start in, solution out.
void solve_box_quadratic(const Eigen::MatrixXd& h, const Eigen::VectorXd& f, double low, double high,
                         Eigen::VectorXd& x);

/// Air and mass of the room as an ARX model of second order in the mean s, fitted once by least squares (Gaussian
/// prior) to the schedule days' 6-min rows, and never again:
///   s_{t+1} = a1 s_t + a2 s_{t-1} + b1 u_t + b2 u_{t-1} + c o_t + g'phi(time of day) + d_t
/// s and u as deviations from target and mid-range, o outdoor temperature from the history's mean (held over the
/// horizon, since nobody has a forecast), phi four harmonics of the day and a constant for the gains, d the disturbance
/// that makes it free of offset: d_{t+1} = d_t + l (s_{t+1} - predicted). Each cycle the setpoints of N cycles are
/// found and the first is held:
///   min sum_k (s_{t+k})^2 + w (u_{t+k-1} - u_{t+k-2})^2,  u in the site's action range
/// Guarded: where the fit says that the room runs away, or answers a lasting kelvin by less than 0.2 or more than 2 K,
/// a's and b's stay at their prior and the rest is fitted. Schedules whose setpoint follows the clock can do that.
/// Source: docs/results.md, "Peers".
class MpcBaseline final : public BaselineController {
 public:
  MpcBaseline(const ControllerSettings& site, const MpcSettings& settings);
  std::string name() const override { return "MPC, grey box"; }
  void observe_history(std::span<const HistoryRow> rows) override;
  bool heeds_history() const override { return true; }
  double decide(const CycleObservation& now) override;

  /// [a1, a2, b1, b2, c, constant, cos and sin of each harmonic]
  const Eigen::VectorXd& parameters() const { return model_.parameters(); }
  /// Of the mean to a lasting change of the setpoint, K/K.
  double steady_gain() const;

 private:
  struct State {
    CivilTime time;
    double s_k, before_s_k;  ///< deviations of the mean now and a cycle before
    double u_k, before_u_k;  ///< setpoint over the coming cycle and over the last one
    double outdoor_k;
  };
  Eigen::VectorXd regressors(const State& state) const;
  void identify(std::span<const HistoryRow> rows);
  bool is_plausible() const;
  double outdoor_k(const sim::Sensors& sensors) const;  ///< from the history's mean; 0 where there is no reading

  ControllerSettings site_;
  MpcSettings settings_;
  double middle_degc_;
  double outdoor_mean_degc_ = 25;
  RecursiveLeastSquares model_;
  std::optional<State> last_;
  double disturbance_k_ = 0;
};

}  // namespace airside::tools
