#pragma once
// Electric power of fan, cooling and reheat as a function of flow, supply, room and outdoor temperature: physics gives
// the shapes, the meters give the coefficients and decide whether there is an economizer.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "airside/demand/power_shapes.hpp"
#include "airside/demand/recursive_least_squares.hpp"
#include "airside/demand_settings.hpp"

namespace airside {

/// What meters showed, mean of a cycle. NaN: no meter shows it.
struct MeteredCycle {
  double total_kw = 0;
  double fan_kw = 0;     ///< the fan alone
  double flow_m3_s = 0;  ///< of the supply fan
};

/// Fan:  P_f = f1 + f2 F + f3 F^3, from its own meter where there is one.
/// Rest, twice: P_r = c1 + c2 Q + c3 Q warm + c4 outdoor + c5 cold + c6 F (+ c7 F^3 without a fan's meter), Q the
/// coil's load without (lift) and with (coil) an economizer. Each is weighted by how well it predicts the meters:
///   w_coil = r^16 / (1 + r^16),  r = mean e_lift^2 / mean e_coil^2: as 32 independent cycles would have it.
/// Units: kW, K. Cost: two updates of 7 and one of 3 coefficients a cycle. Plain bytes.  Source: docs/method.md 17.3.
class PowerModel {
 public:
  static constexpr std::size_t rest_terms = 7;
  using Row = std::array<double, rest_terms>;
  using FanRow = std::array<double, 3>;
  using Rest = RecursiveLeastSquares<rest_terms>;

  /// Learns one cycle's mean shapes and powers; `fan_kw` NaN where no meter shows the fan alone.
  /// Errors: a sample that is not finite changes nothing.
  void update(const DemandSettings& s, const PowerShapes& x, const MeteredCycle& metered) {
    const double total_kw = metered.total_kw, fan_kw = metered.fan_kw;
    if (!std::isfinite(total_kw) || !std::isfinite(sum_of(x))) return;
    if (std::isfinite(metered.flow_m3_s) && x.flow > 0.05) {
      const double kw = air_kj_m3k * metered.flow_m3_s / x.flow * 10;
      flow_kw_ += (flow_kw_ > 0 ? 0.02 : 1.0) * (kw - flow_kw_);
    }
    if (samples_ < prior_samples) {
      gather(x, total_kw, fan_kw);
      if (++samples_ == prior_samples) begin();
      return;
    }
    ++samples_;
    mean_kw_ += 0.003 * (total_kw - mean_kw_);
    const double rest_kw = has_fan_ != 0 ? total_kw - fan_kw : total_kw;
    const double noise = s.power_noise * std::max({mean_kw_, total_kw, 1e-3});
    const double lift = learn(lift_, s, lift_row(x), rest_kw, noise);
    const double coil = learn(coil_, s, coil_row(x), rest_kw, noise);
    weigh(x, lift, coil);
    if (has_fan_ == 0) return;
    fan_.forget(s.forget_per_cycle);
    fan_.update(fan_row(x), fan_kw, 0.3 * noise);
  }

  double power_kw(const PowerShapes& x) const {
    const double w = economizer_share();
    const double rest = (1 - w) * lift_.predict(lift_row(x)) + w * coil_.predict(coil_row(x));
    return rest + (has_fan_ != 0 ? fan_.predict(fan_row(x)) : 0.0);
  }

  /// Electricity that cooling takes for this much more of a coil's load, kW.
  double cooling_kw(double lift, double outdoor_degc) const {
    const double w = economizer_share(), warm = (outdoor_degc - 25) / 10;
    const double c = (1 - w) * lift_.theta()[1] + w * coil_.theta()[1];
    const double c_warm = (1 - w) * lift_.theta()[2] + w * coil_.theta()[2];
    return lift * std::max(0.0, c + c_warm * warm);
  }

  /// Heat that the setpoint costs: of boxes that are cold already and get colder air, and of outdoor air that is warmed
  /// up to the setpoint, kW. Not learned, since what rooms need varies much more than what the setpoint adds, and
  /// meters often do not see it; it is known to a constant.
  double heating_kw(const PowerShapes& x) const { return thermal_kw() * (x.reheat + x.preheat); }

