// Clocks that cannot be right: after a power cut without a battery, set far back, or far ahead and then right.

#include <gtest/gtest.h>

#include "closed_loop/bench.hpp"
#include "firmware/edge/edge.hpp"

namespace airside::fault_matrix {
namespace {

using closed_loop::Bench;

/// A daemon on the machine's clock, whose rows are called one by one.
class ClockDesk : public ::testing::Test {
 protected:
  ClockDesk() {
    bench.start_server();
    hal::SiteFile site = hal::read_site_file(bench.file("site.toml").string(), hal::site_rules());
    site.clock = hal::ClockSource::system;
    const hal::PointMap points = hal::PointMap::load(site.modbus->points);
    edge::EdgeOptions options;
    options.sync = hal::Sync::none;
    options.crash_limit = 0;
    daemon = edge::make_daemon(site, points, options, {});
    daemon->start();
  }
  /// One row at t; whether its clock was believed.
  bool believed(CivilTime t) {
    auto& wired = dynamic_cast<edge::Edge<FiveZone>&>(*daemon);
    const Expected<Reading<FiveZone>> nothing = tl::unexpected(Fault::no_reading);
    EXPECT_TRUE(wired.row(t, nothing, wired.controller()));
    return !wired.controller().cycle().ladder.active(Reason::clock_not_set, t);
  }

  static constexpr CivilTime now{1'795'000'320 / 86400 * 86400};  // a midnight of November 2026
  static constexpr std::int64_t day_s = 86400;
  Bench bench{{.name = "clock", .plant = closed_loop::rc_room(), .expert_days = 1, .days = 1}};
  std::unique_ptr<edge::Daemon> daemon;
};

TEST_F(ClockDesk, Row30AClockOf1970IsNotBelievedAndItsRowsAreNotLogged) {
  for (int row = 0; row < 300; ++row) EXPECT_FALSE(believed({row * row_s})) << row;
  EXPECT_EQ(bench.logged_rows(), 0u);
  EXPECT_TRUE(believed(now)) << "and is followed once it is set";
  EXPECT_EQ(bench.logged_rows(), 1u);
}

TEST_F(ClockDesk, Row30WithoutAClockThatIsRightIsNeverDoubted) {
  for (int row = 0; row < 300; ++row) EXPECT_TRUE(believed({now.seconds + row * row_s})) << row;
  EXPECT_EQ(bench.logged_rows(), 300u);
}

TEST_F(ClockDesk, Row28WithoutAnHourBackOrForthIsFollowed) {
  EXPECT_TRUE(believed(now));
  EXPECT_TRUE(believed({now.seconds + 3600}));
  EXPECT_TRUE(believed({now.seconds + 360}));
}

TEST_F(ClockDesk, Row28AClockThatWasFarAheadIsBelievedADayAfterItWasSetRight) {
  EXPECT_TRUE(believed({now.seconds + 1000 * day_s})) << "nobody can know";
  int doubted = 0;
  for (int row = 0; row < 2 * rows_per_day; ++row) doubted += !believed({now.seconds + row * row_s});
  EXPECT_EQ(doubted, rows_per_day);
}

}  // namespace
}  // namespace airside::fault_matrix
