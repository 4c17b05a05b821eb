#pragma once
// The only thing that may be written to an AHU, and what the AHU took of it.

namespace airside {

class SafetyEnvelope;

/// A supply-air temperature setpoint that passed the safety envelope, degC.
/// Only SafetyEnvelope makes one, so no other code can reach an actuator.
class Command {
 public:
  constexpr double setpoint_degc() const { return setpoint_degc_; }

 private:
  friend class SafetyEnvelope;
  explicit constexpr Command(double setpoint_degc) : setpoint_degc_(setpoint_degc) {}
  double setpoint_degc_;
};

/// What the AHU really took: the read-back value, or the rounded write where nothing can be read back. degC.
struct Applied {
  double setpoint_degc;
};

}  // namespace airside
