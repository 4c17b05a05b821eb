// Scaling: floors against quiet signals, one scale for all rooms, status left alone (docs/method.md, open point 3).

#include "airside/network/scaler.hpp"
#include "airside/presets.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace airside {
namespace {

using T = FiveZone;
using L = Layout<T>;
using Vector = Reading<T>::Vector;

Scaler<T> fitted(const std::function<Vector(int)>& row, int rows = 240) {
  ScalerFit<T> fit;
  for (int i = 0; i < rows; ++i) fit.add(row(i));
  EXPECT_EQ(fit.count(), static_cast<std::uint64_t>(rows));
  return fit.fit(paper_settings());
}

TEST(Scaler, SharesOneScaleAmongTheRooms) {
  const auto s = fitted([](int i) {
    Vector v = Vector::Zero();
    for (int r = 0; r < L::rooms; ++r) v(r) = 24 + r + (i % 2 == 0 ? 1.0 : -1.0);
    return v;
  });
  // Mean 26; variance 1 within each room and 2 between them.
  for (int r = 0; r < L::rooms; ++r) {
    EXPECT_NEAR(s.mean(r), 26, 1e-9);
    EXPECT_NEAR(s.scale(r), std::sqrt(3.0), 1e-9);
  }
}

TEST(Scaler, HasFloorsForQuietSignals) {
  const auto s = fitted([](int) {
    Vector v = Vector::Zero();
    v.head<L::rooms>().setConstant(25);
    v(L::power) = 40;       // 5 % of the mean: 2 kW
    v(L::power + 1) = 0.1;  // at least 0.05 kW
    v(L::outdoor_temp) = 31;
    return v;
  });
  EXPECT_EQ(s.scale(0), 0.5);
  EXPECT_EQ(s.scale(L::outdoor_temp), 0.5);
  EXPECT_EQ(s.mean(L::outdoor_temp), 31);
  EXPECT_NEAR(s.scale(L::power), 2.0, 1e-12);
  EXPECT_NEAR(s.scale(L::power + 1), 0.05, 1e-12);
}

TEST(Scaler, TakesTheSpreadWhereThereIsOne) {
  const auto s = fitted([](int i) {
    Vector v = Vector::Zero();
    v(L::outdoor_temp) = i % 2 == 0 ? 26 : 34;
    return v;
  });
  EXPECT_NEAR(s.mean(L::outdoor_temp), 30, 1e-9);
  EXPECT_NEAR(s.scale(L::outdoor_temp), 4, 1e-9);
}

TEST(Scaler, LeavesStatusAlone) {
  const auto s = fitted([](int i) {
    Vector v = Vector::Zero();
    v(L::vav_on) = i % 3 == 0;
    v(L::rain) = 1;
    return v;
  });
  for (int i = 0; i < L::signals; ++i) {
    if (!is_status(signal_id<T>(i).kind)) continue;
    EXPECT_EQ(s.mean(i), 0);
    EXPECT_EQ(s.scale(i), 1);
  }
}

TEST(Scaler, ScalesTheSetpointByTheRangeItMayHave) {
  const auto s = fitted([](int) { return Vector(Vector::Zero()); });
  EXPECT_EQ(s.mean(L::setpoint), 23);
  EXPECT_NEAR(s.scale(L::setpoint), 6 / std::sqrt(12.0), 1e-12);
  EXPECT_NEAR(s.setpoint<double>(26), std::sqrt(3.0), 1e-12);
}

TEST(Scaler, IsUsableAfterOneRowAndAfterNone) {
  EXPECT_TRUE(fitted([](int) { return Vector(Vector::Constant(7)); }, 1).finite());
  EXPECT_TRUE(ScalerFit<T>().fit(paper_settings()).finite());
}

TEST(Scaler, IsNotFiniteWithAScaleOfZeroOrLess) {
  Scaler<T> s;
  EXPECT_TRUE(s.finite());
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    Scaler<T> broken;
    broken.scale(3) = bad;
    EXPECT_FALSE(broken.finite()) << bad;
  }
}

}  // namespace
}  // namespace airside
