#pragma once
// One optimiser step at a time: losses and gradient of a batch, Adam, and a target network that follows in jumps.

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "airside/network/adam.hpp"
#include "airside/network/gradient.hpp"
#include "airside/network/losses.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scratch.hpp"
#include "airside/topology.hpp"

namespace airside {

template <Topology T>
struct LearnerSettings {
  LossSettings<T> loss;
  AdamSettings adam;
  int sync_every = 100;  ///< optimiser steps from one copy of the target to the next (docs/method.md, open point 11)
};

/// Target network, Adam's moments and the count of steps; the weights themselves are the caller's.
/// Plain data without padding: saved byte for byte.
template <Topology T, class Scalar>
class Learner {
 public:
  using Weights = NetworkWeights<T, Scalar>;
  using Scratch = NetworkScratch<T, Scalar>;
  using Batch = BatchView<T, Scalar>;
  using Row = std::span<const Scalar, static_cast<std::size_t>(Layout<T>::transition)>;

  /// theta- <- theta, moments 0, step 0.
  void reset(const Weights& weights) {
    target_ = weights;
    adam_.first_moment.values.fill(0);
    adam_.second_moment.values.fill(0);
    adam_.steps = 0;
    adam_.beta1_power = adam_.beta2_power = 1;
  }

  /// One Adam step on `weights`; after every sync_every-th step theta- <- theta. An empty batch changes nothing.
  /// Returns the losses before the update.
  /// Cost: see batch_gradient(); stack < 4 KB.
  LossTerms step(Weights& weights, const Batch& batch, const LearnerSettings<T>& settings, Scratch& scratch) {
    if (batch.size <= 0) return {};
    const LossTerms losses = batch_gradient(weights, target_, batch, settings.loss, scratch);
    adam_.update(weights, scratch.gradient, settings.adam, scratch.kernels);
    if (settings.sync_every > 0 && adam_.steps % static_cast<std::uint64_t>(settings.sync_every) == 0)
      target_ = weights;
    return losses;
  }

  /// Losses of the batch without learning from it.
  LossTerms evaluate(const Weights& weights, const Batch& batch, const LossSettings<T>& settings,
                     Scratch& scratch) const {
    if (batch.size <= 0) return {};
    return batch_losses(weights, target_, batch, settings, scratch);
  }

  /// Losses of one transition [S E A S1 E1], for the confidence.
  LossTerms loss_of(const Weights& weights, Row row, const LossSettings<T>& settings, Scratch& scratch) const {
    return batch_losses(weights, target_, Batch{row.data(), nullptr, 1}, settings, scratch);
  }

  Weights& target() { return target_; }
  const Weights& target() const { return target_; }
  Weights& first_moment() { return adam_.first_moment; }
  const Weights& first_moment() const { return adam_.first_moment; }
  Weights& second_moment() { return adam_.second_moment; }
  const Weights& second_moment() const { return adam_.second_moment; }
  std::uint64_t steps() const { return adam_.steps; }

 private:
  Weights target_;
  AdamState<T, Scalar> adam_;
};

static_assert(std::is_trivially_copyable_v<Learner<FiveZone, float>>);
static_assert(sizeof(Learner<FiveZone, float>) == 3 * sizeof(NetworkWeights<FiveZone, float>) + 64);

}  // namespace airside
