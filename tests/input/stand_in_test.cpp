// A site needs room temperatures and the setpoint; what stands in for another signal is said once, and is sane.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>

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
  expect_all(whole.out, {"each input of the forecast is sensed"});
  desk.write("site.toml", site + "[stand_in]\nrain = 0\npower = 4\n");
  const Outcome lacking = desk.run("airside", Desk::split("check site.toml"));
  EXPECT_EQ(lacking.code, 0) << lacking.out << lacking.err;
  expect_all(lacking.out, {"power_1 to power_2: for ", "; 4 stands in; cost: ", "rain: for ",
                           "; 0 stands in; cost: nothing measurable", "of DAE", "±", "study signals"});
}

/// A site of three boxes with Modbus whose map has but the rows of `kept`.
void write_bare(const Desk& desk, const std::string& words, std::initializer_list<const char*> kept) {
  desk.make("init . " + words);
  std::istringstream all(text_of_file(desk.path("points.csv")));
  std::string rows;
  for (std::string line; std::getline(all, line);) {
    for (const char* name : kept) {
      if (line.starts_with(name)) rows += line + "\n";
    }
  }
  desk.write("points.csv", rows);
}

constexpr std::initializer_list<const char*> bare_rows = {"#", "name,", "room_temp_", "outdoor_temp,", "setpoint,"};

TEST(StandIn, CheckSaysOfEverySignalOfABareSiteWhatItIsForWhatStandsInAndWhatItCosts) {
  const Desk desk;
  write_bare(desk, "--topology 3vav-0fcu-1power", bare_rows);
  const std::string site = text_of_file(desk.path("site.toml"));
  desk.write("site.toml", site + "[stand_in]\nvav_on = 1\npower_1 = 4\nmau_temp = 18\nrain = 0\n");
  const Outcome bare = desk.run("airside", Desk::split("check site.toml"));
  EXPECT_EQ(bare.code, 0) << bare.out << bare.err;
  expect_all(bare.out,
             {"objective mean: holds 25.25 degC", "\n       vav_on_1 to vav_on_3: for", "\n       power_1: for",
              "\n       mau_temp: for", "\n       rain: for", "\n       ahu_on: for whether the fan runs", "fan_start",
              "\n       supply_temp: for", "\n       supply_flow: for", "\n       occupied: for",
              "\n       damper_1 to damper_3: for", "\n       zone_setpoint_1 to zone_setpoint_3: for",
              "\n       zone_heating_setpoint_1 to zone_heating_setpoint_3: for"});
  const Outcome as_json = desk.run("airside", Desk::split("check site.toml --json"));
  const auto said = nlohmann::json::parse(as_json.out);
  ASSERT_EQ(said["missing_signals"].size(), 11U) << said;
  for (const auto& m : said["missing_signals"]) {
    for (const char* key : {"names", "use", "instead", "cost"}) EXPECT_FALSE(m[key].get<std::string>().empty()) << m;
  }
  EXPECT_EQ(said["missing_signals"][1]["names"], "power_1");
  EXPECT_EQ(said["missing_signals"][1]["stand_in"], 4);
  desk.write("site.toml",
             hal::replaced(text_of_file(desk.path("site.toml")), "fan_end = \"24:00\"", "fan_end = \"20:00\""));
  expect_all(desk.run("airside", Desk::split("check site.toml")).out, {"the hours of [ahu] stand in, 00:00 to 20:00"});
}

TEST(StandIn, CheckOfABandSiteSaysTheObjectiveWhatItNeedsAndHowTheColdSideIsJudged) {
  const Desk desk;
  write_bare(desk, "--objective band --topology 3vav-0fcu-1power",
             {"#", "name,", "room_temp_", "vav_on_", "mau_temp,", "rain,", "outdoor_temp,", "setpoint,", "supply_temp,",
              "power_1,", "damper_", "zone_setpoint_"});
  const Outcome o = desk.run("airside", Desk::split("check site.toml"));
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  expect_all(o.out, {"objective band: least energy", "damper_n, zone_setpoint_n", "without weights",
                     "zone_heating_setpoint_1 to zone_heating_setpoint_3: for", "some 3 K below the cooling setpoint",
                     "no zone counts as too cold"});
  EXPECT_EQ(o.out.find("holds 25.25"), std::string::npos) << o.out;
}

