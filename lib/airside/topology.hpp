#pragma once
// The shape of a site: how many VAV boxes, fan coil units and power meters an AHU's controller sees.
// Every matrix of lib takes its size from a topology, a tag type: either the counts of one shape, or a capacity class
// in which any smaller shape finds room. Adding a topology is one struct here and one entry in AIRSIDE_TOPOLOGIES.

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstddef>

namespace airside {

/// The counts of a site: 1 to 32 VAV boxes, 0 to 32 fan coil units, 0 to 8 power meters.
struct Shape {
  static constexpr int max_vavs = 32, max_fcus = 32, max_powers = 8;
  int vavs = 0, fcus = 0, powers = 0;

  /// S, E and A; what a network of exactly this shape takes in.
  constexpr int inputs() const { return 2 * vavs + 2 * fcus + powers + 4; }
  constexpr bool valid() const {
    return vavs >= 1 && vavs <= max_vavs && fcus >= 0 && fcus <= max_fcus && powers >= 0 && powers <= max_powers;
  }
  friend constexpr bool operator==(const Shape&, const Shape&) = default;
};

/// `12vav-0fcu-1power`, as site files have it.
struct ShapeName {
  std::array<char, 24> text{};
  constexpr const char* c_str() const { return text.data(); }
};

constexpr ShapeName name_of(const Shape& shape) {
  ShapeName name;
  std::size_t at = 0;
  const auto number = [&](int n) {
    if (n >= 10) name.text[at++] = static_cast<char>('0' + n / 10 % 10);
    name.text[at++] = static_cast<char>('0' + n % 10);
  };
  const auto word = [&](const char* w) {
    while (*w != '\0') name.text[at++] = *w++;
  };
  number(shape.vavs), word("vav-"), number(shape.fcus), word("fcu-"), number(shape.powers), word("power");
  return name;
}

/// The shape of a name; one that is not valid() for any other text, or for counts out of range.
constexpr Shape parse_shape(const char* text) {
  const auto number = [&text](const char* unit) {
    int n = 0, digits = 0;
    const bool padded = text[0] == '0' && text[1] >= '0' && text[1] <= '9';
    for (; digits < 2 && *text >= '0' && *text <= '9'; ++digits) n = 10 * n + (*text++ - '0');
    while (*unit != '\0' && *text == *unit) ++text, ++unit;
    return digits > 0 && !padded && *unit == '\0' ? n : -1;
  };
  Shape shape;
  shape.vavs = number("vav-");
  if (shape.vavs >= 0) shape.fcus = number("fcu-");
  if (shape.fcus >= 0) shape.powers = number("power");
  return *text == '\0' && shape.valid() ? shape : Shape{};
}

/// A tag type with counts and a name for site files and blobs. `exact`: the counts are those of the site itself;
/// otherwise they are the most that a site may have, and ControllerSettings::shape says which it has.
template <class T>
concept Topology = requires {
  { T::vavs } -> std::convertible_to<int>;
  { T::fcus } -> std::convertible_to<int>;
  { T::powers } -> std::convertible_to<int>;
  { T::exact } -> std::convertible_to<bool>;
  { T::name } -> std::convertible_to<const char*>;
};

/// The method's room: 5 VAV, 5 FCU, 2 power meters; 26 network inputs, 28,773 parameters.
struct FiveZone {
  static constexpr int vavs = 5, fcus = 5, powers = 2;
  static constexpr bool exact = true;
  static constexpr const char* name = "5vav-5fcu-2power";
};

/// A small suite without fan coils.
struct ThreeVav {
  static constexpr int vavs = 3, fcus = 0, powers = 1;
  static constexpr bool exact = true;
  static constexpr const char* name = "3vav-0fcu-1power";
};

/// A wide floor with a few perimeter fan coils.
struct EightVavFourFcu {
  static constexpr int vavs = 8, fcus = 4, powers = 2;
  static constexpr bool exact = true;
  static constexpr const char* name = "8vav-4fcu-2power";
};

/// Any other site of up to 8 boxes, 8 fan coils and 8 power meters.
struct UpTo8 {
  static constexpr int vavs = 8, fcus = 8, powers = Shape::max_powers;
  static constexpr bool exact = false;
  static constexpr const char* name = "up to 8vav-8fcu-8power";
};

/// Any other site.
struct UpTo32 {
  static constexpr int vavs = Shape::max_vavs, fcus = Shape::max_fcus, powers = Shape::max_powers;
  static constexpr bool exact = false;
  static constexpr const char* name = "up to 32vav-32fcu-8power";
};

/// Sizes and positions derived from a topology, in the order of docs/method.md 3.1.
/// The network's input is X = [S rooms | E exogenous | A setpoint]. In a capacity class the slots of each kind beyond
/// the site's count are absent: they hold 0, and their weights are 0.
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

/// The most that topology T holds; of an exact one, what it is.
template <Topology T>
constexpr Shape capacity_of() {
  return {T::vavs, T::fcus, T::powers};
}
template <Topology T>
constexpr bool holds(const Shape& shape) {
  if constexpr (T::exact) return shape == capacity_of<T>();
  return shape.valid() && shape.vavs <= T::vavs && shape.fcus <= T::fcus && shape.powers <= T::powers;
}

/// The shape that a controller of topology T works on: T's own where it is exact, and where the site says nothing.
template <Topology T>
constexpr Shape shape_in(const Shape& site) {
  return holds<T>(site) ? site : capacity_of<T>();
}

/// Numbers of the real rooms and fan coils as Eigen takes a length: known to the compiler where T is exact.
/// `site` here and below is a shape that T holds.
template <Topology T>
constexpr auto rooms_of([[maybe_unused]] const Shape& site) {
  if constexpr (T::exact)
    return Eigen::fix<T::vavs>;
  else
    return site.vavs;
}
template <Topology T>
constexpr auto fcus_of([[maybe_unused]] const Shape& site) {
  if constexpr (T::exact)
    return Eigen::fix<T::fcus>;
  else
    return site.fcus;
}

/// Slot in Layout<T> of a site's input number `index`, counted in the site's own order S E A.
/// Shape: index 0 .. shape.inputs()-1, the last being the setpoint.
template <Topology T>
constexpr int slot_of([[maybe_unused]] const Shape& site, int index) {
  if constexpr (T::exact) return index;
  using L = Layout<T>;
  constexpr std::array<int, 6> begin{L::room_temp, L::fcu_temp, L::vav_on, L::fcu_on, L::power, L::mau_temp};
  const std::array<int, 6> count{site.vavs, site.fcus, site.vavs, site.fcus, site.powers, 4};
  std::size_t kind = 0;
  for (; kind + 1 < count.size() && index >= count[kind]; ++kind) index -= count[kind];
  return begin[kind] + index;
}

/// Whether a slot of Layout<T> belongs to the site.
template <Topology T>
constexpr bool is_present([[maybe_unused]] const Shape& site, int slot) {
  if constexpr (T::exact) return true;
  using L = Layout<T>;
  if (slot >= L::mau_temp) return true;
  if (slot >= L::power) return slot - L::power < site.powers;
  if (slot >= L::fcu_on) return slot - L::fcu_on < site.fcus;
  if (slot >= L::vav_on) return slot - L::vav_on < site.vavs;
  if (slot >= L::fcu_temp) return slot - L::fcu_temp < site.fcus;
  return slot < site.vavs;
}

/// Slot of the power meter that the room head watches, the last one; -1 where the site has none.
template <Topology T>
constexpr int last_power_of(const Shape& site) {
  return site.powers > 0 ? Layout<T>::power + site.powers - 1 : -1;
}

}  // namespace airside
