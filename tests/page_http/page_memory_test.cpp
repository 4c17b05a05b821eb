// What the page remembers by itself: alarms until somebody has seen them, what became of weights, a month of the log.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "firmware/page/data/ledger.hpp"
#include "firmware/page/data/trend_store.hpp"
#include "firmware/page/data/trends.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/civil_text.hpp"
#include "page_http/page_rig.hpp"

namespace airside::page {
namespace {

using nlohmann::json;

class PageMemory : public PageRig {
 protected:
  PageMemory() { fs::create_directories(folder / "page"), fs::create_directories(folder / "log"); }

  static json status(const std::string& time, const std::vector<std::string>& alarms,
                     const std::string& pushed = "none") {
    json s{{"time", time},
           {"reason", "none"},
           {"pushed_weights", pushed},
           {"pushed_crc", "0"},
           {"pushed_refusal", "none"}};
    s["alarms"] = json::array();
    for (const std::string& a : alarms) s["alarms"].push_back({{"reason", a}, {"since", time}});
    return s;
  }
  static constexpr const char* seen_at = "2021-07-05T08:00:00";
  static AlarmIds only(const json& alarm) {
    return {alarm["id"].get<std::uint64_t>(), alarm["id"].get<std::uint64_t>()};
  }
  std::string dir() const { return folder / "page"; }

