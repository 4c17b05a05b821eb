#pragma once
// The residual forecaster: a small pretrained network that predicts the room head's next error, and a gate that uses
// it only as far as it has helped lately.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "airside/forecast/residual_features.hpp"

namespace airside {

/// f(x) = clip(W3 a(W2 a(W1 z + b1) + b2) + b3, +-0.5), z = clip((x - mean) / scale, +-8), a(y) = max(y, y / 100).
/// Shape: 18 regressors, 32 and 16 units. Units: K.
/// Cost: 1,153 parameters, as many multiplications.  Source: docs/method.md 16.6.
struct ResidualNetwork {
  static constexpr int inputs = ResidualFeatures::count, first = 32, second = 16;
  static constexpr int weights = (inputs + 1) * first + (first + 1) * second + second + 1;
  static constexpr int parameters = 2 * inputs + weights;  ///< with mean and scale of each regressor
  static constexpr float clip = 8.0f;
  static constexpr float most_k = 0.5f;  ///< whatever the weights are

  /// In the order mean, scale, then layer by layer, unit by unit: weights, bias.
  std::array<float, static_cast<std::size_t>(parameters)> values{};
  std::uint32_t is_trained = 0;

  /// What the head's forecast will be wrong by, K.  Each sum runs in one order: the same bits everywhere in a strict
  /// build.
  double forecast_k(const ResidualFeatures& f) const {
    std::array<float, first> a{};
    std::array<float, second> b{};
    std::array<float, 1> out{};
    std::array<float, inputs> z{};
    for (std::size_t i = 0; i < z.size(); ++i) {
      z[i] = std::clamp((f.x(static_cast<int>(i)) - values[i]) / values[inputs + i], -clip, clip);
    }
    const float* at = values.data() + 2 * inputs;
    at = layer(at, z, a);
    for (float& v : a) v = leaky(v);
    at = layer(at, a, b);
    for (float& v : b) v = leaky(v);
    layer(at, b, out);
    return static_cast<double>(std::clamp(out[0], -most_k, most_k));
  }

  void take(std::span<const float> from) {
    std::copy(from.begin(), from.end(), values.begin());
    is_trained = 1;
  }

  /// Whether all values can be: finite, scales positive, weights within 1000.
  bool is_sound() const {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool is_scale = i >= inputs && i < 2 * std::size_t{inputs};
      if (!(std::abs(values[i]) <= 1e3f) || (is_trained != 0 && is_scale && !(values[i] > 0.0f))) return false;
    }
    return true;
  }

 private:
  static float leaky(float y) { return std::max(y, 0.01f * y); }

  template <std::size_t In, std::size_t Out>
  static const float* layer(const float* at, const std::array<float, In>& in, std::array<float, Out>& out) {
    for (float& sum : out) {
      sum = 0;
      for (const float v : in) sum += v * *at++;
      sum += *at++;
    }
    return at;
  }
};

/// Which share of the forecast is used: of none, half and all of it the one that would have erred least over about
/// four working days.  Units: K.  Source: docs/method.md 16.6.
struct ResidualGate {
  static constexpr std::array<double, 3> shares{0.0, 0.5, 1.0};
  static constexpr double memory = 1.0 / 160;

  /// Running means of |e - share f|. What was pretrained begins as if it had helped by 5 mK a cycle: else the first
  /// cycle alone would decide.
  std::array<double, 3> error_k{0.005, 0.0025, 0.0};

  double share() const {
    std::size_t best = shares.size() - 1;  // what was pretrained is used until it errs
    for (std::size_t i = 0; i + 1 < shares.size(); ++i) best = error_k[i] < error_k[best] ? i : best;
    return shares[best];
  }

  /// Errors: what is not finite changes nothing.
  void judge(double head_error_k, double forecast_k) {
    if (!std::isfinite(head_error_k) || !std::isfinite(forecast_k)) return;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      error_k[i] += memory * (std::abs(head_error_k - shares[i] * forecast_k) - error_k[i]);
    }
  }
};

/// Network and gate, saved with what is learned. Plain bytes.
struct ResidualForecaster {
  ResidualNetwork network;
  ResidualGate gate;
};

}  // namespace airside