TEST(StandIn, CheckOfABandSiteSaysWhatAMissingMeterBesideOthersCosts) {
  const Desk desk;
  write_bare(desk, "--objective band --topology 3vav-0fcu-2power",
             {"#", "name,", "room_temp_", "outdoor_temp,", "setpoint,", "supply_temp,", "power_1,", "damper_",
              "zone_setpoint_"});
  desk.write("site.toml",
             text_of_file(desk.path("site.toml")) + "[stand_in]\nvav_on = 1\npower_2 = 4\nmau_temp = 18\nrain = 0\n");
  const Outcome o = desk.run("airside", Desk::split("check site.toml"));
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  expect_all(o.out,
             {"\n       power_2: for electric power, from which band learns what a setpoint costs", "4 stands in",
              "reports have no energy of it", "% without the meter of cooling", "% without the fan's"});
}

TEST(StandIn, AMissingMeterOfABandSiteIsAskedForByEveryProgramAndNoStandInIsAdvised) {
  const Desk desk;
  write_bare(desk, "--objective band --topology 3vav-0fcu-1power",
             {"#", "name,", "room_temp_", "outdoor_temp,", "setpoint,", "supply_temp,", "damper_", "zone_setpoint_",
              "vav_on_", "mau_temp,", "rain,"});
  for (const char* stand_in : {"", "[stand_in]\npower_1 = 4\n"}) {
    const std::string site = text_of_file(desk.path("site.toml"));
    desk.write("with.toml", site + stand_in);
    for (const auto& [program, words] :
         {std::pair{"airside", "check with.toml"}, std::pair{"airside", "pretrain --site with.toml"},
          std::pair{"airsided", "--check --site with.toml"}}) {
      const Outcome o = desk.run(program, Desk::split(words));
      EXPECT_EQ(o.code, 1) << words;
      const std::string said = o.out + o.err;
      expect_all(said, {"with.toml: [controller] objective", "\"band\"", "points.csv without power_1;",
                        "for which [stand_in] cannot stand in", "objective = \"mean\""});
      EXPECT_EQ(said.find("add `power_1"), std::string::npos) << said;
    }
  }
  const Outcome init = desk.run("airside", Desk::split("init x --objective band --topology 3vav-0fcu-0power"));
  EXPECT_EQ(init.code, 1);
  expect_all(init.err, {"--topology", "3vav-0fcu-0power", "at least one power meter", "5vav-0fcu-1power"});
}

TEST(StandIn, SeveralMissingSignalsAreNamedAtOnceWithABlockThatCanBeCopied) {
  const PointMap map = map_without({"power_", "vav_on_2", "vav_on_3", "rain,", "fcu_temp_"});
  const std::string said = complaint_of([&] { map.check_topology(5, 5, 2); });
  expect_all(said,
             {"\"fcu_temp_1\" to \"fcu_temp_5\", \"vav_on_2\" to \"vav_on_3\", \"power_1\" to \"power_2\", \"rain\"",
              "no stand-in for them", "a row for each"});
  std::string block;  // what stands between backticks, as a person copies it
  const std::string remedy = said.substr(said.find("add the row"));
  for (std::size_t at = remedy.find('`'); at != std::string::npos; at = remedy.find('`', at)) {
    const std::size_t end = remedy.find('`', at + 1);
    const std::string line = remedy.substr(at + 1, end - at - 1);
    if (line.find(" = ") != std::string::npos) block += line + "\n";
    at = end + 1;
  }
  EXPECT_EQ(block, "fcu_temp = 25\nvav_on = 1\npower = 4\nrain = 0\n");
  EXPECT_NO_THROW(map.check_topology(5, 5, 2, site_with(block).stand_ins));
}

TEST(StandIn, OneOfSeveralThatHasAStandInIsNotAskedForAgain) {
  const PointMap map = map_without({"power_1", "mau_temp,", "rain,"});
  const std::string said = complaint_of([&] { map.check_topology(5, 5, 2, site_with("mau_temp = 18\n").stand_ins); });
  expect_all(said, {"no point \"power_1\", \"rain\", and no stand-in for them", "`power = 4`, `rain = 0`"});
  EXPECT_EQ(said.find("mau_temp"), std::string::npos) << said;
}

TEST(StandIn, PretrainOfABandSiteSaysThatItIsNotNeeded) {
  const Desk desk;
  desk.make("init . --objective band");
  const Outcome text = desk.run("airside", Desk::split("pretrain --site site.toml -o site.blob"));
  EXPECT_EQ(text.code, 0) << text.err;
  expect_all(text.out, {"not needed", "learns on the box"});
  EXPECT_FALSE(fs::exists(desk.path("site.blob")));
  const Outcome as_json = desk.run("airside", Desk::split("pretrain --site site.toml -o site.blob --json"));
  EXPECT_EQ(as_json.code, 0) << as_json.err;
  const auto said = nlohmann::json::parse(as_json.out);
  EXPECT_EQ(said["needed"], false);
  EXPECT_EQ(said["objective"], "band");
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