  /// Rows of a day from `row` on, each with rooms at `degc`; with the header where `with_header`.
  static std::string log_rows(const std::string& date, int row, int count, double degc, bool with_header = true,
                              const std::string& mode = "learn,none") {
    std::string out;
    if (with_header) {
      out =
          "time,room_temp_1_degc,room_temp_2_degc,room_temp_3_degc,room_temp_4_degc,room_temp_5_degc,fcu_temp_1_degc,"
          "fcu_temp_2_degc,fcu_temp_3_degc,fcu_temp_4_degc,fcu_temp_5_degc,vav_on_1,vav_on_2,vav_on_3,vav_on_4,"
          "vav_on_5,fcu_on_1,fcu_on_2,fcu_on_3,fcu_on_4,fcu_on_5,power_1_kw,power_2_kw,mau_temp_degc,"
          "outdoor_temp_degc,rain,setpoint_degc,supply_temp_degc,mode,reason\n";
    }
    for (int i = row; i < row + count; ++i) {
      out += fmt::format("{}T{:02}:{:02}:00", date, i / 10, i % 10 * 6);
      for (int r = 0; r < 5; ++r) out += fmt::format(",{}", degc + r * 0.1);
      out += ",25,25,25,25,25,1,1,1,1,1,0,0,0,0,0,2.5,0.5,18,30.25,0,22.400000000000002,22.5," + mode + "\n";
    }
    return out;
  }
  TrendStore store() {
    write_site();
    return TrendStore(hal::read_site_file(folder / "site.toml", hal::site_rules()));
  }
  static void read_all(TrendStore& store) {
    for (int i = 0; i < 1000 && store.step(); ++i) continue;
  }
};

TEST_F(PageMemory, AnAlarmStaysUntilItHasEndedAndWasSeen) {
  Ledger ledger(dir());
  ledger.watch(status("2021-07-01T10:00:00", {"no reading"}));
  ledger.watch(status("2021-07-01T10:06:00", {}));
  json alarms = ledger.alarms()["alarms"];
  ASSERT_EQ(alarms.size(), 1u);
  EXPECT_EQ(alarms[0]["ended"], "2021-07-01T10:06:00");
  EXPECT_EQ(alarms[0]["seen_at"], "");
  Ledger later(dir());  // after a restart
  later.watch(status("2021-07-01T10:12:00", {"sensor drifts"}));
  alarms = later.alarms()["alarms"];
  ASSERT_EQ(alarms.size(), 2u);
  EXPECT_EQ(alarms[0]["reason"], "sensor drifts") << "active ones first";
  EXPECT_TRUE(later.see(only(alarms[1]), "operator", seen_at));
  EXPECT_FALSE(later.see(only(alarms[1]), "operator", seen_at)) << "once";
  EXPECT_FALSE(later.see({999, 999}, "operator", seen_at));
  EXPECT_TRUE(later.see({}, "operator", seen_at)) << "an active one can be seen too";
  later.watch(status("2021-07-01T10:18:00", {"sensor drifts"}));
  alarms = Ledger(dir()).alarms()["alarms"];
  ASSERT_EQ(alarms.size(), 2u);
  EXPECT_EQ(alarms[0]["ended"], "");
  EXPECT_EQ(alarms[0]["seen_by"], "operator");
  EXPECT_EQ(alarms[0]["seen_at"], seen_at) << "and not the time of the last status";
  later.watch(status("2021-07-01T10:24:00", {}));
  later.watch(status("2021-07-01T10:30:00", {"sensor drifts"}));
  EXPECT_EQ(later.alarms()["alarms"].size(), 3u) << "what comes again is another one, unseen";
}

TEST_F(PageMemory, HoldsAtMostAHundredAlarmsAndKeepsTheUnseen) {
  Ledger ledger(dir());
  ledger.watch(status("2021-07-01T00:00:00", {"state lost"}));
  ledger.watch(status("2021-07-01T00:06:00", {}));
  for (int i = 0; i < 300; ++i) {
    ledger.watch(status(fmt::format("2021-07-02T{:02}:{:02}:00", i / 60, i % 60), {"no reading"}));
    ledger.watch(status(fmt::format("2021-07-02T{:02}:{:02}:30", i / 60, i % 60), {}));
    if (i > 2) {
      ledger.see(only(ledger.alarms()["alarms"][0]), "operator", seen_at);
    }
  }
  const json alarms = ledger.alarms()["alarms"];
  EXPECT_EQ(alarms.size(), Ledger::max_alarms);
  EXPECT_TRUE(std::ranges::any_of(alarms, [](const json& a) { return a["reason"] == "state lost"; }));
  EXPECT_LE(fs::file_size(folder / "page/ledger.json"), Ledger::max_bytes);
}

TEST_F(PageMemory, WhatFlapsPushesOutNothingElse) {
  Ledger ledger(dir());
  ledger.watch(status("2021-07-01T00:00:00", {"two masters"}));
  ledger.watch(status("2021-07-01T00:06:00", {}));
  for (int i = 0; i < 120; ++i) {
    ledger.watch(status(fmt::format("2021-07-02T{:02}:{:02}:00", i / 60, i % 60), {"no reading"}));
    ledger.watch(status(fmt::format("2021-07-02T{:02}:{:02}:30", i / 60, i % 60), {}));
  }
  const json alarms = Ledger(dir()).alarms()["alarms"];  // as the file has it
  ASSERT_EQ(alarms.size(), Ledger::max_alarms);
  EXPECT_EQ(alarms[99]["reason"], "two masters");
  EXPECT_EQ(alarms[99]["times"], 1);
  EXPECT_EQ(alarms[98]["since"], "2021-07-02T00:00:00") << "the oldest of those that were made one";
  EXPECT_EQ(alarms[98]["ended"], "2021-07-02T00:21:30");
  EXPECT_EQ(alarms[98]["times"], 22);
  EXPECT_EQ(alarms[97]["times"], 1);
  EXPECT_LE(fs::file_size(folder / "page/ledger.json"), Ledger::max_bytes);
}

TEST_F(PageMemory, OfAllThatWasShownNothingLaterIsAcknowledged) {
  Ledger ledger(dir());
  ledger.watch(status("2021-07-01T00:00:00", {"two masters", "no reading", "sensor drifts"}));
  ledger.watch(status("2021-07-01T00:06:00", {"state lost"}));  // after the page was drawn
  EXPECT_TRUE(ledger.see({.first = 1, .last = 3}, "operator", seen_at));
  const json alarms = ledger.alarms()["alarms"];
  ASSERT_EQ(alarms.size(), 4u);
  for (const json& a : alarms) EXPECT_EQ(a["seen_at"], a["reason"] == "state lost" ? "" : seen_at) << a;
}

TEST_F(PageMemory, NotesWhatBecameOfWeightsOnce) {
  {
    Ledger ledger(dir());
    for (int i = 0; i < 3; ++i) ledger.watch(status("2021-07-01T10:00:00", {}, "none"));
    for (int i = 0; i < 3; ++i) ledger.watch(status("2021-07-01T10:06:00", {}, "on trial"));
  }
  Ledger ledger(dir());
  ledger.watch(status("2021-07-01T10:12:00", {}, "on trial"));
  ledger.watch(status("2021-07-02T10:12:00", {}, "confirmed"));
  const json events = ledger.events();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0]["what"], "confirmed");
  EXPECT_EQ(events[1]["what"], "on trial");
}

