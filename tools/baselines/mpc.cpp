#include "tools/baselines/mpc.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace airside::tools {
namespace {

constexpr int mpc_harmonics = 4;
/// Places in the parameters, in a struct for short names that reach no other file.
struct At {
  enum : Eigen::Index { a1, a2, b1, b2, outdoor, constant, first_harmonic, count = first_harmonic + 2 * mpc_harmonics };
};

/// A first-order room that goes 65 % of its way in a cycle; the data moves it from there.
Eigen::VectorXd mpc_prior_mean() {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(At::count);
  mean[At::a1] = 0.4;
  mean[At::b1] = 0.6;
  return mean;
}
/// `moves`: of how the room answers, which a guarded fit leaves as it is.
Eigen::VectorXd mpc_prior_sd(double moves = 1) {
  Eigen::VectorXd sd = Eigen::VectorXd::Constant(At::count, 0.3);
  sd[At::a1] = sd[At::b1] = 0.3 * moves;
  sd[At::a2] = sd[At::b2] = 0.2 * moves;
  sd[At::outdoor] = 0.1;
  sd[At::constant] = 2;
  return sd;
}

}  // namespace

void solve_box_quadratic(const Eigen::MatrixXd& h, const Eigen::VectorXd& f, double low, double high,
                         Eigen::VectorXd& x) {
  constexpr int most_sweeps = 2000;
  constexpr double close_enough = 1e-9;
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double moved = 0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double to = std::clamp(x[i] - (h.row(i).dot(x) + f[i]) / h(i, i), low, high);
      moved = std::max(moved, std::abs(to - x[i]));
      x[i] = to;
    }
    if (moved < close_enough) return;
  }
}

MpcBaseline::MpcBaseline(const ControllerSettings& site, const MpcSettings& settings)
    : site_(site),
      settings_(settings),
      middle_degc_(0.5 * (site.action_min_degc + site.action_max_degc)),
      model_(mpc_prior_mean(), mpc_prior_sd()) {}

double MpcBaseline::steady_gain() const {
  const Eigen::VectorXd& p = model_.parameters();
  return (p[At::b1] + p[At::b2]) / (1 - p[At::a1] - p[At::a2]);
}

bool MpcBaseline::is_plausible() const {
  const double carried = model_.parameters()[At::a1] + model_.parameters()[At::a2], gain = steady_gain();
  return carried >= 0 && carried < 1 && gain >= 0.2 && gain <= 2;
}

Eigen::VectorXd MpcBaseline::regressors(const State& state) const {
  Eigen::VectorXd h(At::count);
  h[At::a1] = state.s_k;
  h[At::a2] = state.before_s_k;
  h[At::b1] = state.u_k;
  h[At::b2] = state.before_u_k;
  h[At::outdoor] = state.outdoor_k;
  h[At::constant] = 1;
  const double angle = 2 * std::numbers::pi * state.time.second_of_day() / 86400.0;
  for (int n = 0; n < mpc_harmonics; ++n) {
    h[At::first_harmonic + 2 * n] = std::cos((n + 1) * angle);
    h[At::first_harmonic + 2 * n + 1] = std::sin((n + 1) * angle);
  }
  return h;
}

double MpcBaseline::outdoor_k(const sim::Sensors& sensors) const {
  return std::isfinite(sensors.outdoor_temp_degc) ? sensors.outdoor_temp_degc - outdoor_mean_degc_ : 0;
}

void MpcBaseline::observe_history(std::span<const HistoryRow> rows) {
  double sum = 0;
  int finite = 0;
  for (const HistoryRow& row : rows) {
    if (std::isfinite(row.sensors.outdoor_temp_degc)) sum += row.sensors.outdoor_temp_degc, ++finite;
  }
  if (finite > 0) outdoor_mean_degc_ = sum / finite;
  identify(rows);
  if (is_plausible()) return;
  constexpr double held = 1e-4;
  model_ = RecursiveLeastSquares(mpc_prior_mean(), mpc_prior_sd(held));
  identify(rows);
}

