#pragma once
// The policy of trial and rollback: which weights may come into control, how they are judged there for a day, and what
// happens when they go. No I/O: whoever calls keeps the copy of the weights before, and says what is to be said.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "airside/civil_time.hpp"
#include "airside/controller/blob.hpp"
#include "airside/controller/controller.hpp"
#include "airside/controller/decision.hpp"
#include "airside/controller/weight_exchange.hpp"
#include "airside/controller/weight_payload.hpp"
#include "airside/fault.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/network/network.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/topology.hpp"

namespace airside {

enum class TrialState : std::uint32_t { none = 0, on_trial = 1, confirmed = 2, rolled_back = 3 };

constexpr const char* text_of(TrialState state) {
  switch (state) {
    case TrialState::none: return "none";
    case TrialState::on_trial: return "on trial";
    case TrialState::confirmed: return "confirmed";
    case TrialState::rolled_back: return "rolled back";
  }
  return "unknown";
}

/// What is known of weights that came into control. Plain bytes, part of the durable state.
struct WeightTrialRecord {
  TrialState state = TrialState::none;
  std::uint32_t blob_crc = 0;  ///< of the weights in question
  std::int64_t begun_s = 0;    ///< when they came
  std::int64_t until_s = 0;    ///< before then the trial does not end
  std::uint32_t worse_cycles = 0;
  std::uint32_t tried_cycles = 0;  ///< that these weights predicted while the controller was in control
  double error_sum_k2 = 0;         ///< of those forecasts
  double before_error_k2 = 0;      ///< mean square error of the weights before
  double head_error_sum_k2 = 0;    ///< as error_sum_k2, of their room head; 0 where the room kept its own
  double before_head_error_k2 = 0;
  std::uint32_t tries_back = 0;   ///< rows in which the rollback image could not be read
  std::uint32_t took_head = 0;    ///< whether the room was too young to keep its own
  std::uint32_t had_weights = 0;  ///< whether there were any
  Fault refusal = Fault::none;    ///< why the last blob was refused
  std::array<char, 43> refusal_field{};
  std::uint64_t previous_digest = 0;  ///< of the rollback image; 0: none
};

/// What a row of the trial shows.
enum class TrialVerdict : std::uint8_t {
  goes_on,  ///< or there is no trial
  confirmed,
  no_numbers,
  schedule_is_better,
  gain_turned,
  forecasts_are_bad,
};

/// Why weights go, for the log.
constexpr const char* why_of(TrialVerdict verdict) {
  switch (verdict) {
    case TrialVerdict::goes_on: return "the trial goes on";
    case TrialVerdict::confirmed: return "they are confirmed";
    case TrialVerdict::no_numbers: return "their forecasts are no numbers";
    case TrialVerdict::schedule_is_better: return "the schedule would do better";
    case TrialVerdict::gain_turned: return "rooms answer the wrong way round";
    case TrialVerdict::forecasts_are_bad: return "they foretell the rooms worse than those before, by more than 1 K";
  }
  return "unknown";
}
constexpr bool ends_in_rollback(TrialVerdict verdict) { return verdict > TrialVerdict::confirmed; }

/// How a rollback went.
enum class Rollback : std::uint8_t {
  waits,        ///< the image could not be read and may be the next time; weights on trial are out of use meanwhile
  impossible,   ///< the image is gone, and confirmed weights stay
  done,         ///< the weights before are in use
  not_finite,   ///< those before hold no numbers: the schedule
  to_schedule,  ///< there were none before
  image_gone,   ///< the image is gone, and weights on trial go in any case: the schedule
};

/// Cost: no heap. Shape: T.  Source: docs/box-and-safety.md, rows 44-50 and "Weights that arrive".
template <Topology T>
class WeightTrial {
 public:
  using Learning = LearningState<T, float>;
  using Payload = WeightPayload<T>;

  static constexpr std::int64_t trial_s = seconds_per_day;
  static constexpr double wildest_replay_k = 5.0;  ///< forecasts so far from what the room did are wild
  static constexpr std::uint32_t enough_cycles = 40, few_cycles = 10;
  static constexpr double bad_error_k = 1.0;  ///< forecasts of a cycle that err so, and more than those before, are bad

  /// Checks finite numbers, canary states, forecasts of what this room did, and the head where it would be taken, in
  /// this order.  `work` is memory for one network. Cost: that of Controller::forecast_deviation().
  static BlobError refusal_of(Controller<T>& controller, const Payload& payload, NetworkWeights<T, float>& work) {
    if (const BlobError wrong = BlobCodec<T, NetworkWeights<T, float>::count>::check_values(payload);
        wrong.fault != Fault::none) {
      return wrong;
    }
    std::copy(payload.weights.begin(), payload.weights.end(), work.flat().begin());
    const ForecastDeviation wild = controller.forecast_deviation(payload.scaler, work);
    if (!(wild.canary_k <= 0)) return {Fault::blob_value, "canary states"};
    if (!(wild.replay_k <= wildest_replay_k)) return {Fault::blob_value, "forecasts of what this room did"};
    const typename RoomHead<T>::ConstCovariance covariance(payload.head_covariance.data());
    if (wants_head<T>(controller, payload) && !(canary_excess_k<T>(payload.head_theta, covariance) <= 0)) {
      return {Fault::blob_value, "room head on canary states"};
    }
    return {Fault::none, ""};
  }