TEST_F(PageMemory, ADamagedLedgerIsBegunAnewAndAFolderThatIsGoneIsSaid) {
  write("page/ledger.json", "{\"alarms\":[{\"reason\":7}],\"events\":3");
  Ledger ledger(dir());
  EXPECT_TRUE(ledger.alarms()["alarms"].empty());
  Ledger nowhere(folder / "absent");
  nowhere.watch(status("2021-07-01T10:00:00", {"no reading"}));
  EXPECT_EQ(nowhere.alarms()["kept"], false);
  EXPECT_EQ(nowhere.alarms()["alarms"].size(), 1u) << "until the page ends it is remembered";
}

TEST_F(PageMemory, FollowsALogAsItGrows) {
  write("log/airside-2021-07-01.csv", log_rows("2021-07-01", 0, 240, 25));
  write("log/other.csv", "no log of the daemon\n");
  TrendStore s = store();
  read_all(s);
  EXPECT_EQ(s.count(), 240u);
  const std::string half = log_rows("2021-07-02", 0, 2, 26);
  write("log/airside-2021-07-02.csv", half.substr(0, half.size() - 20));
  read_all(s);
  EXPECT_EQ(s.count(), 241u) << "a row that is still being written waits";
  write("log/airside-2021-07-02.csv", half);
  read_all(s);
  ASSERT_EQ(s.count(), 242u);
  EXPECT_NEAR(s.row(241).held_degc, 26.2, 1e-4);
  EXPECT_NEAR(s.row(241).power_kw, 3.0, 1e-5);
  EXPECT_EQ(s.rooms_degc(241)[4], 26.4f);
  write("log/airside-2021-07-02.csv", log_rows("2021-07-02", 0, 1, 27));
  read_all(s);
  EXPECT_EQ(s.count(), 241u) << "cut after a crash: read anew";
  EXPECT_EQ(s.trouble(), "");
}

TEST_F(PageMemory, BeginsAnewWhereTheLogWasMovedAway) {
  write("log/airside-2027-07-01.csv", log_rows("2027-07-01", 0, 240, 25));
  TrendStore s = store();
  read_all(s);
  ASSERT_EQ(s.count(), 240u);
  const std::uint64_t before = s.generation();
  fs::rename(folder / "log", folder / "log.future");
  fs::create_directory(folder / "log");
  write("log/airside-2026-07-01.csv", log_rows("2026-07-01", 0, 3, 26));
  read_all(s);
  ASSERT_EQ(s.count(), 3u);
  EXPECT_EQ(s.row(0).time, (hal::civil_time({2026, 7, 1, 0, 0, 0})));
  EXPECT_NE(s.generation(), before);
  fs::rename(folder / "log/airside-2026-07-01.csv", folder / "log/kept");
  write("log/airside-2025-07-01.csv", log_rows("2025-07-01", 0, 2, 26));
  read_all(s);
  EXPECT_EQ(s.count(), 2u) << "the file alone was moved";
}

