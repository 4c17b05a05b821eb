#pragma once
// A reading as the objective "band" takes it: side signals that can be believed, meters and temperatures that the
// validator let through.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "airside/demand/demand_reading.hpp"
#include "airside/demand/zone_signals.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/validation.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Holds what a DemandReading points to, so it must outlive that. Shape: T, of which the site's rooms and meters.
template <Topology T>
class DemandWatch {
 public:
  using L = Layout<T>;
  using Vector = typename Reading<T>::Vector;

  DemandWatch(const ControllerSettings& s, const CycleState<T>& cycle, const Reading<T>& sensed,
              const ValidReading<T>& checked)
      : settings_(s), cycle_(cycle) {
    const Vector& valid = checked.value();
    rooms_ = std::min(static_cast<std::size_t>(rooms_of<T>(s.shape)), max_zones);
    for (std::size_t i = 0; i < rooms_; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      room_[i] = valid(k);
      damper_[i] = within(sensed.damper(k), 0.0, 1.0);
      setpoint_[i] = within(sensed.zone_setpoint_degc(k), 5.0, 45.0);
      heating_[i] = within(sensed.zone_heating_setpoint_degc(k), 5.0, 45.0);
    }
    meters_ = static_cast<std::size_t>(shape_in<T>(s.shape).powers);
    for (std::size_t i = 0; i < meters_; ++i) power_[i] = valid(L::power + static_cast<Eigen::Index>(i));
    reading_.time = checked.time();  // of the row, by which cycles begin: a poll may end seconds later
    // A supply temperature that no sensor shows is its setpoint, once one is known.
    const double supply = within(sensed.supply_temp_degc, 0.0, 50.0);
    reading_.supply_degc = std::isfinite(supply) ? supply : cycle.last_setpoint_degc;
    reading_.outdoor_degc = valid(L::outdoor_temp);
    reading_.flow_m3_s = within(sensed.supply_flow_m3s, 0.0, 1000.0);
    reading_.coldest = cycle.last_setpoint_degc <= s.action_min_degc + 0.05;
    reading_.warmest = cycle.last_setpoint_degc >= s.action_max_degc - 0.05;
  }
  DemandWatch(const DemandWatch&) = delete;
  DemandWatch& operator=(const DemandWatch&) = delete;

  /// `counts`: false where no air flows, or nothing may be learned from the row.
  DemandReading reading(bool counts, bool fan_runs) const {
    DemandReading at = reading_;
    at.zones = {
        {room_.data(), rooms_}, {setpoint_.data(), rooms_}, {damper_.data(), rooms_}, {heating_.data(), rooms_}};
    at.power_kw = {power_.data(), meters_};
    at.flows = counts;
    at.doubted = fan_runs && !counts;
    return at;
  }

  DemandChoice choice(double schedule_degc) const {
    return {.min_degc = settings_.action_min_degc,
            .max_degc = settings_.action_max_degc,
            .step_k = settings_.action_step_k,
            .schedule_degc = schedule_degc,
            .last_degc = cycle_.last_setpoint_degc};
  }

 private:
  static double within(double value, double low, double high) {
    return value >= low && value <= high ? value : std::numeric_limits<double>::quiet_NaN();
  }

  const ControllerSettings& settings_;
  const CycleState<T>& cycle_;
  std::size_t rooms_ = 0, meters_ = 0;
  std::array<double, max_zones> room_{}, setpoint_{}, damper_{}, heating_{};
  std::array<double, static_cast<std::size_t>(std::max(1, T::powers))> power_{};
  DemandReading reading_;
};

}  // namespace airside