  /// Whether the weights in use are worth a rollback image: those on trial themselves are not, the image that was made
  /// before them stays the one.
  static bool needs_image(const WeightTrialRecord& record) { return record.state != TrialState::on_trial; }
  /// Remembers what the image is of.
  static void keep_image(const Controller<T>& controller, std::uint64_t digest, WeightTrialRecord& record) {
    record.previous_digest = digest;
    record.had_weights = controller.cycle().has_weights != 0 ? 1 : 0;
    record.before_error_k2 = controller.cycle().network_error_k2;
    record.before_head_error_k2 = controller.cycle().head_error_k2;
    record.took_head = 0;
  }

  /// Exchanges the weights; their trial begins.
  static void begin(CivilTime t, Controller<T>& controller, const Payload& payload, std::uint32_t blob_crc,
                    WeightTrialRecord& record) {
    const bool head = wants_head<T>(controller, payload);
    exchange_payload<T>(controller, payload);
    record.state = TrialState::on_trial;
    record.begun_s = t.seconds;
    record.until_s = t.seconds + trial_s;
    record.worse_cycles = record.tried_cycles = record.tries_back = 0;
    record.error_sum_k2 = record.head_error_sum_k2 = 0;
    if (head) record.took_head = 1;  // and a second push within the trial does not give the room its own back
    record.blob_crc = blob_crc;
    controller.report(Reason::state_lost, false, t);
  }

  /// Once a row. A trial ends when its day is over and enough of it was predicted by the new weights in control:
  /// neither a day on the schedule nor a clock that was set forward shows anything of them. It ends at once when they
  /// act wildly. What the weights before decided is not held against them.
  static TrialVerdict row(CivilTime t, const Controller<T>& controller, WeightTrialRecord& record) {
    if (record.state != TrialState::on_trial || record.tries_back > 0) return TrialVerdict::goes_on;
    record.begun_s = std::min(record.begun_s, t.seconds);
    record.until_s = std::min(record.until_s, t.seconds + trial_s);  // no clock makes it longer
    const Decision& d = controller.decision();
    if (d.time.seconds <= record.begun_s) return TrialVerdict::goes_on;
    if (control_cycle(controller.settings()).starts(t)) count(d, record);
    if (d.fault == Fault::forecast_invalid) return TrialVerdict::no_numbers;
    constexpr std::uint32_t patience = 3;
    if (record.worse_cycles >= patience) return TrialVerdict::schedule_is_better;
    if (d.reason == Reason::gain_reversed &&
        controller.cycle().mode_arbiter.since_s(Reason::gain_reversed) >= record.begun_s) {
      return TrialVerdict::gain_turned;
    }
    if (record.tried_cycles >= few_cycles &&
        (is_bad(mean(record.error_sum_k2, record), record.before_error_k2) ||
         is_bad(mean(record.head_error_sum_k2, record), record.before_head_error_k2))) {
      return TrialVerdict::forecasts_are_bad;
    }
    if (t.seconds < record.until_s || record.tried_cycles < enough_cycles) return TrialVerdict::goes_on;
    record.state = TrialState::confirmed;
    return TrialVerdict::confirmed;
  }

  /// Root mean square error of the forecasts on trial, the larger of network and head, K.
  static double error_k(const WeightTrialRecord& record) {
    return std::sqrt(std::max(mean(record.error_sum_k2, record), mean(record.head_error_sum_k2, record)));
  }

  /// Takes weights back. `image`: those before, nullptr where they cannot be read, which `may_pass` within
  /// `patience` rows. Errors: as the result says; what is damaged changes nothing.
  static Rollback roll_back(Controller<T>& controller, const Learning* image, bool may_pass, std::uint32_t patience,
                            WeightTrialRecord& record) {
    const bool is_missing = image == nullptr && record.had_weights != 0;
    if (is_missing && may_pass && record.tries_back < patience) {
      ++record.tries_back;
      if (record.state == TrialState::on_trial) controller.drop_weights();  // those that go are not asked any more
      return Rollback::waits;
    }
    record.tries_back = 0;
    if (is_missing && record.state == TrialState::confirmed) return Rollback::impossible;
    const bool is_finite = image == nullptr || controller.roll_back(*image) == Fault::none;
    if (record.had_weights == 0 || is_missing) controller.drop_weights();  // which asks for no image
    controller.take_forecast_errors(record.before_error_k2, record.before_head_error_k2);
    record.state = TrialState::rolled_back;
    if (is_missing) return Rollback::image_gone;
    if (!is_finite) return Rollback::not_finite;
    return record.had_weights == 0 ? Rollback::to_schedule : Rollback::done;
  }

 private:
  static double mean(double sum_k2, const WeightTrialRecord& record) {
    return sum_k2 / std::max<std::uint32_t>(record.tried_cycles, 1U);
  }
  static bool is_bad(double error_k2, double before_k2) {
    return error_k2 > bad_error_k * bad_error_k && error_k2 > before_k2;
  }

  static void count(const Decision& d, WeightTrialRecord& record) {
    const bool worse = d.reason == Reason::worse_than_schedule || d.reason == Reason::worse_for_long;
    record.worse_cycles = worse ? record.worse_cycles + 1 : 0;
    if (d.mode > ControlMode::run || !std::isfinite(d.network_error_k)) return;
    ++record.tried_cycles;
    record.error_sum_k2 += d.network_error_k * d.network_error_k;
    if (record.took_head != 0 && std::isfinite(d.head_error_k)) {
      record.head_error_sum_k2 += d.head_error_k * d.head_error_k;
    }
  }
};

}  // namespace airside
