#pragma once
// What was decided in one cycle and why: everything a log row, a status page or a person needs.

#include <cmath>
#include <cstdint>
#include <limits>

#include "airside/civil_time.hpp"
#include "airside/command.hpp"
#include "airside/fault.hpp"
#include "airside/losses.hpp"

namespace airside {

/// Rungs of the ladder, numbers frozen. Every fault inside lib ends at the schedule, since a cycle always yields a
/// command; `release` is the AHU's own step once nothing reaches it. Source: RELIABILITY "The ladder".
enum class Mode : std::uint8_t {
  learn = 0,    ///< control and learn
  run = 1,      ///< control with frozen weights
  expert = 2,   ///< the schedule
  release = 3,  ///< nothing is written; never the mode of a decision
};

constexpr const char* text_of(Mode mode) {
  switch (mode) {
    case Mode::learn: return "learn";
    case Mode::run: return "run";
    case Mode::expert: return "expert";
    case Mode::release: return "release";
  }
  return "unknown";
}

/// One decision. Units: degC, losses in scaled units. Numbers that do not exist this time are NaN.
struct Decision {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  CivilTime time;
  Command command;
  Mode mode = Mode::expert;
  Fault fault = Fault::none;
  int fault_signal = -1;  ///< index in Layout<T> of the signal that caused the fault, or -1
  double room_mean_degc = none;
  double network_degc = none;        ///< the network's choice, A_highest
  double head_degc = none;           ///< the room head's choice
  double expert_degc = none;         ///< the schedule
  double confidence = none;          ///< c_t before it is made effective
  double head_share = none;          ///< weight of the head against the network
  double expected_mean_degc = none;  ///< room mean forecast for the end of the cycle, at the applied setpoint
  LossTerms loss{none, none, none, none, none, none};  ///< of the transition that just ended
};

}  // namespace airside
