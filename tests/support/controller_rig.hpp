#pragma once
// A controller with weights on a steady synthetic room, driven row by row as the loop does it.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>

#include "airside/controller/instances.hpp"
#include "airside/presets.hpp"
#include "support/controller_access.hpp"
#include "support/default_cycle.hpp"

namespace airside {

/// The product's settings with small batches: for days on which learning goes on, but is not what is asked about.
inline ControllerSettings brief_learning() {
  ControllerSettings s = product_settings();
  s.batch = 16;
  s.recent_in_batch = 4;
  return s;
}

class ControllerRig {
 public:
  using T = FiveZone;
  using L = Layout<T>;
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();

  explicit ControllerRig(ControllerSettings settings = product_settings(), CivilTime start = {1'627'862'400})
      : now(start) {
    LimitsTable<T> limits = default_limits<T>();
    for (auto& l : limits) l.stale_s = 1200;
    controller->configure(settings, limits, strict_kernels<float>(), 3);
    SplitMix64 init(5);
    controller->draw_weights(init);
    Scaler<T> scaler;
    scaler.mean.setConstant(25);
    for (int i = L::vav_on; i < L::power; ++i) scaler.mean(i) = 0;
    scaler.mean(L::rain) = 0;
    scaler.mean(L::setpoint) = 23;
    scaler.scale(L::setpoint) = 1.7;
    controller->start(scaler);
  }

  /// What the sensors show now; rooms follow the setpoint a little and swing with the day.
  Reading<T> reading() const {
    Reading<T> r;
    r.time = now;
    r.value.setZero();
    const double swing = 0.3 * std::sin(now.second_of_day() / 86400.0 * 6.2831853) + 0.4 * (setpoint - 23);
    for (int i = 0; i < L::rooms; ++i) r.value(i) = 25.2 + 0.1 * i + swing;
    for (int i = 0; i < T::fcus; ++i) r.value(L::fcu_temp + i) = 25.5 + swing;
    for (int i = 0; i < T::vavs; ++i) r.value(L::vav_on + i) = 1;
    for (int i = 0; i < T::powers; ++i) r.value(L::power + i) = 3.0 + swing;
    r.value(L::mau_temp) = 18;
    r.value(L::outdoor_temp) = 30;
    r.setpoint_degc = setpoint;
    return r;
  }

  using Spoil = std::function<Expected<Reading<T>>(Reading<T>)>;

  /// One 6-min row; at a cycle's start it decides, and the AHU takes or refuses.
  void row(const Spoil& spoil = {}, bool refuses = false) {
    const Expected<Reading<T>> sensed = spoil ? spoil(reading()) : Expected<Reading<T>>(reading());
    if (starts_cycle(now)) {
      const double before = setpoint;
      const auto d = controller->decide(now, sensed);
      const double a = d.command.setpoint_degc();
      EXPECT_TRUE(std::isfinite(a));
      EXPECT_TRUE(a >= controller->settings().limit_min_degc || before < a) << a;
      EXPECT_TRUE(a <= controller->settings().limit_max_degc || before > a) << a;
      EXPECT_LE(std::abs(a - before), controller->settings().limit_change_k + 1e-9);
      if (d.mode == ControlMode::release) {
        controller->absorb(d, tl::unexpected(Fault::released));
      } else if (refuses) {
        controller->absorb(d, tl::unexpected(refusal));
      } else {
        writes += std::abs(a - before) > 1e-9;
        setpoint = std::max(a, lowest_degc);
        controller->absorb(d, Applied{setpoint});
      }
    } else {
      controller->observe(now, sensed);
    }
    now.seconds += row_s;
  }
  /// Rows until `cycles` decisions were made.
  void cycles(int n, const Spoil& spoil = {}, bool refuses = false) {
    for (int i = 0; i < n; ++i) {
      do {
        row(spoil, refuses);
      } while (!starts_cycle(now));
    }
  }

  const Decision& decision() const { return controller->decision(); }
  bool same_weights(const NetworkWeights<T, float>& w) const {
    return std::memcmp(w.values.data(), controller->learning().weights.values.data(), sizeof w.values) == 0;
  }

  std::unique_ptr<Controller<T>> controller = std::make_unique<Controller<T>>();
  CivilTime now;
  double setpoint = 25;
  double lowest_degc = -std::numeric_limits<double>::infinity();  ///< the AHU takes nothing below
  int writes = 0;                                                 ///< setpoints that differ from what stood
  Fault refusal = Fault::not_applied;                             ///< what a refused command comes back as
};

}  // namespace airside
