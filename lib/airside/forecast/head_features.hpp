#pragma once
// What the room head sees of an instant: the changes that lead on to the next one.

#include <Eigen/Core>

#include "airside/held_rooms.hpp"
#include "airside/memory_size.hpp"
#include "airside/reading.hpp"
#include "airside/topology.hpp"

namespace airside {

/// The regressors x of one instant. Units: K, counts; power in units of the scaler. Numbers frozen: blobs and saved
/// state hold one coefficient each.
struct HeadFeatures {
  static constexpr int room_change = 0;          ///< of the held value of the rooms in the last cycle
  static constexpr int setpoint_change = 1;      ///< filled in when the next setpoint is known
  static constexpr int fcu_change = 2;           ///< of the mean FCU temperature
  static constexpr int power_change = 3;         ///< of the last power meter
  static constexpr int mau_change = 4;           ///< of the MAU outlet's temperature
  static constexpr int fcus_on_change = 5;       ///< of the number of FCUs that are on
  static constexpr int vavs_on_change = 6;       ///< of the number of VAVs that are on
  static constexpr int closed_room_change = 7;   ///< 2 mean((1 - on) dS)
  static constexpr int supply_mixing = 8;        ///< mean(d on (S - A_before)) / 2
  static constexpr int last_move = 9;            ///< the setpoint change before
  static constexpr int room_change_recent = 10;  ///< over the last 6 min alone, as the following
  static constexpr int supply_mixing_recent = 11;
  static constexpr int fcus_on_change_recent = 12;
  static constexpr int fcu_change_recent = 13;
  static constexpr int count = 14;
  alignas(state_alignment) Eigen::Matrix<double, count, 1> x = Eigen::Matrix<double, count, 1>::Zero();
};

/// The readings that the regressors compare: one cycle ago, one row ago, now.
template <Topology T>
struct HeadInstants {
  using Vector = typename Reading<T>::Vector;
  const Vector& before;
  const Vector& recent;
  const Vector& now;
  double setpoint_before_degc;  ///< applied from `before` until `now`
  double last_move_k;           ///< how much that setpoint differed from the one before it
  const HeldRooms& held;        ///< the rule of what is held at the target
};

/// The regressors of an instant on a site of this shape; the setpoint's coming change is left 0, and so is what the
/// site has no signal for.
template <Topology T>
HeadFeatures head_features(const HeadInstants<T>& at, const Shape& site, double power_scale_kw) {
  using L = Layout<T>;
  HeadFeatures f;
  const auto n = rooms_of<T>(site);
  const auto rooms = at.now.head(n);
  const auto moved = rooms - at.before.head(n);
  const auto on = at.now.segment(L::vav_on, n);
  const auto on_change = on - at.before.segment(L::vav_on, n);
  const auto on_change_recent = on - at.recent.segment(L::vav_on, n);
  const auto to_supply = rooms.array() - at.setpoint_before_degc;
  f.x(HeadFeatures::room_change) = held_change_k<T>(at.held, site, at.before, at.now);
  f.x(HeadFeatures::mau_change) = at.now(L::mau_temp) - at.before(L::mau_temp);
  f.x(HeadFeatures::vavs_on_change) = on_change.sum();
  f.x(HeadFeatures::closed_room_change) = 2.0 * ((1.0 - on.array()) * moved.array()).mean();
  f.x(HeadFeatures::supply_mixing) = 0.5 * (on_change.array() * to_supply).mean();
  f.x(HeadFeatures::last_move) = at.last_move_k;
  f.x(HeadFeatures::room_change_recent) = held_change_k<T>(at.held, site, at.recent, at.now);
  f.x(HeadFeatures::supply_mixing_recent) = 0.5 * (on_change_recent.array() * to_supply).mean();
  const int last_power = last_power_of<T>(site);
  if (last_power >= 0) f.x(HeadFeatures::power_change) = (at.now(last_power) - at.before(last_power)) / power_scale_kw;
  if constexpr (T::fcus > 0) {
    const auto fcus = fcus_of<T>(site);
    if (fcus == 0) return f;
    const auto fcu = at.now.segment(L::fcu_temp, fcus);
    const auto fcu_on = at.now.segment(L::fcu_on, fcus);
    f.x(HeadFeatures::fcu_change) = (fcu - at.before.segment(L::fcu_temp, fcus)).mean();
    f.x(HeadFeatures::fcus_on_change) = (fcu_on - at.before.segment(L::fcu_on, fcus)).sum();
    f.x(HeadFeatures::fcus_on_change_recent) = (fcu_on - at.recent.segment(L::fcu_on, fcus)).sum();
    f.x(HeadFeatures::fcu_change_recent) = (fcu - at.recent.segment(L::fcu_temp, fcus)).mean();
  }
  return f;
}

}  // namespace airside
