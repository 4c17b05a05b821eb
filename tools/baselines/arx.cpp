#include "tools/baselines/arx.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace airside::tools {
namespace {

constexpr int own_parameters = 2;
constexpr int gain_index = 1;

int parameter_count(const ArxSettings& s) { return own_parameters + (s.exogenous ? ArxBaseline::exogenous_count : 0); }

Eigen::VectorXd prior_mean(const ArxSettings& s) {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(parameter_count(s));
  mean[gain_index] = s.gain_prior;
  return mean;
}

Eigen::VectorXd prior_sd(const ArxSettings& s) {
  Eigen::VectorXd sd(parameter_count(s));
  sd.head<own_parameters>() << 0.5, s.gain_prior_sd;
  // K per K of FCU temperature, per kW, per K of MAU outlet, per FCU, per VAV.
  if (s.exogenous) sd.tail<ArxBaseline::exogenous_count>() << 0.5, 0.3, 0.3, 0.3, 0.3;
  return sd;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double v : values) total += v;
  return total;
}

}  // namespace

RecursiveLeastSquares::RecursiveLeastSquares(const Eigen::VectorXd& mean, const Eigen::VectorXd& sd)
    : theta_(mean), covariance_(sd.cwiseAbs2().asDiagonal()), prior_trace_(sd.squaredNorm()) {}

void RecursiveLeastSquares::update(const Eigen::VectorXd& h, double target, double noise_var, double forgetting,
                                   double clip) {
  if (!h.allFinite() || !std::isfinite(target)) return;
  if (covariance_.trace() < prior_trace_) covariance_ /= forgetting;
  const Eigen::VectorXd ph = covariance_ * h;
  const Eigen::VectorXd k = ph / (noise_var + h.dot(ph));
  theta_ += k * std::clamp(target - h.dot(theta_), -clip, clip);
  covariance_ -= k * ph.transpose();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

ArxBaseline::ArxBaseline(const ControllerSettings& site, const ArxSettings& settings)
    : site_(site), settings_(settings), model_(prior_mean(settings), prior_sd(settings)) {}

std::string ArxBaseline::name() const { return settings_.exogenous ? "ARX + exogenous, RLS" : "ARX, 2 parameters"; }

double ArxBaseline::gain() const {
  return std::clamp(model_.parameters()[gain_index], settings_.gain_min, settings_.gain_max);
}

ArxBaseline::Instant ArxBaseline::instant(CivilTime time, const sim::Sensors& sensors, double setpoint_degc) const {
  Instant i{time, room_mean_degc(sensors), {}, setpoint_degc};
  if (settings_.exogenous) {
    const auto fcus = static_cast<double>(sensors.fcu_temp_degc.size());
    i.x.resize(exogenous_count);
    i.x << (fcus > 0 ? sum(sensors.fcu_temp_degc) / fcus : 0.0),
        (sensors.power_kw.empty() ? 0.0 : sensors.power_kw.back()), sensors.mau_temp_degc, sum(sensors.fcu_on),
        sum(sensors.vav_on);
  }
  return i;
}

Eigen::VectorXd ArxBaseline::regressors(const Instant& before, const Instant& now, double setpoint_change_k) const {
  Eigen::VectorXd h(parameter_count(settings_));
  h.head<own_parameters>() << now.mean_degc - before.mean_degc, setpoint_change_k;
  if (settings_.exogenous) {
    // A meter that cannot be read has not changed.
    h.tail<exogenous_count>() = (now.x - before.x).unaryExpr([](double d) { return std::isfinite(d) ? d : 0.0; });
  }
  return h;
}

void ArxBaseline::observe_history(std::span<const HistoryRow> rows) {
  std::vector<Instant> log;
  log.reserve(rows.size());
  for (const HistoryRow& row : rows) log.push_back(instant(row.time, row.sensors, row.setpoint_degc));
  const auto cycle = static_cast<std::size_t>(control_cycle(site_).rows);
  const int cycle_s = control_cycle(site_).seconds();
  const auto held = [&](std::size_t from) {
    for (std::size_t j = from + 1; j < from + cycle; ++j) {
      if (log[j].setpoint_degc != log[from].setpoint_degc) return false;
    }
    return log[from + cycle].time.seconds - log[from].time.seconds == cycle_s;
  };
  // Neighbouring rows share all but one row of their cycle, so those of a cycle are worth one.
  const double noise_var = settings_.noise_sd_k * settings_.noise_sd_k * control_cycle(site_).rows;
  for (std::size_t j = cycle; j + cycle < log.size(); ++j) {
    if (!held(j - cycle) || !held(j)) continue;
    const double change = log[j].setpoint_degc - log[j - cycle].setpoint_degc;
    model_.update(regressors(log[j - cycle], log[j], change), log[j + cycle].mean_degc - log[j].mean_degc, noise_var,
                  1.0, std::numeric_limits<double>::infinity());
  }
  past_.clear();
  const std::size_t keep = std::min(log.size(), 2 * cycle);
  past_.assign(log.end() - static_cast<std::ptrdiff_t>(keep), log.end());
}

double ArxBaseline::decide(const CycleObservation& observed) {
  Instant now = instant(observed.time, observed.sensors, observed.previous_setpoint_degc);
  const auto ago = [&](int cycles) -> const Instant* {
    for (const Instant& i : past_) {
      if (i.time.seconds == observed.time.seconds - cycles * control_cycle(site_).seconds()) return &i;
    }
    return nullptr;
  };
  const Instant* one = ago(1);
  const Instant* two = ago(2);
  if (one && two) {
    const double change = observed.previous_setpoint_degc - two->setpoint_degc;
    model_.update(regressors(*two, *one, change), now.mean_degc - one->mean_degc,
                  settings_.noise_sd_k * settings_.noise_sd_k, settings_.forgetting, settings_.clip_k);
  }

  double setpoint_degc = observed.previous_setpoint_degc;
  const double error_k = observed.target_degc - now.mean_degc;
  if (std::isfinite(error_k)) {
    double drift_k = one ? regressors(*one, now, 0.0).dot(model_.parameters()) : 0.0;
    if (!std::isfinite(drift_k)) drift_k = 0;
    setpoint_degc += ((1 - settings_.rho) * error_k - drift_k) / gain();
  }
  setpoint_degc = admissible_setpoint_degc(setpoint_degc, site_);

  // What the AHU took over the last cycle is known only now.
  if (one) {
    Instant last = *one;
    last.setpoint_degc = observed.previous_setpoint_degc;
    past_ = {last};
  } else {
    past_.clear();
  }
  now.setpoint_degc = setpoint_degc;
  past_.push_back(now);
  return setpoint_degc;
}

}  // namespace airside::tools
