#pragma once
// The room head: a recursive linear forecast of how far the held value of the rooms moves in the next cycle,
// with a profile of the day's disturbances. It corrects the network where a room is nearly linear and learns within
// days; the network gives it the gain it starts from.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "airside/civil_time.hpp"
#include "airside/exponential.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/memory_size.hpp"
#include "airside/settings.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Profiles that the room head keeps: one, or another one for days off.
constexpr int day_types_of(const ControllerSettings& s) {
  return s.head_day_types != 0 ? std::min(s.head_day_types, max_day_types) : max_day_types;
}

/// ds = x' theta_x + profile(slot) + ma e.
/// x: HeadFeatures.
/// Shape: 14 regressors and 80 slots a day type. Units: K; power in units of the scaler.
/// Cost: one Kalman update a cycle, O((14 + 80 d)^2).  Source: docs/method.md 16.2.
template <Topology T>
class RoomHead {
 public:
  static constexpr int regressors = HeadFeatures::count;
  static constexpr int slots = profile_slots;
  static constexpr int day_types = max_day_types;
  static constexpr int states = regressors + slots * day_types;
  using State = Eigen::Matrix<double, states, 1>;
  /// Too large for a stack, and for Eigen's limit on fixed matrices: an array seen through a map.
  using CovarianceStore = std::array<double, static_cast<std::size_t>(states* states)>;
  using Covariance = Eigen::Map<Eigen::Matrix<double, states, states>>;
  using ConstCovariance = Eigen::Map<const Eigen::Matrix<double, states, states>>;

  /// Forgets everything but the prior: gain `gain` +- `gain_sd` K/K, other regressors 0 +- 0.5, a smooth profile.
  void reset(const ControllerSettings& s, double gain, double gain_sd) {
    theta_.setZero();
    Covariance p = covariance();
    p.setZero();
    for (int i = 0; i < regressors; ++i) p(i, i) = 0.25;
    theta_(HeadFeatures::setpoint_change) = gain;
    p(HeadFeatures::setpoint_change, HeadFeatures::setpoint_change) = gain_sd * gain_sd;
    add_profile_covariance(s, 1.0);
    last_innovation_k_ = 0;
    updates_ = 0;
  }

  /// Expected change of the held value over the next cycle if the setpoint stays, K.
  double drift_k(const ControllerSettings& s, CivilTime t, const HeadFeatures& f) const {
    return row(s, t, f).dot(theta_) + s.head_moving_average * last_innovation_k_;
  }

  /// Setpoint gain, K room per K setpoint in one cycle, within its bounds.
  double gain(const ControllerSettings& s) const {
    return std::clamp(theta_(HeadFeatures::setpoint_change), s.head_gain_min, s.head_gain_max);
  }
  double gain_sd() const {
    constexpr int g = HeadFeatures::setpoint_change;
    return std::sqrt(std::max(0.0, covariance()(g, g)));
  }

  /// Whether colder supply air makes the rooms warmer, beyond doubt: gain + 2 sd < 0.
  bool gain_is_reversed() const { return theta_(HeadFeatures::setpoint_change) + 2 * gain_sd() < 0; }

  /// Whether colder supply air makes the rooms colder, beyond doubt: gain - 2 sd > 0.
  bool gain_is_sane() const { return theta_(HeadFeatures::setpoint_change) - 2 * gain_sd() > 0; }

  /// The setpoint that removes `head_correction` of the present error by the end of the cycle, degC. `residual_k`: by
  /// which the room will move besides, as another forecast has it.
  double setpoint_degc(const ControllerSettings& s, CivilTime t, const HeadFeatures& f, double held_degc,
                       double setpoint_before_degc, double residual_k = 0) const {
    const double wanted_k = s.head_correction * (s.target_degc - held_degc);
    return setpoint_before_degc + (wanted_k - drift_k(s, t, f) - residual_k) / gain(s);
  }

  /// Learns from one completed cycle: features f at t, then the held value moved by `moved_k`.
  /// `noise_factor` > 1 weakens the update (overlapping samples of a history). Returns the innovation, K.
  /// Errors: an input that is not finite changes nothing and returns NaN.
  double update(const ControllerSettings& s, CivilTime t, const HeadFeatures& f, double moved_k,
                double noise_factor = 1.0) {
    const State h = row(s, t, f);
    const double innovation = moved_k - h.dot(theta_) - s.head_moving_average * last_innovation_k_;
    if (!std::isfinite(innovation)) return innovation;
    const double clipped = std::clamp(innovation, -s.head_clip_k, s.head_clip_k);
    Covariance p = covariance();
    work_.noalias() = p * h;
    const double noise = s.head_noise_k * noise_factor;
    const double variance = h.dot(work_) + noise * noise;
    theta_ += work_ * (clipped / variance);
    for (int j = 0; j < states; ++j) p.col(j) -= work_ * (work_(j) / variance);
    last_innovation_k_ = clipped;
    ++updates_;
    return innovation;
  }

