#pragma once
// What a controller remembers from one cycle to the next, in the two pieces in which it is saved.

#include <cstdint>
#include <limits>
#include <span>

#include "airside/civil_time.hpp"
#include "airside/demand/band_objective.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/forecast/residual_features.hpp"
#include "airside/forecast/residual_forecaster.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/memory_size.hpp"
#include "airside/network/learner.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scaler.hpp"
#include "airside/reading.hpp"
#include "airside/splitmix64.hpp"
#include "airside/supervision/envelope.hpp"
#include "airside/supervision/guideline36.hpp"
#include "airside/supervision/mode_arbiter.hpp"
#include "airside/supervision/monitors.hpp"
#include "airside/supervision/validation.hpp"
#include "airside/supervision/write_budget.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Counts up whenever the meaning of a byte of LearningState or CycleState changes, sizes apart: saved state of another
/// number is not read.
constexpr std::uint32_t state_version = 15;

/// What learning has produced: saved as one generation. Plain bytes, no pointers.
template <Topology T, class Scalar>
struct LearningState {
  NetworkWeights<T, Scalar> weights;  ///< in use
  Learner<T, Scalar> learner;         ///< target net, moments, step counter
  RoomHead<T> head;
  ResidualForecaster residual;
  Scaler<T> scaler;
  SplitMix64 sampler;
  std::uint64_t cycles = 0;    ///< decisions taken with these weights' ancestors
  std::uint64_t rejected = 0;  ///< updates that the gate refused
};

/// A controller's large parts as bytes.
template <class Byte>
struct StateBytes {
  std::span<Byte> learning, replay;
};

/// What one row hands to the next. Plain bytes, small: saved every row.
template <Topology T>
struct CycleState {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  Validator<T> validator{};
  ModeArbiter mode_arbiter{};
  DriftMonitor<Layout<T>::rooms> drift{};
  ExcitationMonitor excitation{};
  ScheduleShadowMonitor shadow{};
  OverrideMonitor override_monitor{};
  PersistentCondition supply_ignores{};
  PersistentCondition gain_reversed{};
  PersistentCondition no_confidence{};
  AuthorityMonitor authority{};
  Guideline36 guideline36{};
  BandObjective band{};  ///< of the objective `band`
  WriteBudget budget{};
  alignas(state_alignment)
      typename Reading<T>::Vector last_value = Reading<T>::Vector::Zero();  ///< at the last decision
  alignas(state_alignment)
      typename Reading<T>::Vector row_value = Reading<T>::Vector::Zero();  ///< at the last row in between
  CivilTime last_time;
  CivilTime row_time;
  HeadFeatures features;  ///< of the last decision, its own setpoint change left 0
  ResidualMemory<Layout<T>::rooms> residual{};
  double last_setpoint_degc = unknown;    ///< applied since last_time
  double before_setpoint_degc = unknown;  ///< applied until last_time
  StoredSetpoint stored;                  ///< what may be in the register
  double commanded_degc = unknown;        ///< what was written at last_time, whatever the AHU made of it
  double confidence = 0.5;
  double network_expected_degc = unknown;
  double head_expected_degc = unknown;
  double network_error_k2 = 0.01;  ///< running mean of squared one-cycle errors
  double head_error_k2 = 0.01;
  std::uint64_t contact = 0;         ///< of the last reading, see Reading
  std::int32_t refused_writes = 0;   ///< in a row
  std::int32_t refused_updates = 0;  ///< in a row
  std::int32_t worse_cycles = 0;     ///< working cycles in a row in which the schedule's shadow was closer
  std::int32_t ours = 0;             ///< 1: the last decision was ours and was applied
  std::int32_t usable_cycles = 0;    ///< successive cycles whose readings may be learned from, up to 3
  std::int32_t has_weights = 0;      ///< 0: schedule only
  std::int32_t has_features = 0;     ///< 1: `features` are good
  std::int32_t lost_writes = 0;      ///< in a row, of an AHU that can be read
};

}  // namespace airside
