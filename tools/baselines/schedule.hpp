#pragma once
// The two controllers without feedback: the expert's schedule and a constant setpoint.

#include "tools/baselines/baseline.hpp"

namespace airside::tools {

/// 20.5 degC in working hours, 25 degC outside. Source: docs/method.md 6.3.
class ScheduleBaseline final : public BaselineController {
 public:
  explicit ScheduleBaseline(const ControllerSettings& site) : site_(site) {}
  std::string name() const override { return "expert schedule"; }
  double decide(const CycleObservation& now) override;

 private:
  ControllerSettings site_;
};

/// The same setpoint day and night, degC. Source: docs/results.md, "Peers".
class ConstantBaseline final : public BaselineController {
 public:
  ConstantBaseline(const ControllerSettings& site, double setpoint_degc)
      : setpoint_degc_(admissible_setpoint_degc(setpoint_degc, site)) {}
  std::string name() const override;
  double decide(const CycleObservation&) override { return setpoint_degc_; }

 private:
  double setpoint_degc_;
};

}  // namespace airside::tools
