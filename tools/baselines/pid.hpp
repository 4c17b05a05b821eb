#pragma once
// Feedback on the mean room temperature alone: what a controls engineer tunes in an afternoon.

#include <optional>
#include <string>

#include "tools/baselines/baseline.hpp"

namespace airside::tools {

/// Gains on e = target - Sbar. Positive gains cool when the rooms are hot, since e is negative then.
/// Units: kp K/K, ki 1/h, kd h.
struct PidGains {
  double kp = 1.0;
  double ki_per_h = 0.5;
  double kd_h = 0.1;
  bool operator==(const PidGains&) const = default;
};

constexpr PidGains pid_spec_gains() { return {}; }  ///< Source: docs/method.md 11

/// Positional PID around a fixed offset.
///   A = clamp(22.5 + kp e + ki int(e) dt + kd de/dt)
/// Anti-windup: the integral goes as far as the setpoint's limit and no further.
/// Holds the previous setpoint while no room can be read.
class PidBaseline final : public BaselineController {
 public:
  PidBaseline(const ControllerSettings& site, const PidGains& gains, std::string name = "PID")
      : site_(site), gains_(gains), name_(std::move(name)) {}
  std::string name() const override { return name_; }
  double decide(const CycleObservation& now) override;

  static constexpr double offset_degc = 22.5;

 private:
  ControllerSettings site_;
  PidGains gains_;
  std::string name_;
  double integral_degch_ = 0;
  std::optional<CivilTime> last_time_;
  double last_error_k_ = 0;
};

/// Pure integral action on what was applied, so that nothing can wind up.
///   A = clamp(A_prev + ki e dt)
class IntegralBaseline final : public BaselineController {
 public:
  IntegralBaseline(const ControllerSettings& site, double ki_per_h) : site_(site), ki_per_h_(ki_per_h) {}
  std::string name() const override;
  bool heeds_history() const override { return true; }
  double decide(const CycleObservation& now) override;

 private:
  ControllerSettings site_;
  double ki_per_h_;
  std::optional<CivilTime> last_time_;
};

/// For logs from which a model shall learn what the setpoint does: integral action plus an offset that is drawn anew in
/// every decision, uniform within +-0.4 K, which makes the setpoint as restless as the published peers' (DARV about
/// 0.5). On every fourth day the schedule takes the integral's place, so that its temperatures are in the log too. The
/// draw is of the time alone: the same room gives the same log.
class VariedBaseline final : public BaselineController {
 public:
  VariedBaseline(const ControllerSettings& site, double ki_per_h) : site_(site), integral_(site, ki_per_h) {}
  std::string name() const override { return "integral, setpoint varied"; }
  bool heeds_history() const override { return true; }
  double decide(const CycleObservation& now) override;

 private:
  static constexpr double range_k = 0.4;
  static constexpr int schedule_every_days = 4;

  ControllerSettings site_;
  IntegralBaseline integral_;
  double offset_k_ = 0;
};

}  // namespace airside::tools
