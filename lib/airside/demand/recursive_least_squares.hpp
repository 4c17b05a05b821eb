#pragma once
// Recursive least squares of a few coefficients with a prior, in the order of operations that a strict build repeats.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace airside {

/// y = x' theta + e, e of variance r.  One Kalman step a sample:
///   k = P x / (x' P x + r);  theta += k (y - x' theta);  P -= k x' P;  between samples P grows towards its prior.
/// Shape: N coefficients. Cost: O(N^2). Plain bytes.
template <std::size_t N>
class RecursiveLeastSquares {
 public:
  using Row = std::array<double, N>;

  /// Forgets everything but the prior: independent coefficients of this mean and standard deviation.
  void reset(const Row& mean, const Row& sd) {
    theta_ = mean;
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) p_[i * N + j] = i == j ? sd[i] * sd[i] : 0.0;
      prior_variance_[i] = sd[i] * sd[i];
    }
  }

  double predict(const Row& x) const { return dot(x, theta_); }

  /// Standard deviation of x' theta.
  double sd(const Row& x) const { return std::sqrt(std::max(0.0, dot(x, times(x)))); }

  /// Learns one sample; an innovation beyond 3 standard deviations counts as 3. Returns the innovation.
  /// Errors: a sample that is not finite changes nothing and returns NaN.
  double update(const Row& x, double y, double noise_sd) {
    const double innovation = y - predict(x);
    if (!std::isfinite(innovation)) return innovation;
    const Row px = times(x);
    const double variance = dot(x, px) + noise_sd * noise_sd;
    if (!(variance > 0)) return innovation;
    const double reach = 3 * std::sqrt(variance);
    const double step = std::clamp(innovation, -reach, reach) / variance;
    for (std::size_t i = 0; i < N; ++i) theta_[i] += px[i] * step;
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) p_[i * N + j] -= px[i] * px[j] / variance;
    }
    return innovation;
  }

  /// Lets a share of the prior's variance return: what is never seen is never less sure than the prior, and what
  /// changed is found again. P = (1 - share) P + share P0.
  void forget(double share) {
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) p_[i * N + j] *= 1 - share;
      p_[i * N + i] += share * prior_variance_[i];
    }
  }

  const Row& theta() const { return theta_; }
  /// Takes coefficient i into its bounds, the others to what is likeliest then: theta += P_i (bound - theta_i) / P_ii.
  void bound(std::size_t i, double low, double high) {
    const double variance = p_[i * N + i];
    const double move = std::clamp(theta_[i], low, high) - theta_[i];
    if (move == 0 || !(variance > 0)) return;
    for (std::size_t j = 0; j < N; ++j) theta_[j] += p_[j * N + i] * move / variance;
    theta_[i] = std::clamp(theta_[i], low, high);
  }
  bool finite() const {
    const auto is_finite = [](double v) { return std::isfinite(v); };
    return std::all_of(theta_.begin(), theta_.end(), is_finite) && std::all_of(p_.begin(), p_.end(), is_finite);
  }

 private:
  static double dot(const Row& a, const Row& b) {
    double sum = 0;
    for (std::size_t i = 0; i < N; ++i) sum += a[i] * b[i];
    return sum;
  }
  Row times(const Row& x) const {
    Row px{};
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) px[i] += p_[i * N + j] * x[j];
    }
    return px;
  }

  Row theta_{};
  std::array<double, N * N> p_{};
  Row prior_variance_{};
};

}  // namespace airside
