// A capacity class against a topology of exactly the site's shape: the same room, the same weights, the same decisions.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "airside/controller/cycle.hpp"
#include "airside/controller/history.hpp"
#include "airside/controller/instances.hpp"
#include "sim/rc/rc_plant.hpp"
#include "sim/simulated_plant.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/run/site.hpp"

namespace airside {
namespace {

constexpr CivilTime start{1'627'776'000};  // 2021-08-01

struct Day {
  std::vector<double> setpoints_degc;
  LossTerms losses;
  std::vector<std::byte> blob;
  bool absent_are_zero = true;
};

template <class T>
struct Sink {
  Day& day;
  bool row(CivilTime t, const Expected<Reading<T>>&, const Controller<T>& controller) {
    const Decision& d = controller.decision();
    if (d.time == t) day.setpoints_degc.push_back(d.command.setpoint_degc());
    if (d.time == t && std::isfinite(d.loss.total)) day.losses = d.loss;
    return true;
  }
};

/// Two days in an RC room of the shape, under a controller of topology T that starts from drawn weights.
template <class T>
Day run_in(const Shape& shape) {
  const tools::Site site = tools::built_in_site(name_of(shape).c_str());
  sim::RcPlant model(sim::make_room(shape.vavs, shape.fcus, shape.powers), sim::synthetic_weather(3), start, 5, 25);
  sim::SimulatedPlant<T> plant(model, site.points, shape);
  sim::SimulatedClock clock(model);
  auto controller = std::make_unique<Controller<T>>();
  controller->configure(site.settings, default_limits<T>(), strict_kernels<float>(), 3);
  SplitMix64 draw(11);
  controller->draw_weights(draw);
  Scaler<T> scaler;
  for (int i = 0; i < Layout<T>::signals; ++i) {
    const SignalKind kind = signal_id<T>(i).kind;
    if (is_status(kind) || !is_present<T>(shape, i)) continue;
    scaler.mean(i) = kind == SignalKind::power ? 4 : 25;
  }
  scaler.mean(Layout<T>::setpoint) = 23;
  controller->start(scaler);
  Day day;
  Sink<T> sink{day};
  run_cycles<T>(plant, clock, *controller, sink, start, {start.seconds + 2 * 86400});
  auto payload = std::make_unique<typename WeightBlob<T>::Payload>();
  give_payload<T>(*controller, *payload);
  day.blob.resize(WeightBlob<T>::size(*payload));
  EXPECT_EQ(WeightBlob<T>::encode({}, *payload, day.blob), day.blob.size());
  auto weights = controller->learning().weights;
  for_each_parameter<T>(shape, [&](Layer, int i) { weights.values[static_cast<std::size_t>(i)] = 0; });
  day.absent_are_zero = std::all_of(weights.values.begin(), weights.values.end(), [](float w) { return w == 0; });
  return day;
}

template <class Class, class Exact>
void expect_alike() {
  constexpr Shape shape = capacity_of<Exact>();
  const Day exact = run_in<Exact>(shape), in_class = run_in<Class>(shape);
  ASSERT_EQ(exact.setpoints_degc.size(), 160u);
  ASSERT_EQ(in_class.setpoints_degc.size(), exact.setpoints_degc.size());
  double apart_k = 0, moved_k = 0;
  for (std::size_t i = 0; i < exact.setpoints_degc.size(); ++i) {
    apart_k = std::max(apart_k, std::abs(exact.setpoints_degc[i] - in_class.setpoints_degc[i]));
    moved_k = std::max(moved_k, std::abs(exact.setpoints_degc[i] - exact.setpoints_degc[0]));
  }
  EXPECT_GT(moved_k, 1) << "a controller that rests shows nothing";
  EXPECT_LE(apart_k, 0.011) << "one step of the register, where sums round otherwise";
  EXPECT_NEAR(in_class.losses.total, exact.losses.total, 1e-4 * std::abs(exact.losses.total) + 1e-6);
  EXPECT_TRUE(in_class.absent_are_zero);
  EXPECT_EQ(in_class.blob.size(), exact.blob.size());
  std::printf("%s in \"%s\": setpoints at most %.3f K apart in two days\n", Exact::name, Class::name, apart_k);

  // The same bytes are the weights of either.
  auto of_class = std::make_unique<typename WeightBlob<Class>::Payload>();
  of_class->site = shape;
  EXPECT_TRUE(WeightBlob<Class>::decode(exact.blob, {}, *of_class));
  auto of_exact = std::make_unique<typename WeightBlob<Exact>::Payload>();
  EXPECT_TRUE(WeightBlob<Exact>::decode(in_class.blob, {}, *of_exact));
  std::vector<std::byte> again(exact.blob.size());
  of_class->site = shape;
  ASSERT_EQ(WeightBlob<Class>::encode({}, *of_class, again), again.size());
  EXPECT_EQ(again, exact.blob);
}

TEST(CapacityClass, ControlsAsTheExactTopologyOfTheSameShape) {
  expect_alike<UpTo8, FiveZone>();
  expect_alike<UpTo32, EightVavFourFcu>();
  expect_alike<UpTo32, ThreeVav>();
}

TEST(CapacityClass, RefusesTheBlobOfAnotherShape) {
  const Shape twelve{12, 0, 1};
  const Day day = run_in<UpTo32>(twelve);
  auto payload = std::make_unique<WeightBlob<UpTo32>::Payload>();
  payload->site = twelve;
  EXPECT_TRUE(WeightBlob<UpTo32>::decode(day.blob, {}, *payload));
  for (const Shape other : {Shape{11, 0, 1}, Shape{12, 1, 1}, Shape{12, 0, 2}, Shape{32, 32, 8}}) {
    payload->site = other;
    const auto read = WeightBlob<UpTo32>::decode(day.blob, {}, *payload);
    ASSERT_FALSE(read) << name_of(other).c_str();
    EXPECT_STREQ(read.error().field, "topology_hash");
  }
}

TEST(CapacityClass, SitesWithoutFanCoilsOrPowerMetersAreControlled) {
  for (const Shape shape : {Shape{1, 0, 0}, Shape{2, 0, 3}, Shape{32, 32, 8}}) {
    const Day day = shape.vavs > 8 ? run_in<UpTo32>(shape) : run_in<UpTo8>(shape);
    EXPECT_EQ(day.setpoints_degc.size(), 160u) << name_of(shape).c_str();
    EXPECT_TRUE(day.absent_are_zero);
    for (const double a : day.setpoints_degc) EXPECT_TRUE(a >= 18 && a <= 27) << a;
  }
}

}  // namespace
}  // namespace airside
