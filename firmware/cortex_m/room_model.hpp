#pragma once
// A room of five zones behind one AHU, in additions, multiplications and divisions alone: the same bits on a host and
// on a microcontroller. It stands in for the bus in the firmware's test; it is no model of a building (sim has those).

#include <array>
#include <cmath>
#include <cstdint>

#include "airside/fault.hpp"
#include "airside/plant.hpp"
#include "airside/splitmix64.hpp"

namespace airside::cortex_m {

/// What is wrong with the sensors and the bus; by row of the scored day, 0..239.
enum class Scenario : std::uint8_t { sound, faulty };

/// Each zone: C dT/dt = flow cp (T_supply - T) + UA (T_outdoor - T) + gains - fan coil, in steps of a minute.
/// Satisfies Plant and Clock: time is what sleep_until() made of it.
class RoomModel {
 public:
  using Topo = FiveZone;
  using L = Layout<Topo>;

  RoomModel(CivilTime start, std::uint64_t seed) : now_(start), noise_(seed) {}

  /// From then on sensors lie as `scenario` has it; its rows count from `day`.
  void begin_day(Scenario scenario, CivilTime day) {
    scenario_ = scenario;
    day_ = day;
  }

  CivilTime now() const { return now_; }
  bool sleep_until(CivilTime t) {
    while (now_ < t) minute();
    return true;
  }
  CivilTime woke() const { return now_; }

  Expected<Reading<Topo>> sense() {
    Reading<Topo> r;
    r.time = now_;
    for (int i = 0; i < L::rooms; ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      r.value(L::room_temp + i) = sensed(zone_degc_[k]);
      r.value(L::fcu_temp + i) = sensed(zone_degc_[k] + 0.3);
      r.value(L::vav_on + i) = occupied() ? 1 : 0;
      r.value(L::fcu_on + i) = coil_on_[k] ? 1 : 0;
    }
    r.value(L::power) = rounded(2.0 + 0.02 * noise_.symmetric());
    r.value(L::power + 1) = rounded(chiller_kw());
    r.value(L::mau_temp) = sensed(14.0 + 0.1 * (outdoor_degc() - 25.0));
    r.value(L::outdoor_temp) = sensed(outdoor_degc());
    r.value(L::rain) = hour() >= 15.0 && hour() < 16.5 ? 1 : 0;
    r.setpoint_degc = setpoint_degc_;
    r.supply_temp_degc = sensed(supply_degc_);
    return scenario_ == Scenario::faulty ? spoiled(r) : Expected<Reading<Topo>>(r);
  }

  Expected<Applied> actuate(const Command& command) {
    constexpr int refused = 174;  // 17:24
    if (scenario_ == Scenario::faulty && row() == refused) return tl::unexpected(Fault::write_refused);
    setpoint_degc_ = command.setpoint_degc();
    return Applied{setpoint_degc_};
  }

  /// Sets the setpoint without a controller, as the schedule did before.
  void set_degc(double setpoint_degc) { setpoint_degc_ = setpoint_degc; }
  double room_mean_degc() const {
    double sum = 0;
    for (const double t : zone_degc_) sum += t;
    return sum / L::rooms;
  }

 private:
  int row() const { return static_cast<int>((now_.seconds - day_.seconds) / row_s); }
  double hour() const { return now_.second_of_day() / 3600.0; }
  bool occupied() const { return hour() >= 6.5 && hour() < 19.5; }
  /// 0 at 7 and 19 h, 1 at 13 h.
  double sun() const {
    const double x = (hour() - 13.0) / 6.0;
    return x > -1.0 && x < 1.0 ? 1.0 - x * x : 0.0;
  }
  double outdoor_degc() const { return 26.0 + 6.0 * sun(); }
  double people() const {
    const double h = hour();
    const double here = h < 8.0 ? 0.0 : h < 9.0 ? h - 8.0 : h < 17.5 ? 1.0 : h < 18.5 ? 18.5 - h : 0.0;
    return h >= 12.0 && h < 13.0 ? 0.5 * here : here;
  }
  double chiller_kw() const {
    const double lift = outdoor_degc() - supply_degc_;
    return 3.0 + 0.8 * (lift > 0 ? lift : 0.0) + 0.05 * noise_.symmetric();
  }
  static double rounded(double value) { return std::round(value * 100.0) / 100.0; }
  double sensed(double value) const { return rounded(value + 0.01 * noise_.symmetric()); }

  void minute() {
    constexpr double minute_h = 1.0 / 60.0;
    constexpr double supply_lag_h = 0.1, capacity_kwh_k = 0.75, mixing_kw_k = 0.1;
    supply_degc_ += (setpoint_degc_ - supply_degc_) * (minute_h / supply_lag_h);
    const double mean = room_mean_degc();
    const double flow_kw_k = occupied() ? 0.55 : 0.15;
    for (std::size_t i = 0; i < zone_degc_.size(); ++i) {
      const double side = 0.8 + 0.1 * static_cast<double>(i);  // the last zone has more sun and more people
      const double gains_kw = 0.25 + side * (0.9 * people() + 0.5 * sun());
      double& t = zone_degc_[i];
      coil_on_[i] = t > (coil_on_[i] ? 25.6 : 26.2);
      const double coil_kw = coil_on_[i] ? 0.5 : 0.0;
      const double heat_kw = flow_kw_k * (supply_degc_ - t) + 0.06 * (outdoor_degc() - t) + mixing_kw_k * (mean - t) +
                             gains_kw - coil_kw + 0.05 * noise_.symmetric();
      t += heat_kw * (minute_h / capacity_kwh_k);
    }
    now_.seconds += 60;
  }

  /// The faulty day: one room without a number, all of them, a sensor that stands still, one that jumps, a power meter
  /// out of range, a fan coil that answers with infinity, and a bus that does not answer.
  Expected<Reading<Topo>> spoiled(Reading<Topo> r) {
    const int at = row();
    const double no_number = std::numeric_limits<double>::quiet_NaN();
    if (at >= 24 && at < 26) r.value(L::room_temp + 1) = no_number;  // two rows: held
    if (at >= 36 && at < 45) r.value(L::room_temp + 1) = no_number;  // longer than anything is held
    if (at >= 54 && at < 60) r.value.setConstant(no_number);
    if (at >= 72 && at < 74) r.value(L::room_temp + 4) += 7.5;  // jumps, and jumps back
    if (at >= 84 && at < 87) r.value(L::power) = 4000;
    if (at >= 93 && at < 96) r.value(L::fcu_temp + 2) = std::numeric_limits<double>::infinity();
    if (at == 100) stuck_degc_ = r.value(L::room_temp + 3);
    if (at >= 100 && at < 192) r.value(L::room_temp + 3) = stuck_degc_;  // stuck, found after six hours
    if (at >= 204 && at < 210) return tl::unexpected(Fault::no_reading);
    return r;
  }

  CivilTime now_;
  CivilTime day_{};
  Scenario scenario_ = Scenario::sound;
  mutable SplitMix64 noise_;
  double setpoint_degc_ = 25.0, supply_degc_ = 25.0, stuck_degc_ = 0;
  std::array<double, 5> zone_degc_{25.6, 25.7, 25.8, 25.9, 26.0};
  std::array<bool, 5> coil_on_{};
};

static_assert(Plant<RoomModel, FiveZone> && Clock<RoomModel>);

}  // namespace airside::cortex_m