  /// Heat that flows with all dampers open and 10 K between room and supply air: of the flow sensor, else guessed from
  /// what cooling takes.
  double thermal_kw() const {
    return flow_kw_ > 0 ? flow_kw_ : usual_cop * std::max(lift_.theta()[1], coil_.theta()[1]);
  }

  /// Standard deviation of the difference of two states' powers, kW: of the coefficients, and of not knowing which of
  /// the two laws holds.
  double difference_sd_kw(const PowerShapes& a, const PowerShapes& b) const {
    const Row lift = difference(lift_row(a), lift_row(b)), coil = difference(coil_row(a), coil_row(b));
    const double w = economizer_share();
    const double apart = lift_.predict(lift) - coil_.predict(coil);
    const double sd_lift = lift_.sd(lift), sd_coil = coil_.sd(coil);
    double variance = (1 - w) * sd_lift * sd_lift + w * sd_coil * sd_coil + w * (1 - w) * apart * apart;
    if (has_fan_ != 0) {
      const double fan = fan_.sd(difference(fan_row(a), fan_row(b)));
      variance += fan * fan;
    }
    return std::sqrt(variance);
  }

  /// Belief that outdoor air cools where it is colder than the rooms, 0..1.
  double economizer_share() const {
    double odds = lift_error_kw2_ / coil_error_kw2_;
    for (int i = 0; i < 4; ++i) odds *= odds;
    return std::isfinite(odds) ? odds / (1 + odds) : 1.0;
  }
  double mean_kw() const { return mean_kw_; }
  int learned() const { return std::max<std::int32_t>(0, samples_ - prior_samples); }
  const Rest& lift_law() const { return lift_; }
  const Rest& coil_law() const { return coil_; }
  const RecursiveLeastSquares<3>& fan_law() const { return fan_; }
  bool finite() const {
    return lift_.finite() && coil_.finite() && fan_.finite() && lift_error_kw2_ > 0 && coil_error_kw2_ > 0 &&
           std::isfinite(lift_error_kw2_ + coil_error_kw2_);
  }

 private:
  static constexpr int prior_samples = 40;
  static constexpr double air_kj_m3k = 1.207;
  static constexpr double usual_cop = 3.5, worst_cop = 1.5, best_cop = 9;
  static constexpr double wet_share = 0.2;  ///< of the fan's slope: what a colder coil may condense more
  static constexpr double unbounded = 1e12;
  static constexpr double error_memory = 0.01;  // 100 cycles that tell the laws apart

  static Row rest_row(const PowerShapes& x, double coil, double coil_warm) {
    return {1, coil, coil_warm, x.outdoor, x.cold_share, x.flow, x.flow_cubed};
  }
  static Row lift_row(const PowerShapes& x) { return rest_row(x, x.lift, x.lift_warm); }
  static Row coil_row(const PowerShapes& x) { return rest_row(x, x.coil, x.coil_warm); }
  static FanRow fan_row(const PowerShapes& x) { return {1, x.flow, x.flow_cubed}; }
  static double sum_of(const PowerShapes& x) {
    return x.flow + x.flow_cubed + x.lift + x.lift_warm + x.coil + x.coil_warm + x.outdoor + x.cold_share + x.reheat +
           x.preheat;
  }
  template <std::size_t N>
  static std::array<double, N> difference(const std::array<double, N>& a, const std::array<double, N>& b) {
    std::array<double, N> d{};
    for (std::size_t i = 0; i < N; ++i) d[i] = a[i] - b[i];
    return d;
  }

  double learn(Rest& law, const DemandSettings& s, const Row& x, double kw, double noise) const {
    law.forget(s.forget_per_cycle);
    const double error = law.update(x, kw, noise);
    // What cools takes power, as much as a chiller's efficiency allows.
    law.bound(1, flow_kw_ / best_cop, flow_kw_ > 0 ? flow_kw_ / worst_cop : unbounded);
    if (has_fan_ != 0) {
      // Flow and the coil's load go up and down together, so the meters hardly tell them apart: without this bound
      // cooling was believed to fall with flow by two thirds of what the fan takes more.
      law.bound(5, -wet_share * std::max(0.0, fan_slope_kw()), unbounded);
    } else {
      law.bound(5, 0.5 * fan_prior_[0], unbounded);  // a fan is never free
      law.bound(6, 0.5 * fan_prior_[1], unbounded);
    }
    return error;
  }

