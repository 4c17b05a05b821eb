#pragma once
// Guideline 36 as a baseline of studies; the logic is lib's, since the box logs it as a shadow too.

#include "airside/supervision/guideline36.hpp"
#include "tools/baselines/baseline.hpp"

namespace airside::tools {

/// Drives a room by trim and respond: each row of 6 min makes the three steps of 2 min that fell into it, on the
/// requests of its reading.  Source: docs/results.md, "Guideline 36".
class Guideline36Baseline final : public BaselineController {
 public:
  Guideline36Baseline(const ControllerSettings& site, const Guideline36Settings& settings, std::string name)
      : site_(site), settings_(settings), name_(std::move(name)) {}
  std::string name() const override { return name_; }
  int decision_period_s(int) const override { return settings_.period_s; }
  bool keeps_to_site() const override { return settings_.clamp_to_site; }
  double decide(const CycleObservation& now) override {
    return logic_.setpoint_degc(site_, settings_, now.time, now.sensors.room_temp_degc, now.sensors.vav_on,
                                now.sensors.outdoor_temp_degc);
  }

  int requests() const { return logic_.requests(); }  ///< of the last decision

 private:
  ControllerSettings site_;
  Guideline36Settings settings_;
  std::string name_;
  Guideline36 logic_;
};

}  // namespace airside::tools
