#pragma once
// The shape of a room: how many VAV boxes, fan coil units and power meters an AHU's controller sees.
// Every matrix of lib takes its size from one of these tag types; adding a room shape is one struct here and
// one entry in AIRSIDE_TOPOLOGIES.

#include <concepts>

namespace airside {

/// A tag type with the counts of a room and a name for site files and blobs.
template <class T>
concept Topology = requires {
  { T::vavs } -> std::convertible_to<int>;
  { T::fcus } -> std::convertible_to<int>;
  { T::powers } -> std::convertible_to<int>;
  { T::name } -> std::convertible_to<const char*>;
};

/// The method's room: 5 VAV, 5 FCU, 2 power meters; 26 network inputs, 28,773 parameters.
struct FiveZone {
  static constexpr int vavs = 5, fcus = 5, powers = 2;
  static constexpr const char* name = "5vav-5fcu-2power";
};

/// A small suite without fan coils.
struct ThreeVav {
  static constexpr int vavs = 3, fcus = 0, powers = 1;
  static constexpr const char* name = "3vav-0fcu-1power";
};

/// A wide floor with a few perimeter fan coils.
struct EightVavFourFcu {
  static constexpr int vavs = 8, fcus = 4, powers = 2;
  static constexpr const char* name = "8vav-4fcu-2power";
};

/// Sizes and positions derived from a topology, in the order of docs/method.md 3.1.
/// The network's input is X = [S rooms | E exogenous | A setpoint].
template <Topology T>
struct Layout {
  static constexpr int rooms = T::vavs;                                          ///< S: one room temperature a VAV
  static constexpr int exogenous = T::fcus + T::vavs + T::fcus + T::powers + 3;  ///< E
  static constexpr int signals = rooms + exogenous;                              ///< S and E, what is sensed
  static constexpr int inputs = signals + 1;                                     ///< X: S, E and A
  static constexpr int transition = 2 * signals + 1;                             ///< S E A S1 E1

  static constexpr int room_temp = 0;
  static constexpr int fcu_temp = rooms;
  static constexpr int vav_on = fcu_temp + T::fcus;
  static constexpr int fcu_on = vav_on + T::vavs;
  static constexpr int power = fcu_on + T::fcus;
  static constexpr int mau_temp = power + T::powers;
  static constexpr int outdoor_temp = mau_temp + 1;
  static constexpr int rain = outdoor_temp + 1;
  static constexpr int setpoint = rain + 1;
  static_assert(setpoint == signals, "the setpoint follows the sensed signals");
};

}  // namespace airside
