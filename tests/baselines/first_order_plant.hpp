#pragma once
// A crude room: first order toward supply temperature + load, with a daily swing. For signs and convergence
// only.

#include <cmath>
#include <cstdint>
#include <vector>

#include "tools/baselines/baseline.hpp"

namespace airside::tools {

class FirstOrderPlant {
 public:
  explicit FirstOrderPlant(double swing_k = 0.8, std::int64_t start_s = 4 * 86400)
      : swing_k_(swing_k), time_{start_s} {}

  CivilTime time() const { return time_; }
  double mean_degc() const { return mean_degc_; }
  void set_mean_degc(double mean) { mean_degc_ = mean; }
  void set_setpoint(double setpoint_degc) { setpoint_degc_ = setpoint_degc; }
  double setpoint_degc() const { return setpoint_degc_; }

  /// 65 % of the way to its final value in a cycle of three rows.
  void step_row() {
    const double hour = time_.second_of_day() / 3600.0;
    const double load_k = 2.75 + swing_k_ * std::sin((hour - 9) / 24 * 6.283185307179586);
    mean_degc_ += (1 - std::cbrt(0.35)) * (setpoint_degc_ + load_k - mean_degc_);
    time_.seconds += row_s;
  }

  sim::Sensors sensors() const {
    sim::Sensors s;
    for (int i = 0; i < 5; ++i) s.room_temp_degc.push_back(mean_degc_ + 0.1 * (i - 2));
    s.fcu_temp_degc.assign(5, mean_degc_ + 0.5);
    s.vav_on.assign(5, 1.0);
    s.fcu_on.assign(5, 0.0);
    s.power_kw = {1.0, 2.0};
    s.mau_temp_degc = 20;
    s.outdoor_temp_degc = 30;
    s.setpoint_degc = setpoint_degc_;
    return s;
  }

  CycleObservation observe(double target_degc = 25.25) const { return {time_, sensors(), setpoint_degc_, target_degc}; }

 private:
  double swing_k_;
  CivilTime time_;
  double mean_degc_ = 25.25;
  double setpoint_degc_ = 25.0;
};

}  // namespace airside::tools