  /// dP_f / dF at the flow of the first cycles.
  double fan_slope_kw() const { return fan_.theta()[1] + 3 * fan_.theta()[2] * mean_flow_ * mean_flow_; }

  /// Only cycles in which the two laws differ and no box heats, which neither of them means.
  void weigh(const PowerShapes& x, double lift_error, double coil_error) {
    if (!std::isfinite(lift_error) || !std::isfinite(coil_error) || !(x.coil < 0.9 * x.lift)) return;
    const double share = error_memory * (1 - std::min(1.0, 5 * x.cold_share));
    lift_error_kw2_ += share * (std::max(lift_error * lift_error, least_error_kw2()) - lift_error_kw2_);
    coil_error_kw2_ += share * (std::max(coil_error * coil_error, least_error_kw2()) - coil_error_kw2_);
  }
  double least_error_kw2() const { return 1e-4 * mean_kw_ * mean_kw_; }

  void gather(const PowerShapes& x, double total_kw, double fan_kw) {
    const double share = 1.0 / (samples_ + 1);
    has_fan_ = std::isfinite(fan_kw) && (samples_ == 0 || has_fan_ != 0) ? 1 : 0;
    mean_kw_ += share * (total_kw - mean_kw_);
    mean_flow_ += share * (x.flow - mean_flow_);
    mean_lift_ += share * (x.lift - mean_lift_);
    mean_fan_kw_ += has_fan_ != 0 ? share * (fan_kw - mean_fan_kw_) : 0.0;
  }

  /// The prior, once the size of the plant is known: without a meter of its own a fifth of the power is the fan's; the
  /// rest is the coil's, a fifth worse for each 10 K outdoors.
  void begin() {
    const double f = std::max(0.1, mean_flow_), c = std::max(0.2, mean_lift_);
    const double fan_kw = has_fan_ != 0 ? mean_fan_kw_ : 0.2 * mean_kw_;
    // Where it did not cool yet, the fan tells the plant's size: 7 kW of heat flow a kW of fan at full flow is usual.
    const double seen = 0.9 * (mean_kw_ - fan_kw) / c, sized = 7 / usual_cop * fan_kw / (f * f);
    const double slope = flow_kw_ > 0 ? flow_kw_ / usual_cop : std::max(seen, sized);
    const double scale = std::max(mean_kw_, 0.5 * slope * c);
    Row mean{0, slope, 0.2 * slope, 0, 0, 0, 0};
    Row sd{0.3 * scale, 0.5 * slope, 0.1 * slope, 0.3 * scale, scale, 0.05 * scale / f, 0};
    fan_prior_ = {0.4 * fan_kw / f, 0.6 * fan_kw / (f * f * f)};
    if (has_fan_ == 0) {
      mean[5] = fan_prior_[0];
      mean[6] = fan_prior_[1];
      sd[5] = 0.5 * fan_kw / f;
      sd[6] = 0.6 * fan_kw / (f * f * f);
    }
    lift_error_kw2_ = coil_error_kw2_ = std::max(100 * least_error_kw2(), 1e-9);
    lift_.reset(mean, sd);
    coil_.reset(mean, sd);
    fan_.reset({0, fan_prior_[0], fan_prior_[1]}, {0.2 * fan_kw, fan_kw / f, fan_kw / (f * f * f)});
  }

  Rest lift_, coil_;
  RecursiveLeastSquares<3> fan_;
  std::array<double, 2> fan_prior_{};  ///< of F and F^3
  double mean_kw_ = 0, mean_fan_kw_ = 0, mean_flow_ = 0, mean_lift_ = 0;
  double flow_kw_ = 0;                              ///< thermal_kw() by the flow sensor; 0: there is none
  double lift_error_kw2_ = 1, coil_error_kw2_ = 1;  ///< mean squares of what the two laws missed
  std::int32_t samples_ = 0;
  std::int32_t has_fan_ = 0;
};

}  // namespace airside