TEST_F(PageMemory, AMeterThatIsLostIsNotLeftOutOfASum) {
  std::string log = log_rows("2021-07-01", 0, 10, 25);
  for (std::size_t at = 0; (at = log.find(",2.5,0.5,", at)) != std::string::npos;) log.replace(at, 9, ",,0.5,");
  write("log/airside-2021-07-01.csv", log);
  TrendStore s = store();
  read_all(s);
  ASSERT_EQ(s.count(), 10u) << s.trouble();
  EXPECT_TRUE(std::isnan(s.row(0).power_kw)) << s.row(0).power_kw;
  const json t = trends(s, "day", false);
  EXPECT_TRUE(t["days"][0]["energy_kwh"].is_null()) << t["days"][0];
  EXPECT_TRUE(t["has_meters"].get<bool>());
}

TEST_F(PageMemory, LeavesOutWhatCannotBeReadAndSaysSo) {
  write("log/airside-2021-07-01.csv", log_rows("2021-07-01", 0, 240, 25));
  write("log/airside-2021-07-02.csv", "time,nothing\n2021-07-02T00:00:00,1\n");
  write("log/airside-2021-07-03.csv", log_rows("2021-07-03", 0, 10, 25));
  TrendStore s = store();
  read_all(s);
  EXPECT_EQ(s.count(), 250u);
  EXPECT_NE(s.trouble().find("airside-2021-07-02.csv"), std::string::npos) << s.trouble();
}

TEST_F(PageMemory, HoldsAMonthAndGivesAtMostFiveHundredPoints) {
  for (int day = 1; day <= 35; ++day) {
    const std::string date = fmt::format("2021-{:02}-{:02}", day <= 31 ? 7 : 8, day <= 31 ? day : day - 31);
    write("log/airside-" + date + ".csv",
          log_rows(date, 0, 240, 25, true, day == 20 ? "release,overridden" : "run,none"));
  }
  TrendStore s = store();
  read_all(s);
  EXPECT_EQ(s.count() - s.first(), TrendStore::capacity);
  for (const char* span : {"day", "week", "month"}) {
    const json t = trends(s, span, false);
    EXPECT_EQ(t["rows"].get<std::uint64_t>(), rows_of_span(span).value());
    EXPECT_LE(t["points"].get<std::size_t>(), max_points) << span;
    EXPECT_EQ(t["time_s"].size(), t["points"].get<std::size_t>());
    EXPECT_EQ(t["held_degc"].size(), t["points"].get<std::size_t>());
    EXPECT_EQ(t["rooms_degc"].size(), 5u);
  }
  const json month = trends(s, "month", false);
  ASSERT_EQ(month["days"].size(), 31u);
  const json& last = month["days"][30];
  EXPECT_EQ(last["date"], "2021-08-04");
  EXPECT_EQ(last["energy_kwh"], 72.0) << "3 kW for a day";
  EXPECT_EQ(last["working_h"], 12.0);
  EXPECT_NEAR(last["degree_hours_kh"].get<double>(), 12 * 0.05, 0.011) << "25.2 where 25.25 is wanted";
  EXPECT_EQ(month["by_control"]["released"]["hours"], 24.0);
  const auto& spells = month["spells"];
  ASSERT_EQ(spells.size(), 3u);
  EXPECT_EQ(spells[1]["reason"], "overridden");
  EXPECT_EQ(spells[1]["from"], "2021-07-20T00:00:00");
  EXPECT_TRUE(trends(s, "month", true)["days"][0]["degree_hours_kh"].is_null()) << "band has no target";
  std::string csv;
  append_csv_row(s, s.count() - 1, csv);
  EXPECT_EQ(
      csv, "2021-08-04T23:54:00,run,none,25.20,25.00,25.40,22.40,22.50,30.25,,,,3.000,25.00,25.10,25.20,25.30,25.40\n");
}