void MpcBaseline::identify(std::span<const HistoryRow> rows) {
  const auto cycle = static_cast<std::size_t>(control_cycle(site_).rows);
  const int cycle_s = control_cycle(site_).seconds();
  const auto held = [&](std::size_t from) {
    for (std::size_t j = from + 1; j < from + cycle; ++j) {
      if (rows[j].setpoint_degc != rows[from].setpoint_degc) return false;
    }
    return rows[from + cycle].time.seconds - rows[from].time.seconds == cycle_s;
  };
  const auto mean_k = [&](std::size_t j) { return room_mean_degc(rows[j].sensors) - site_.target_degc; };
  // Neighbouring rows share all but one row of their cycle, so those of a cycle are worth one.
  const double noise_var = settings_.noise_sd_k * settings_.noise_sd_k * control_cycle(site_).rows;
  for (std::size_t j = cycle; j + cycle < rows.size(); ++j) {
    if (!held(j - cycle) || !held(j)) continue;
    if (!std::isfinite(mean_k(j - cycle) + mean_k(j) + mean_k(j + cycle))) continue;
    const State state{rows[j].time,
                      mean_k(j),
                      mean_k(j - cycle),
                      rows[j].setpoint_degc - middle_degc_,
                      rows[j - cycle].setpoint_degc - middle_degc_,
                      outdoor_k(rows[j].sensors)};
    model_.update(regressors(state), mean_k(j + cycle), noise_var, 1.0, std::numeric_limits<double>::infinity());
  }
}

double MpcBaseline::decide(const CycleObservation& now) {
  const double s_k = room_mean_degc(now.sensors) - now.target_degc;
  const double u_k = now.previous_setpoint_degc - middle_degc_;
  if (!std::isfinite(s_k)) {
    last_.reset();
    return admissible_setpoint_degc(now.previous_setpoint_degc, site_);
  }
  const Eigen::VectorXd& p = model_.parameters();
  const int cycle_s = control_cycle(site_).seconds();
  const bool follows = last_ && now.time.seconds - last_->time.seconds == cycle_s;
  if (follows) {
    last_->u_k = u_k;  // what the AHU took
    disturbance_k_ += settings_.disturbance_share * (s_k - regressors(*last_).dot(p) - disturbance_k_);
  }
  State state{now.time, s_k, follows ? last_->s_k : s_k, 0, u_k, outdoor_k(now.sensors)};
  last_ = state;

  // Response of the horizon to nothing but the past (u = 0), and to a unit of each setpoint.
  const Eigen::Index n = settings_.horizon;
  Eigen::VectorXd free(n), impulse(n);
  State walk = state;
  for (Eigen::Index k = 0; k < n; ++k) {
    free[k] = regressors(walk).dot(p) + disturbance_k_;
    walk = {{walk.time.seconds + cycle_s}, free[k], walk.s_k, 0, 0, walk.outdoor_k};
    impulse[k] = (k > 0 ? p[At::a1] * impulse[k - 1] : p[At::b1]) + (k > 1 ? p[At::a2] * impulse[k - 2] : 0) +
                 (k == 1 ? p[At::b2] : 0);
  }
  Eigen::MatrixXd response = Eigen::MatrixXd::Zero(n, n), moves = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    response.col(k).tail(n - k) = impulse.head(n - k);
    if (k > 0) moves(k, k - 1) = -1;
  }
  Eigen::VectorXd start = Eigen::VectorXd::Zero(n);
  start[0] = u_k;
  const double w = settings_.move_weight;
  const Eigen::MatrixXd h =
      response.transpose() * response + w * moves.transpose() * moves + 1e-6 * Eigen::MatrixXd::Identity(n, n);
  const Eigen::VectorXd f = response.transpose() * free - w * moves.transpose() * start;
  Eigen::VectorXd u = Eigen::VectorXd::Constant(n, u_k);
  solve_box_quadratic(h, f, site_.action_min_degc - middle_degc_, site_.action_max_degc - middle_degc_, u);
  return admissible_setpoint_degc(middle_degc_ + u[0], site_);
}

}  // namespace airside::tools
