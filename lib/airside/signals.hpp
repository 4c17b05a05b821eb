#pragma once
// What each sensed number is: its kind, place and unit. Files (point map, log header, blob) name signals by
// kind and place; the code addresses them by the index of Layout<T>.

#include <cstdint>

#include "airside/topology.hpp"

namespace airside {

/// Kinds of signal, numbers frozen because the units hash of a blob covers them.
enum class SignalKind : std::uint8_t {
  room_temp = 0,     ///< VAV return-air temperature, degC
  fcu_temp = 1,      ///< fan coil return-air temperature, degC
  vav_on = 2,        ///< VAV on (1) or off (0)
  fcu_on = 3,        ///< FCU on (1) or off (0)
  power = 4,         ///< electric power, kW
  mau_temp = 5,      ///< make-up air unit outlet temperature, degC
  outdoor_temp = 6,  ///< outdoor-air temperature at the MAU, degC
  rain = 7,          ///< rain (1) or dry (0)
  setpoint = 8,      ///< supply-air temperature setpoint, degC
};

/// Field name and unit suffix of a kind, as in log headers: `room_temp` and `degc`.
/// Units "" for 0/1 status.
struct SignalText {
  const char* name;
  const char* unit;
};

constexpr SignalText text_of(SignalKind kind) {
  switch (kind) {
    case SignalKind::room_temp: return {"room_temp", "degc"};
    case SignalKind::fcu_temp: return {"fcu_temp", "degc"};
    case SignalKind::vav_on: return {"vav_on", ""};
    case SignalKind::fcu_on: return {"fcu_on", ""};
    case SignalKind::power: return {"power", "kw"};
    case SignalKind::mau_temp: return {"mau_temp", "degc"};
    case SignalKind::outdoor_temp: return {"outdoor_temp", "degc"};
    case SignalKind::rain: return {"rain", ""};
    case SignalKind::setpoint: return {"setpoint", "degc"};
  }
  return {"unknown", ""};
}

/// Whether a kind is a 0/1 status, scaled by its maximum and never standardised (docs/method.md 3.1).
constexpr bool is_status(SignalKind kind) {
  return kind == SignalKind::vav_on || kind == SignalKind::fcu_on || kind == SignalKind::rain;
}

/// Kind and 1-based place of input `index` of topology T; place 0 where there is only one.
struct SignalId {
  SignalKind kind;
  int place;
};

template <Topology T>
constexpr SignalId signal_id(int index) {
  using L = Layout<T>;
  if (index < L::fcu_temp) return {SignalKind::room_temp, index + 1};
  if (index < L::vav_on) return {SignalKind::fcu_temp, index - L::fcu_temp + 1};
  if (index < L::fcu_on) return {SignalKind::vav_on, index - L::vav_on + 1};
  if (index < L::power) return {SignalKind::fcu_on, index - L::fcu_on + 1};
  if (index < L::mau_temp) return {SignalKind::power, index - L::power + 1};
  if (index == L::mau_temp) return {SignalKind::mau_temp, 0};
  if (index == L::outdoor_temp) return {SignalKind::outdoor_temp, 0};
  if (index == L::rain) return {SignalKind::rain, 0};
  return {SignalKind::setpoint, 0};
}

/// Relation label L_j of Table I: the sign that d(sum S')/dX_j must have.
/// `vav_label` is the label of "VAV on" (+1 as printed, -1 as physics has it in cooling).
/// Source: docs/method.md, open point 4.
template <Topology T>
constexpr double relation_label(int index, double vav_label = 1.0) {
  const SignalKind kind = signal_id<T>(index).kind;
  if (kind == SignalKind::vav_on) return vav_label;
  return kind == SignalKind::fcu_on || kind == SignalKind::rain ? -1.0 : 1.0;
}

}  // namespace airside
