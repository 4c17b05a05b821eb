#pragma once
// Learning on the box: a bounded number of steps on shadow weights, which replace those in use only if they pass a
// gate.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "airside/fault.hpp"
#include "airside/learning/canary.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/learning/replay_ring.hpp"
#include "airside/memory_size.hpp"
#include "airside/network/learner.hpp"
#include "airside/network/losses.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scratch.hpp"
#include "airside/settings.hpp"
#include "airside/topology.hpp"

namespace airside {

/// What a learner takes of a controller's settings. Shape: T.  Source: docs/method.md 6.5.
template <Topology T>
LearnerSettings<T> learner_settings_of(const ControllerSettings& s) {
  LearnerSettings<T> of;
  of.loss.weights = {s.weight_strb, s.weight_tdb, s.weight_gc, s.weight_rc, s.weight_rec};
  of.loss.gamma = s.gamma;
  of.loss.labels = relation_labels<T>(s.label_vav);
  of.adam = {s.learning_rate, s.adam_beta1, s.adam_beta2, s.adam_epsilon};
  of.sync_every = s.target_sync_steps;
  return of;
}

/// Shape: T. Cost: updates_per_cycle optimiser steps, one evaluation and eight forecasts.
/// Source: docs/method.md 16.3; docs/box-and-safety.md, rows 49, 51, 53.
template <Topology T, class Scalar>
class ShadowTraining {
 public:
  using Learning = LearningState<T, Scalar>;
  using Scratch = NetworkScratch<T, Scalar>;
  using Ring = ReplayRing<T, Scalar>;

  /// Trains a copy and takes it over if it is sound; the weights in use are packed in `scratch` afterwards.
  /// Errors: learning_rejected; weights, moments and target are then those in use, and the moments zero.
  Fault learn(const ControllerSettings& s, const LearnerSettings<T>& learner, Learning& learning, const Ring& replay,
              Scratch& scratch) {
    if (s.updates_per_cycle == 0 || replay.size() == 0) return Fault::none;
    shadow_ = learning.weights;
    for (int i = 0; i < s.updates_per_cycle; ++i) (void)step(s, learner, learning, replay, scratch, shadow_);
    // Weights that are no numbers are refused with or without the gate: nothing could be learned from them.
    const bool sound = s.gate != 0 ? passes(s, learner, learning, replay, scratch) : all_finite(shadow_);
    if (!sound) {
      ++learning.rejected;
      learning.learner.reset(learning.weights);
    } else {
      learning.weights = shadow_;
    }
    pack(learning.weights, scratch.kernels, scratch.packed);
    return sound ? Fault::none : Fault::learning_rejected;
  }

  /// One optimiser step of `weights` on a batch of the replay. Returns the losses before it.
  LossTerms step(const ControllerSettings& s, const LearnerSettings<T>& learner, Learning& learning, const Ring& replay,
                 Scratch& scratch, NetworkWeights<T, Scalar>& weights) {
    const std::size_t wanted = static_cast<std::size_t>(s.batch);
    const int drawn = replay.sample(learning.sampler, {index_.data(), wanted}, s.recent_in_batch);
    int n = 0;
    for (int i = 0; i < drawn; ++i) {
      const std::uint32_t slot = index_[static_cast<std::size_t>(i)];
      if (s.gate == 0 || !held_back(slot)) index_[static_cast<std::size_t>(n++)] = slot;
    }
    if (n == 0) return {};
    return learning.learner.step(weights, replay.view({index_.data(), static_cast<std::size_t>(n)}), learner, scratch);
  }

 private:
  /// Every tenth slot of the ring is never trained on when the gate is on: it judges.
  static constexpr bool held_back(std::uint32_t slot) { return slot % 10 == 9; }

  /// Finite, within the trust region, not worse on the held-back slots than gate_loss_ratio allows, and no wilder on
  /// canary states.
  bool passes(const ControllerSettings& s, const LearnerSettings<T>& learner, const Learning& learning,
              const Ring& replay, Scratch& scratch) {
    if (!all_finite(shadow_) || !trusted(learning.weights, s.trust_ratio)) return false;
    const std::uint32_t held = static_cast<std::uint32_t>(replay.size()) / 10;
    if (held > 0) {
      const std::uint32_t n = std::min<std::uint32_t>(held, 64);
      for (std::uint32_t i = 0; i < n; ++i) index_[i] = 10 * (i * held / n) + 9;
      const auto batch = replay.view({index_.data(), n});
      const double before = learning.learner.evaluate(learning.weights, batch, learner.loss, scratch).strb;
      const double after = learning.learner.evaluate(shadow_, batch, learner.loss, scratch).strb;
      if (!(after <= s.gate_loss_ratio * before + 1e-3)) return false;
    }
    return canary_passes(s, learning, scratch);
  }

  /// ||shadow - weights|| <= ratio ||weights||: one poisoned batch cannot carry them far.
  bool trusted(const NetworkWeights<T, Scalar>& weights, double ratio) const {
    double moved = 0, norm = 0;
    for (std::size_t i = 0; i < weights.values.size(); ++i) {
      const double w = static_cast<double>(weights.values[i]), d = static_cast<double>(shadow_.values[i]) - w;
      moved += d * d;
      norm += w * w;
    }
    return moved <= ratio * ratio * norm;
  }

  /// Sane on canary states, or at least no wilder than the weights in use: else weights that were strange from the
  /// start could never learn their way out.
  bool canary_passes(const ControllerSettings& s, const Learning& learning, Scratch& scratch) {
    pack(learning.weights, scratch.kernels, scratch.packed);
    const double excess_in_use = canary_excess_k<T>(s, learning.scaler, scratch.packed, scratch);
    pack(shadow_, scratch.kernels, scratch.packed);
    const double excess = canary_excess_k<T>(s, learning.scaler, scratch.packed, scratch);
    return std::isfinite(excess) && excess <= excess_in_use;
  }

  NetworkWeights<T, Scalar> shadow_;
  std::array<std::uint32_t, max_batch> index_{};
};

}  // namespace airside
