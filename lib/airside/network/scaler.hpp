#pragma once
// From SI to the network's units and back. A scaler is fitted once on the source domain, frozen, and travels in
// the blob: refitting it on a target would silently change the transferred function (docs/method.md, open point 3).

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "airside/memory_size.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/signals.hpp"
#include "airside/topology.hpp"

namespace airside {

/// x = (value - mean) / scale.  Shape: inputs. Units: those of the signal. Status and absent slots have mean 0 and
/// scale 1; all rooms share one mean and scale, so that deviations are comparable across rooms.
template <Topology T>
struct Scaler {
  using Vector = Eigen::Matrix<double, Layout<T>::inputs, 1>;
  alignas(state_alignment) Vector mean = Vector::Zero();
  alignas(state_alignment) Vector scale = Vector::Ones();

  double room_mean() const { return mean(0); }
  double room_scale() const { return scale(0); }

  /// The S and E part of X.  Shape: signals.
  template <class Scalar>
  Eigen::Matrix<Scalar, Layout<T>::signals, 1> signals(const typename Reading<T>::Vector& value) const {
    constexpr int n = Layout<T>::signals;
    return (value - mean.template head<n>()).cwiseQuotient(scale.template head<n>()).template cast<Scalar>();
  }
  template <class Scalar>
  Scalar setpoint(double setpoint_degc) const {
    constexpr int a = Layout<T>::setpoint;
    return static_cast<Scalar>((setpoint_degc - mean(a)) / scale(a));
  }
  /// Of the power meter that the room head watches, kW; 1 where the site has none.
  double head_power_scale(const Shape& site) const {
    const int slot = last_power_of<T>(site);
    return slot < 0 ? 1.0 : scale(slot);
  }
  bool finite() const { return mean.allFinite() && scale.allFinite() && (scale.array() > 0).all(); }
};

/// Accumulates the mean and spread of a warm-up day; stand-ins are filled in before.  Cost: O(signals) a row; no rows
/// are kept.
template <Topology T>
class ScalerFit {
 public:
  void add(const typename Reading<T>::Vector& value) {
    ++count_;
    const typename Reading<T>::Vector step = value - mean_;
    mean_ += step / static_cast<double>(count_);
    square_ += step.cwiseProduct(value - mean_);
  }

  /// The scaler, with floors: 0.5 K for temperatures, 5 % of the mean (at least 0.05 kW) for power; the setpoint takes
  /// the action range's midpoint and range/sqrt(12).  Source: docs/method.md, open point 3.
  Scaler<T> fit(const ControllerSettings& s) const {
    using L = Layout<T>;
    Scaler<T> out;
    const Shape site = shape_in<T>(s.shape);
    const int rooms = rooms_of<T>(site);
    const double n = std::max<double>(1.0, static_cast<double>(count_));
    double room_mean = 0, room_square = 0;
    for (int r = 0; r < rooms; ++r) room_mean += mean_(r) / rooms;
    for (int r = 0; r < rooms; ++r) {
      const double offset = mean_(r) - room_mean;
      room_square += (square_(r) / n + offset * offset) / rooms;
    }
    for (int i = 0; i < L::signals; ++i) {
      const SignalKind kind = signal_id<T>(i).kind;
      if (is_status(kind) || !is_present<T>(site, i)) continue;
      const bool room = kind == SignalKind::room_temp;
      const double floor = kind == SignalKind::power ? std::max(0.05, 0.05 * std::abs(mean_(i))) : 0.5;
      out.mean(i) = room ? room_mean : mean_(i);
      out.scale(i) = std::max(floor, std::sqrt(room ? room_square : square_(i) / n));
    }
    out.mean(L::setpoint) = 0.5 * (s.action_min_degc + s.action_max_degc);
    out.scale(L::setpoint) = (s.action_max_degc - s.action_min_degc) / std::sqrt(12.0);
    return out;
  }
  std::uint64_t count() const { return count_; }

 private:
  std::uint64_t count_ = 0;
  typename Reading<T>::Vector mean_ = Reading<T>::Vector::Zero();
  typename Reading<T>::Vector square_ = Reading<T>::Vector::Zero();
};

}  // namespace airside
