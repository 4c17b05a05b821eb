#pragma once
// A transition in SI units and as the scaled row that the replay keeps.

#include <Eigen/Core>
#include <array>

#include "airside/learning/replay_ring.hpp"
#include "airside/network/scaler.hpp"
#include "airside/reading.hpp"
#include "airside/topology.hpp"

namespace airside {

/// One cycle: the readings at its begin and end, and the setpoint held in between. Units: SI.
template <Topology T>
struct Transition {
  using Vector = typename Reading<T>::Vector;
  Vector before;
  double setpoint_degc;
  Vector after;
};

/// x = [scaled before | scaled setpoint | scaled after].  Shape: Layout<T>::transition.
template <Topology T, class Scalar>
typename ReplayRing<T, Scalar>::Row to_row(const Scaler<T>& scaler, const typename Reading<T>::Vector& before,
                                           double setpoint_degc, const typename Reading<T>::Vector& after) {
  using L = Layout<T>;
  typename ReplayRing<T, Scalar>::Row row;
  Eigen::Map<Eigen::Matrix<Scalar, L::transition, 1>> x(row.data());
  x.template head<L::signals>() = scaler.template signals<Scalar>(before);
  x(L::setpoint) = scaler.template setpoint<Scalar>(setpoint_degc);
  x.template tail<L::signals>() = scaler.template signals<Scalar>(after);
  return row;
}

/// The same back in SI units.
template <Topology T, class Scalar>
Transition<T> from_row(const Scaler<T>& scaler, const std::array<Scalar, Layout<T>::transition>& row) {
  using L = Layout<T>;
  using Vector = typename Reading<T>::Vector;
  const Eigen::Map<const Eigen::Matrix<Scalar, L::transition, 1>> x(row.data());
  const Vector mean = scaler.mean.template head<L::signals>(), scale = scaler.scale.template head<L::signals>();
  const auto si = [&](const auto& part) -> Vector { return part.template cast<double>().cwiseProduct(scale) + mean; };
  return {si(x.template head<L::signals>()),
          static_cast<double>(x(L::setpoint)) * scaler.scale(L::setpoint) + scaler.mean(L::setpoint),
          si(x.template tail<L::signals>())};
}

}  // namespace airside
