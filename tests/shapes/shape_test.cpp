// Shapes: names, slots, and which topology a site gets.

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <type_traits>

#include "airside/network/network.hpp"
#include "airside/signals.hpp"
#include "airside/topologies.hpp"
#include "airside/topology.hpp"

namespace airside {
namespace {

/// A topology of exactly this shape that no build has; what a class must be like.
struct TwelveVav {
  static constexpr int vavs = 12, fcus = 3, powers = 1;
  static constexpr bool exact = true;
  static constexpr const char* name = "12vav-3fcu-1power";
};

TEST(Shape, EveryNameReadsBackAsItsCounts) {
  int shapes = 0;
  for (int vavs = 1; vavs <= Shape::max_vavs; ++vavs) {
    for (int fcus = 0; fcus <= Shape::max_fcus; ++fcus) {
      for (int powers = 0; powers <= Shape::max_powers; ++powers) {
        const Shape shape{vavs, fcus, powers};
        ASSERT_EQ(parse_shape(name_of(shape).c_str()), shape) << name_of(shape).c_str();
        ++shapes;
      }
    }
  }
  EXPECT_EQ(shapes, 32 * 33 * 9);
}

TEST(Shape, TextsThatAreNoShapeAreNotValid) {
  for (const char* text : {"", "vav", "5vav", "5vav-5fcu", "5vav-5fcu-2powers", "5vav-5fcu-2power ",
                           " 5vav-5fcu-2power", "0vav-5fcu-2power", "33vav-0fcu-0power", "5vav-33fcu-2power",
                           "5vav-5fcu-9power", "05vav-5fcu-2power", "5vav-05fcu-2power", "-5vav-5fcu-2power",
                           "5VAV-5FCU-2POWER", "105vav-5fcu-2power", "5vav5fcu2power", "up to 8vav-8fcu-8power"}) {
    EXPECT_FALSE(parse_shape(text).valid()) << text;
  }
}

TEST(Shape, KnownShapesKeepTheirOwnTopologyAndOthersGetTheSmallestClass) {
  const auto topology_of = [](const char* name) {
    std::string found;
    with_topology(name, [&]<class T>(T) { found = T::name; });
    return found;
  };
  EXPECT_EQ(topology_of("5vav-5fcu-2power"), FiveZone::name);
  EXPECT_EQ(topology_of("3vav-0fcu-1power"), ThreeVav::name);
  EXPECT_EQ(topology_of("8vav-4fcu-2power"), EightVavFourFcu::name);
  EXPECT_EQ(topology_of("5vav-5fcu-3power"), UpTo8::name);
  EXPECT_EQ(topology_of("1vav-0fcu-0power"), UpTo8::name);
  EXPECT_EQ(topology_of("9vav-0fcu-0power"), UpTo32::name);
  EXPECT_EQ(topology_of("32vav-32fcu-8power"), UpTo32::name);
  EXPECT_EQ(topology_of("33vav-0fcu-0power"), "");
}

template <class T, class Exact>
void expect_slots_of() {
  constexpr Shape site = capacity_of<Exact>();
  ASSERT_EQ(site.inputs(), Layout<Exact>::inputs);
  std::set<int> slots;
  for (int i = 0; i < site.inputs(); ++i) {
    const int slot = slot_of<T>(site, i);
    slots.insert(slot);
    EXPECT_TRUE(is_present<T>(site, slot));
    const SignalId id = signal_id<T>(slot), own = signal_id<Exact>(i);
    EXPECT_EQ(id.kind, own.kind) << i;
    EXPECT_EQ(id.place, own.place) << i;
  }
  int present = 0;
  for (int slot = 0; slot < Layout<T>::inputs; ++slot) present += is_present<T>(site, slot) ? 1 : 0;
  EXPECT_EQ(static_cast<int>(slots.size()), site.inputs());
  EXPECT_EQ(present, site.inputs());
  EXPECT_EQ(last_power_of<T>(site), slot_of<T>(site, last_power_of<Exact>(site)));
}

TEST(Shape, SlotsOfAClassAreTheSignalsOfTheExactTopology) {
  expect_slots_of<UpTo8, FiveZone>();
  expect_slots_of<UpTo32, FiveZone>();
  expect_slots_of<UpTo32, ThreeVav>();
  expect_slots_of<UpTo32, EightVavFourFcu>();
  expect_slots_of<UpTo32, TwelveVav>();
  EXPECT_EQ(last_power_of<UpTo32>({4, 0, 0}), -1);
}

template <class T, class Exact>
void expect_parameters_of() {
  constexpr Shape site = capacity_of<Exact>();
  using Own = NetworkWeights<Exact, float>;
  EXPECT_EQ(parameters_of<T>(site), Own::count);
  SplitMix64 same(7), other(7);
  auto own = std::make_unique<Own>();
  auto in_class = std::make_unique<NetworkWeights<T, float>>();
  initialise_uniform(*own, same);
  initialise_uniform(*in_class, other, site);
  std::size_t at = 0;
  for_each_parameter<T>(site, [&](Layer, int i) {
    EXPECT_EQ(in_class->values[static_cast<std::size_t>(i)], own->values[at]) << at;
    in_class->values[static_cast<std::size_t>(i)] = 0;
    ++at;
  });
  EXPECT_EQ(at, static_cast<std::size_t>(Own::count));
  for (const float left : in_class->values) EXPECT_EQ(left, 0.0f);
}

TEST(Shape, NetworkOfAClassDrawsTheWeightsOfTheExactOneAndNoOthers) {
  expect_parameters_of<UpTo8, FiveZone>();
  expect_parameters_of<UpTo32, EightVavFourFcu>();
  expect_parameters_of<UpTo32, TwelveVav>();
}

}  // namespace
}  // namespace airside
