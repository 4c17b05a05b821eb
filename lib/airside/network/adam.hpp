#pragma once
// Adam: bias-corrected, epsilon outside the root, no decay, no clipping (docs/method.md, open point 12).

#include <array>
#include <cstdint>

#include "airside/network/kernels/kernels.hpp"
#include "airside/network/network.hpp"
#include "airside/topology.hpp"

namespace airside {

struct AdamSettings {
  double learning_rate = 1e-3;
  double beta1 = 0.9, beta2 = 0.999;
  double epsilon = 1e-8;
};

/// Moments and the count of steps. Plain data.
/// The powers of beta are running products: pow() rounds differently from one maths library to the next.
template <Topology T, class Scalar>
struct AdamState {
  NetworkWeights<T, Scalar> first_moment, second_moment;
  std::uint64_t steps = 0;
  double beta1_power = 1, beta2_power = 1;
  std::array<std::uint64_t, 5> reserved{};  ///< makes the size a multiple of 64 without padding

  /// m <- b1 m + (1-b1) g;  v <- b2 v + (1-b2) g^2;  w <- w - lr m^ / (sqrt(v^) + eps),
  /// m^ = m/(1-b1^k), v^ = v/(1-b2^k).
  void update(NetworkWeights<T, Scalar>& weights, const NetworkWeights<T, Scalar>& gradient,
              const AdamSettings& settings, const Kernels<Scalar>& kernels) {
    ++steps;
    beta1_power *= settings.beta1;
    beta2_power *= settings.beta2;
    kernels.adam({weights.values.data(), first_moment.values.data(), second_moment.values.data(),
                  gradient.values.data(), NetworkWeights<T, Scalar>::stored, static_cast<Scalar>(settings.beta1),
                  static_cast<Scalar>(1 - settings.beta1), static_cast<Scalar>(settings.beta2),
                  static_cast<Scalar>(1 - settings.beta2),
                  static_cast<Scalar>(settings.learning_rate / (1 - beta1_power)),
                  static_cast<Scalar>(1 / (1 - beta2_power)), static_cast<Scalar>(settings.epsilon)});
  }
};

}  // namespace airside
