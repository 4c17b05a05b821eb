#pragma once
// Which setpoint the network would choose: forecasts for every candidate, their scores, a second finer grid.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "airside/forecast/candidate_record.hpp"
#include "airside/forecast/scores.hpp"
#include "airside/held_rooms.hpp"
#include "airside/network/forward.hpp"
#include "airside/network/scaler.hpp"
#include "airside/network/scratch.hpp"
#include "airside/settings.hpp"
#include "airside/topology.hpp"

namespace airside {

/// The network as a search sees it.
template <Topology T, class Scalar>
struct ForecastModel {
  const Scaler<T>& scaler;
  const PackedWeights<T, Scalar>& weights;
  NetworkScratch<T, Scalar>& scratch;
};

/// predict -> score.  Shape: T. Cost: two passes of at most max_candidates forecasts; nothing is allocated.
/// Source: docs/method.md 6.1, open points 14-16.
template <Topology T, class Scalar>
class CandidateSearch {
 public:
  using L = Layout<T>;
  using Vector = Eigen::Matrix<double, L::signals, 1>;

  /// The grid of the action set, and the site's shape.
  void configure(const ControllerSettings& s) {
    site_ = shape_in<T>(s.shape);
    const double span = s.action_max_degc - s.action_min_degc;
    count_ = std::min(static_cast<int>(std::lround(span / s.action_step_k)) + 1, max_candidates);
    for (int i = 0; i < count_; ++i) {
      candidates_[static_cast<std::size_t>(i)] = std::min(s.action_min_degc + i * s.action_step_k, s.action_max_degc);
    }
  }

  /// The network's choice in state `now`, degC; `record` keeps the first pass. Errors: NaN if no forecast is a number.
  double best_degc(const ControllerSettings& s, const ForecastModel<T, Scalar>& model, const Vector& now,
                   double last_degc, CandidateRecord* record = nullptr) {
    scaled_ = model.scaler.template signals<Scalar>(now);
    boxes_ = now.segment(L::vav_on, L::rooms);
    const double room = held_degc<T>(s.held, site_, now);
    const int best = choose(s, model, {candidates_.data(), static_cast<std::size_t>(count_)}, room, last_degc);
    if (record != nullptr) note(s, model.scaler, *record);
    if (best < 0) return unknown;
    const double coarse = candidates_[static_cast<std::size_t>(best)];
    if (s.refine_step_k <= 0) return coarse;
    const double step = s.refine_step_k;
    const int half = std::min(static_cast<int>(std::lround(s.action_step_k / step)), (max_candidates - 1) / 2);
    int n = 0;
    for (int i = -half; i <= half; ++i) {
      const double a = coarse + i * step;
      if (a < s.action_min_degc - 1e-9 || a > s.action_max_degc + 1e-9) continue;
      fine_[static_cast<std::size_t>(n++)] = a;
    }
    const int finer = choose(s, model, {fine_.data(), static_cast<std::size_t>(n)}, room, last_degc);
    return finer < 0 ? unknown : fine_[static_cast<std::size_t>(finer)];
  }

  /// Held value that the network expects at the end of a cycle that begins in `now` at this setpoint, degC.
  double expected_degc(const ControllerSettings& s, const ForecastModel<T, Scalar>& model, const Vector& now,
                       double setpoint_degc) {
    scaled_ = model.scaler.template signals<Scalar>(now);
    boxes_ = now.segment(L::vav_on, L::rooms);
    forecast(model, {&setpoint_degc, 1});
    return predicted(s, model.scaler, 0, false);
  }

 private:
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  int choose(const ControllerSettings& s, const ForecastModel<T, Scalar>& model,
             std::span<const double> candidates_degc, double room_degc, double last_degc) {
    forecast(model, candidates_degc);
    for (std::size_t i = 0; i < candidates_degc.size(); ++i) {
      const double move = std::isfinite(last_degc) ? candidates_degc[i] - last_degc : 0.0;
      const double later_degc = predicted(s, model.scaler, i, s.long_term != 0);
      scores_[i] = setpoint_score(s, room_degc, later_degc, move);
    }
    return best_candidate(s, {scores_.data(), candidates_degc.size()}, candidates_degc, last_degc);
  }

  /// Of the first pass, before the second takes its place.
  void note(const ControllerSettings& s, const Scaler<T>& scaler, CandidateRecord& record) const {
    const int stride = record.take_grid(s.action_min_degc, s.action_step_k, count_);
    for (int i = 0; i < record.count; ++i) {
      const auto to = static_cast<std::size_t>(i), from = static_cast<std::size_t>(i * stride);
      record.network_degc[to] = static_cast<float>(predicted(s, scaler, from, s.long_term != 0));
      record.score[to] = static_cast<float>(scores_[from]);
    }
    record.has_network = true;
  }

  void forecast(const ForecastModel<T, Scalar>& model, std::span<const double> candidates_degc) {
    for (std::size_t i = 0; i < candidates_degc.size(); ++i) {
      scaled_setpoints_[i] = model.scaler.template setpoint<Scalar>(candidates_degc[i]);
    }
    forecast_candidates<T, Scalar>(model.weights, std::span<const Scalar, L::signals>(scaled_.data(), L::signals),
                                   {scaled_setpoints_.data(), candidates_degc.size()}, model.scratch, forecasts_);
  }

  /// The held value of the predicted rooms, their boxes as they are now, degC.
  double predicted(const ControllerSettings& s, const Scaler<T>& scaler, std::size_t i, bool in_the_long_run) const {
    if (s.held.rule == HoldRule::mean) return in_the_long_run ? long_mean(scaler, i) : short_mean(scaler, i);
    const auto n = rooms_of<T>(site_);
    Eigen::Matrix<double, L::rooms, 1> rooms = Eigen::Matrix<double, L::rooms, 1>::Zero();
    for (Eigen::Index r = 0; r < n; ++r) {
      const auto k = static_cast<std::size_t>(r);
      const double later = in_the_long_run ? static_cast<double>(forecasts_[i].deviation[k]) : 0.0;
      rooms(r) = scaler.room_mean() + scaler.room_scale() * (static_cast<double>(forecasts_[i].short_term[k]) + later);
    }
    return held_of(s.held, rooms.head(n), boxes_.head(n));
  }

  double short_mean(const Scaler<T>& scaler, std::size_t i) const {
    double sum = 0;
    for (const Scalar s : forecasts_[i].short_term) sum += static_cast<double>(s);
    return scaler.room_mean() + scaler.room_scale() * sum / rooms_of<T>(site_);
  }
  double long_mean(const Scaler<T>& scaler, std::size_t i) const {
    double sum = 0;
    for (const Scalar d : forecasts_[i].deviation) sum += static_cast<double>(d);
    return short_mean(scaler, i) + scaler.room_scale() * sum / rooms_of<T>(site_);
  }

  Shape site_ = capacity_of<T>();
  int count_ = 0;
  Eigen::Matrix<Scalar, L::signals, 1> scaled_;
  Eigen::Matrix<double, L::rooms, 1> boxes_;  ///< open or closed, of the state that is searched in
  std::array<double, max_candidates> candidates_{}, fine_{}, scores_{};
  std::array<Scalar, max_candidates> scaled_setpoints_{};
  std::array<RoomForecast<T, Scalar>, max_candidates> forecasts_{};
};

}  // namespace airside