TEST_F(PageMemory, ABandSiteHasTheZonesSetpointsAndTheirDegreeHours) {
  write("points.csv", hal::default_point_map(2, 0, 1, {}, true));
  write("band.toml",
        "[site]\nname = \"Band\"\ntopology = \"2vav-0fcu-1power\"\n[controller]\nobjective = \"band\"\n"
        "[modbus]\nhost = \"127.0.0.1\"\npoints = \"points.csv\"\n[state]\ndir = \"state\"\n[log]\ndir = \"log\"\n");
  std::string log =
      "time,room_temp_1_degc,room_temp_2_degc,vav_on_1,vav_on_2,power_1_kw,mau_temp_degc,outdoor_temp_degc,rain,"
      "setpoint_degc,supply_temp_degc,damper_1,damper_2,zone_setpoint_1_degc,zone_setpoint_2_degc,"
      "zone_heating_setpoint_1_degc,zone_heating_setpoint_2_degc,occupied,supply_flow_m3s,ahu_on,mode,reason\n";
  for (int i = 0; i < 240; ++i) {
    // Two hours with people in and the fan on, one without people, one without air. Room 1 is 1.5 K above its setpoint,
    // room 2 is 0.75 K below its heating setpoint; in the last row of all room 2 has no setpoints.
    const bool people = i < 20 || (i >= 30 && i < 40), fan = i < 30;
    log += fmt::format("2021-07-01T{:02}:{:02}:00,25.5,20.25,1,1,2,18,30,0,14,14,0.9,0.3,24,", i / 10, i % 10 * 6);
    log += i == 239 ? ",21,," : "24,21,21,";
    log += fmt::format("{},1,{},run,none\n", people ? 1 : 0, fan ? 1 : 0);
  }
  write("log/airside-2021-07-01.csv", log);
  TrendStore s(hal::read_site_file(folder / "band.toml", hal::site_rules()));
  read_all(s);
  ASSERT_EQ(s.count(), 240u) << s.trouble();
  const json t = trends(s, "day", true), day = t["days"][0];
  EXPECT_NEAR(day["zones_too_warm_kh"].get<double>(), 2 * 1.0, 1e-9) << "beyond the 0.5 K of a thermostat's swing";
  EXPECT_NEAR(day["zones_too_cold_kh"].get<double>(), 2 * 0.25, 1e-9);
  EXPECT_EQ(t["by_control"]["airside"]["zones_too_warm_kh"], day["zones_too_warm_kh"]);
  EXPECT_TRUE(t["by_control"]["schedule"]["zones_too_warm_kh"].is_null()) << "it never controlled";
  EXPECT_TRUE(day["degree_hours_kh"].is_null()) << "there is no target";
  EXPECT_EQ(
      t["zones"],
      (json{{"time", "2021-07-01T23:54:00"}, {"cooling_degc", {24.0, nullptr}}, {"heating_degc", {21.0, nullptr}}}));
  const json mean = trends(s, "day", false);
  EXPECT_TRUE(mean["zones"].is_null());
  EXPECT_TRUE(mean["days"][0]["zones_too_warm_kh"].is_null());
}

TEST_F(PageMemory, AGapIsEmptyAndNotALine) {
  write("log/airside-2021-07-01.csv", log_rows("2021-07-01", 0, 10, 25) + log_rows("2021-07-01", 50, 10, 26, false));
  TrendStore s = store();
  read_all(s);
  const json t = trends(s, "day", false);
  ASSERT_EQ(t["points"], 60u);
  EXPECT_TRUE(t["held_degc"][20].is_null());
  EXPECT_TRUE(t["mode"][20].is_null());
  EXPECT_EQ(t["held_degc"][55], 26.2);
  EXPECT_EQ(t["spells"].size(), 2u);
}

TEST_F(PageMemory, AnEmptyFolderIsNoFault) {
  TrendStore s = store();
  read_all(s);
  EXPECT_EQ(trends(s, "week", false)["points"], 0);
  fs::remove(folder / "log");
  read_all(s);
  EXPECT_EQ(s.count(), 0u);
}

}  // namespace
}  // namespace airside::page
