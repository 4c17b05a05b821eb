// A site needs room temperatures and the setpoint; what stands in for another signal is said once, and is sane.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "hal/points/point_map.hpp"
#include "hal/points/signal_limits.hpp"
#include "hal/site/site_settings.hpp"
#include "input/program_desk.hpp"

namespace airside::hal {
namespace {

SiteFile site_with(const std::string& lines, const std::string& topology = "5vav-5fcu-2power") {
  return parse_site_text("[site]\nname = \"a\"\ntopology = \"" + topology + "\"\n[stand_in]\n" + lines, "site.toml",
                         site_rules());
}

/// The default map without the rows whose names begin with one of `names`.
PointMap map_without(std::initializer_list<const char*> names) {
  const std::string all = default_point_map(5, 5, 2);
  std::string kept;
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = all.find('\n', at) + 1;
    const std::string line = all.substr(at, end - at);
    bool keep = true;
    for (const char* name : names) keep = keep && !line.starts_with(name);
    if (keep) kept += line;
    at = end;
  }
  return PointMap::parse(kept, "points.csv");
}

template <class Call>
std::string complaint_of(Call&& call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return "no complaint";
}

void expect_all(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
}

TEST(StandIn, IsKnownByTheSignalsOwnNameAndByItsKind) {
  const StandIns in = site_with("rain = 0\npower = 4.0\npower_2 = 7\nvav_on = 1\nfcu_temp_3 = 24.5\n").stand_ins;
  EXPECT_EQ(in.of({SignalKind::rain, 0}), 0.0);
  EXPECT_EQ(in.of({SignalKind::power, 1}), 4.0);
  EXPECT_EQ(in.of({SignalKind::power, 2}), 7.0) << "the signal's own name goes before its kind";
  EXPECT_EQ(in.of({SignalKind::vav_on, 5}), 1.0);
  EXPECT_EQ(in.of({SignalKind::fcu_temp, 3}), 24.5);
  EXPECT_FALSE(in.of({SignalKind::fcu_temp, 2}));
  EXPECT_FALSE(in.of({SignalKind::mau_temp, 0}));
  EXPECT_FALSE(in.of({SignalKind::room_temp, 1}));
  EXPECT_TRUE(site_with("").stand_ins.empty());
}

TEST(StandIn, MisspeltOrForeignIsRefusedWithTheNearestName) {
  expect_all(complaint_of([] { site_with("rian = 0\n"); }),
             {"site.toml:5:1: stand_in.rian", "unknown signal `rian`", "point map", "did you mean `rain`?"});
  expect_all(complaint_of([] { site_with("power_3 = 4\n"); }), {"stand_in.power_3", "unknown signal", "power_"});
  expect_all(complaint_of([] { site_with("fcu_on = 0\n", "3vav-0fcu-1power"); }),
             {"stand_in.fcu_on", "unknown signal"});
  expect_all(complaint_of([] { site_with("rain_0 = 0\n"); }), {"stand_in.rain_0", "did you mean `rain`?"});
}

TEST(StandIn, OfWhatIsControlledOrWrittenIsRefusedWithTheReason) {
  expect_all(complaint_of([] { site_with("room_temp_2 = 25\n"); }),
             {"stand_in.room_temp_2", "sensor in each room", "what is controlled", "remove the line"});
  expect_all(complaint_of([] { site_with("setpoint = 20\n"); }), {"stand_in.setpoint", "what is written"});
}

TEST(StandIn, MustBeANumberOfItsKind) {
  expect_all(complaint_of([] { site_with("rain = 2\n"); }), {"stand_in.rain", "2", "0 to 1"});
  expect_all(complaint_of([] { site_with("mau_temp = 180\n"); }), {"stand_in.mau_temp", "180", "-20 to 60 degc"});
  expect_all(complaint_of([] { site_with("power = \"4\"\n"); }), {"stand_in.power", "without quotes"});
  expect_all(complaint_of([] { site_with("power = nan\n"); }), {"stand_in.power", "nan"});
}

TEST(StandIn, TakesThePlaceOfARowInThePointMap) {
  const PointMap map = map_without({"rain,", "power_", "fcu_"});
  const StandIns all = site_with("rain = 0\npower = 4\nfcu_temp = 25\nfcu_on = 0\n").stand_ins;
  EXPECT_NO_THROW(map.check_topology(5, 5, 2, all));
  const LimitsTable<FiveZone> limits = signal_limits<FiveZone>(map, capacity_of<FiveZone>(), all);
  EXPECT_FALSE(limits[Layout<FiveZone>::power].sensed);
  EXPECT_EQ(limits[Layout<FiveZone>::power].stand_in, 4.0);
  EXPECT_TRUE(limits[Layout<FiveZone>::mau_temp].sensed);
  expect_all(
      complaint_of([&] { map.check_topology(5, 5, 2, site_with("power = 4\nfcu_temp = 25\nfcu_on = 0\n").stand_ins); }),
      {"points.csv", "no point \"rain\", and no stand-in", "add the row", "add `rain = 0` to [stand_in]"});
  EXPECT_THROW(signal_limits<FiveZone>(map), InputError);
}

TEST(StandIn, OfASignalThatHasARowIsRefused) {
  const PointMap map = map_without({"power_2,"});
  expect_all(complaint_of([&] { map.check_topology(5, 5, 2, site_with("rain = 0\npower = 4\n").stand_ins); }),
             {"points.csv:", "column name", "\"rain\" beside the stand-in `rain = 0`", "not both"});
  expect_all(complaint_of([&] { map.check_topology(5, 5, 2, site_with("power_1 = 4\npower_2 = 4\n").stand_ins); }),
             {"\"power_1\" beside the stand-in `power_1 = 4`"});
  expect_all(complaint_of([&] { map.check_topology(5, 5, 2, site_with("power = 4\nvav_on = 1\n").stand_ins); }),
             {"\"vav_on_1\" beside the stand-in `vav_on = 1`"});
  EXPECT_NO_THROW(map.check_topology(5, 5, 2, site_with("power = 4\n").stand_ins)) << "for the one without a row";
}

TEST(StandIn, RoomTemperatureWithoutARowIsRefusedWithoutNamingATableThatCannotHelp) {
  const std::string text = complaint_of([] { map_without({"room_temp_2,"}).check_topology(5, 5, 2); });
  expect_all(text, {"no point \"room_temp_2\"", "a row for it", "room_temp_2a and room_temp_2b"});
  EXPECT_EQ(text.find("[stand_in]"), std::string::npos) << text;
}

TEST(StandIn, IsLeftOutOfTheMapThatASimulatedSiteStartsFrom) {
  const StandIns in = site_with("rain = 0\npower_1 = 4\n").stand_ins;
  const PointMap map = PointMap::parse(default_point_map(5, 5, 2, in), "points.csv");
  EXPECT_EQ(map.find("rain"), nullptr);
  EXPECT_EQ(map.find("power_1"), nullptr);
  EXPECT_NE(map.find("power_2"), nullptr);
  EXPECT_NO_THROW(map.check_topology(5, 5, 2, in));
}

TEST(StandIn, CheckSaysWhatTheSiteLacksAndWhatItCosts) {
  const Desk desk;
  const std::string site = "[site]\nname = \"a\"\ntopology = \"5vav-5fcu-2power\"\n";
  desk.write("whole.toml", site);
  const Outcome whole = desk.run("airside", Desk::split("check whole.toml"));
  EXPECT_EQ(whole.code, 0) << whole.out;
  expect_all(whole.out, {"each signal is sensed"});
  desk.write("site.toml", site + "[stand_in]\nrain = 0\npower = 4\n");
  const Outcome lacking = desk.run("airside", Desk::split("check site.toml"));
  EXPECT_EQ(lacking.code, 0) << lacking.out << lacking.err;
  expect_all(lacking.out,
             {"lacks power_1 to power_2 (4 stands in, ", "rain (0 stands in, ", "of DAE", "±", "study signals"});
}

TEST(StandIn, ExampleOfTheSiteFileIsTakenAsItIs) {
  std::string text = example_site_text("5vav-5fcu-2power");
  const std::size_t at = text.find("# [stand_in]");
  const std::size_t end = text.find("\n\n", at);
  ASSERT_NE(at, std::string::npos);
  std::string block = text.substr(at, end - at), lines;
  for (std::size_t i = 0; i < block.size(); ++i) {
    if (block[i] == '#' && (i == 0 || block[i - 1] == '\n')) {
      ++i;  // and the space behind it
      continue;
    }
    lines += block[i];
  }
  text.replace(at, end - at, lines);
  const SiteFile site = parse_site_text(text, "site.toml", site_rules());
  EXPECT_EQ(site.stand_ins.by_name().size(), 7U);
}

}  // namespace
}  // namespace airside::hal