  /// Gives days off their own profile where the estimate comes from settings with one: it begins as the working
  /// days' profile plus an unknown difference, as sure as the prior has it. Changes nothing where there is one.
  /// Cost: O(states^2).
  void complete_day_types(const ControllerSettings& s) {
    if constexpr (day_types == 1) return;
    Covariance p = covariance();
    constexpr int known = regressors + slots;
    if (day_types_of(s) != 2 || !(p.diagonal().template tail<slots>().array() == 0).all()) return;
    for (int i = 0; i < slots; ++i) {
      theta_(known + i) = theta_(regressors + i);
      for (int j = 0; j < known; ++j) p(known + i, j) = p(j, known + i) = p(regressors + i, j);
    }
    for (int i = 0; i < slots; ++i) {
      for (int j = 0; j < slots; ++j) {
        const int d = i > j ? i - j : j - i;
        p(known + i, known + j) =
            p(regressors + i, regressors + j) + 2 * (1 - s.head_days_alike) * profile_covariance(s, d);
      }
    }
  }

  /// The unit of power becomes `ratio` times as large.
  void rescale_power(double ratio) {
    constexpr int i = HeadFeatures::power_change;
    theta_(i) *= ratio;
    Covariance p = covariance();
    p.row(i) *= ratio;
    p.col(i) *= ratio;
  }

  /// Lets the room change over `days`: regressors walk at random, the profile forgets towards its prior, so that a slot
  /// that is never seen is never less sure than the prior.
  /// P_xx += w^2 days I; P_pp = r^2 P_pp + (1 - r^2) K, P_xp = r P_xp; r^2 = 1 - q days; the estimate itself stays.
  void grow(const ControllerSettings& s, double days) {
    Covariance p = covariance();
    const double walk_variance = s.head_walk_per_day * s.head_walk_per_day * days;
    p.diagonal().template head<regressors>().array() += walk_variance;
    const double forgotten = std::min(1.0, s.head_growth_per_day * days);
    const double kept = std::sqrt(1.0 - forgotten);
    p.template topRightCorner<regressors, slots * day_types>() *= kept;
    p.template bottomLeftCorner<slots * day_types, regressors>() *= kept;
    p.template bottomRightCorner<slots * day_types, slots * day_types>() *= kept * kept;
    add_profile_covariance(s, forgotten);
  }

  const State& theta() const { return theta_; }
  State& theta() { return theta_; }
  ConstCovariance covariance() const { return ConstCovariance(covariance_.data()); }
  Covariance covariance() { return Covariance(covariance_.data()); }
  std::uint32_t updates() const { return updates_; }
  void set_updates(std::uint32_t n) { updates_ = n; }
  bool finite() const { return theta_.allFinite() && covariance().allFinite(); }

 private:
  /// h = [x | slot weights], linear between neighbouring slots.
  static State row(const ControllerSettings& s, CivilTime standard_time, const HeadFeatures& f) {
    const CivilTime t = local_time(s, standard_time);  // people's days move with their clocks
    State h = State::Zero();
    h.template head<regressors>() = f.x;
    const int type = day_types_of(s) == 2 && t.weekday() >= 5 ? 1 : 0;
    const double position = static_cast<double>(t.second_of_day()) / profile_slot_s;
    const int slot = std::min(static_cast<int>(position), slots - 1);
    const double share = position - slot;
    const int first = regressors + type * slots;
    h(first + slot) = 1.0 - share;
    h(first + (slot + 1) % slots) += share;
    return h;
  }

  /// Prior covariance of two slots that lie `d` slots apart, K^2.
  static double profile_covariance(const ControllerSettings& s, int d) {
    return s.head_profile_sd_k * s.head_profile_sd_k * exponential(-std::min(d, slots - d) / s.head_profile_length);
  }

  void add_profile_covariance(const ControllerSettings& s, double share) {
    const double variance = share * s.head_profile_sd_k * s.head_profile_sd_k;
    std::array<double, slots> kernel{};
    for (int d = 0; d < slots; ++d) {
      kernel[static_cast<std::size_t>(d)] = variance * exponential(-std::min(d, slots - d) / s.head_profile_length);
    }
    const int types = day_types_of(s);
    Covariance p = covariance();
    for (int a = 0; a < types; ++a) {
      for (int b = 0; b < types; ++b) {
        const double alike = a == b ? 1.0 : s.head_days_alike;
        for (int i = 0; i < slots; ++i) {
          for (int j = 0; j < slots; ++j) {
            p(regressors + a * slots + i, regressors + b * slots + j) +=
                alike * kernel[static_cast<std::size_t>(i > j ? i - j : j - i)];
          }
        }
      }
    }
  }

  alignas(state_alignment) State theta_ = State::Zero();
  CovarianceStore covariance_{};
  alignas(state_alignment) State work_ = State::Zero();
  double last_innovation_k_ = 0;
  std::uint32_t updates_ = 0;
};

}  // namespace airside
