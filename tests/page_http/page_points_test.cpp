// What people check a site by: forecasts against the rooms, points against the map, each with a name behind it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "firmware/page/data/checkout.hpp"
#include "firmware/page/data/forecast_gap.hpp"
#include "firmware/page/data/trend_store.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_settings.hpp"
#include "page_http/page_rig.hpp"

namespace airside::page {
namespace {

using nlohmann::json;

class PagePoints : public PageRig {
 protected:
  PagePoints() {
    for (const char* part : {"page", "log"}) fs::create_directories(folder / part);
    write("points.csv", hal::default_point_map(5, 5, 2));
    write("site.toml",
          "[site]\nname = \"Room 301\"\ntopology = \"5vav-5fcu-2power\"\n[modbus]\nhost = \"127.0.0.1\"\n"
          "points = \"points.csv\"\n");
  }
  hal::SiteFile site() const { return hal::read_site_file(folder / "site.toml", hal::site_rules()); }
  Checkout checkout() const { return Checkout(site()); }

  /// A reading of the daemon: room_temp_1 shows `raw`, with `fault`.
  void write_reading(const std::string& time, int raw, const std::string& fault = "none") const {
    json all{{"time", time}, {"points", json::array()}};
    all["points"].push_back({{"name", "room_temp_1"}, {"raw", {raw}}, {"fault", fault}, {"exception", 0}});
    all["points"].push_back(
        {{"name", "room_temp_2"}, {"raw", json::array()}, {"fault", "no reading"}, {"exception", 2}});
    write("state/points.json", all.dump());
  }
  static json point(const Checkout& checkout, const std::string& name) {
    const json all = checkout.points();
    for (const json& p : all["points"]) {
      if (p["name"] == name) return p;
    }
    return nullptr;
  }

  /// Whole days of a log in which every room stays where it is, and the held value (their mean) is forecast to be
  /// `wrong_k` above it. The setpoint changes in the second row of the cycle that begins at 10:12.
  void write_day(int day, double wrong_k) const {
    std::string out = "time";
    for (const char* name : {"room_temp_{}_degc", "fcu_temp_{}_degc", "vav_on_{}", "fcu_on_{}"}) {
      for (int r = 1; r <= 5; ++r) out += "," + fmt::format(fmt::runtime(name), r);
    }
    out += ",power_1_kw,power_2_kw,mau_temp_degc,outdoor_temp_degc,rain,setpoint_degc,supply_temp_degc,mode,reason";
    out += ",expected_held_degc\n";
    for (int i = 0; i < 240; ++i) {
      out += fmt::format("2021-07-{:02}T{:02}:{:02}:00", day, i / 10, i % 10 * 6);
      for (int r = 0; r < 5; ++r) out += fmt::format(",{}", 25 + r * 0.1);
      out += ",25,25,25,25,25,1,1,1,1,1,0,0,0,0,0,2.5,0.5,18,30,0,";
      out += i == 103 ? "23" : "22";
      out += ",22.5,learn,none,";
      out += (i % 3 == 0 && std::isfinite(wrong_k) ? fmt::format("{}", 25.2 + wrong_k) : "") + "\n";
    }
    write(fmt::format("log/airside-2021-07-{:02}.csv", day), out);
  }
  json gap() const {
    TrendStore store(site());
    for (int i = 0; i < 1000 && store.step(); ++i) continue;
    return forecast_gap(store);
  }
};

TEST_F(PagePoints, ForecastErrorsAreGivenByDayForTheHeldValueAndEachRoom) {
  for (int day = 1; day <= 16; ++day) write_day(day, day % 2 == 0 ? 0.1 : -0.1);
  const json g = gap();
  ASSERT_EQ(g["days"].size(), 14u) << "two weeks of sixteen days";
  EXPECT_EQ(g["days"][0]["date"], "2021-07-03");
  EXPECT_EQ(g["days"][0]["n"], 39) << "12 h in cycles of 18 min, but for the one whose setpoint changed";
  for (std::size_t i = 0; i <= 5; ++i) {
    EXPECT_EQ(g["days"][0]["bias_k"][i], 0.1) << i;
    EXPECT_EQ(g["days"][1]["bias_k"][i], -0.1) << i;
    EXPECT_EQ(g["bias_k"][i], 0.0) << i;
    EXPECT_EQ(g["rms_k"][i], 0.1) << i;
    EXPECT_EQ(g["grows"][i], false) << i;
  }
  EXPECT_EQ(g["recent_days"], 3);
  EXPECT_EQ(g["before_days"], 11);
  EXPECT_EQ(g["enough"], true);
}

TEST_F(PagePoints, ForecastErrorsThatGrowAreNamedAndSmallOnesAreNot) {
  for (int day = 1; day <= 8; ++day) write_day(day, day <= 5 ? 0.1 : 0.16);
  EXPECT_EQ(gap()["grows"][0], true) << "1.6 times, and 0.06 K";
  for (int day = 6; day <= 8; ++day) write_day(day, 0.14);
  EXPECT_EQ(gap()["grows"][0], false) << "1.4 times";
  for (int day = 1; day <= 8; ++day) write_day(day, day <= 5 ? 0.02 : 0.06);
  EXPECT_EQ(gap()["grows"][0], false) << "three times, but 0.04 K";
  fs::remove(folder / "log/airside-2021-07-01.csv");
  fs::remove(folder / "log/airside-2021-07-02.csv");
  for (int day = 6; day <= 8; ++day) write_day(day, 0.5);
  const json g = gap();
  EXPECT_EQ(g["enough"], false) << "three days before the newest three";
  EXPECT_EQ(g["grows"][0], false);
}

TEST_F(PagePoints, TheReferenceIsOfDaysBeforeTheNewestThree) {
  for (int day = 1; day <= 8; ++day) write_day(day, 0.1);
  EXPECT_EQ(gap()["reference_days"], 5) << "of eight";
  for (int day = 9; day <= 13; ++day) write_day(day, 0.1);
  EXPECT_EQ(gap()["reference_days"], 7) << "of thirteen";
  fs::remove_all(folder / "log");
  fs::create_directories(folder / "log");
  write_day(1, 0.1);
  EXPECT_EQ(gap()["reference_days"], 2) << "the least that airside gap takes";
}

TEST_F(PagePoints, TheCommandsOfTheGapFitTheSite) {
  using Commands = std::vector<std::string>;
  const auto commands = [&](const std::string& name, const std::string& more) {
    write(name, "[site]\nname = \"Room 301\"\ntopology = \"5vav-5fcu-2power\"\n" + more);
    return GapHint(hal::read_site_file(folder / name, hal::site_rules())).commands(6);
  };
  EXPECT_EQ(commands("site.toml", ""),
            (Commands{"airside gap fit --site site.toml --measured log --weather STATION.epw --out room.json",
                      "airside gap --site site.toml --measured log --reference-days 6 --plant rc --room room.json "
                      "--weather STATION.epw --out gap-report"}));
  EXPECT_EQ(commands("it's 3.toml", "[log]\ndir = \"my logs/\"\n[twin]\nmodel = \"rc\"\n"),
            (Commands{"airside gap --site 'it'\\''s 3.toml' --measured 'my logs' --reference-days 6 "
                      "--weather STATION.epw --out gap-report"}));
  EXPECT_EQ(commands("site.toml", "[twin]\nmodel = \"m.epJSON\"\nweather = \"a.epw\"\n"),
            (Commands{"airside gap --site site.toml --measured log --reference-days 6 --out gap-report"}));
}

TEST_F(PagePoints, ALogWithoutForecastsHasNoGap) {
  EXPECT_EQ(gap()["n"], 0);
  write_day(1, std::nan(""));
  EXPECT_EQ(gap()["n"], 0);
}

TEST_F(PagePoints, APointIsSignedOffByNameAndStaysSoOverARestart) {
  write_reading("2021-07-01T10:00:00", 2531);
  Checkout first = checkout();
  EXPECT_EQ(point(first, "room_temp_1")["value"], 25.31);
  EXPECT_EQ(point(first, "room_temp_1")["verdict"], "plausible");
  EXPECT_EQ(point(first, "room_temp_2")["verdict"], "refused");
  EXPECT_EQ(point(first, "room_temp_3")["verdict"], "not read");
  EXPECT_EQ(first.sign("room_temp_1\nAnn\n2021-07-01T10:00:00", "installer").status, 200);
  const Checkout later = checkout();
  EXPECT_EQ(later.points()["signed"], 1);
  EXPECT_EQ(later.points()["total"], later.points()["points"].size());
  const json s = point(later, "room_temp_1")["signed"];
  EXPECT_EQ(s["by"], "Ann");
  EXPECT_EQ(s["role"], "installer");
  EXPECT_EQ(s["value"], "25.31");
  EXPECT_EQ(s["read_at"], "2021-07-01T10:00:00");
  EXPECT_NE(later.csv().find("\"room_temp_1\""), std::string::npos);
  Checkout last = checkout();
  EXPECT_EQ(last.withdraw("room_temp_1").status, 200);
  EXPECT_EQ(last.withdraw("room_temp_1").status, 404);
  EXPECT_EQ(checkout().points()["signed"], 0);
}

TEST_F(PagePoints, WhatWasNotReadOrIsNotPlausibleIsNotSigned) {
  Checkout c = checkout();
  EXPECT_EQ(c.sign("room_temp_1\nAnn\n", "installer").status, 409) << "nothing was read";
  write_reading("2021-07-01T10:00:00", 65535, "not finite");
  EXPECT_EQ(c.sign("room_temp_1\nAnn\n2021-07-01T10:00:00", "installer").status, 409) << "a sentinel";
  EXPECT_EQ(c.sign("room_temp_2\nAnn\n2021-07-01T10:00:00", "installer").status, 409) << "refused by the device";
  write_reading("2021-07-01T10:06:00", 2531);
  EXPECT_EQ(c.sign("room_temp_1\nAnn\n2021-07-01T10:00:00", "installer").status, 409) << "another reading";
  EXPECT_EQ(c.sign("room_temp_7\nAnn\n2021-07-01T10:06:00", "installer").status, 404);
  for (const char* body :
       {"", "room_temp_1", "room_temp_1\n\n2021-07-01T10:06:00", "room_temp_1\n  \n2021-07-01T10:06:00",
        "room_temp_1\nA\x01\n2021-07-01T10:06:00", "room_temp_1\nAnn\n2021-07-01T10:06:00\nmore"}) {
    EXPECT_EQ(c.sign(body, "installer").status, 400) << body;
  }
  fs::remove_all(folder / "page");
  EXPECT_EQ(c.sign("room_temp_1\nAnn\n2021-07-01T10:06:00", "installer").status, 503);
  EXPECT_EQ(c.points()["signed"], 0) << "nothing is signed that is not kept";
  EXPECT_EQ(c.points()["kept"], false);
}

TEST_F(PagePoints, WhatBecameOfAWriteIsGivenOn) {
  EXPECT_EQ(checkout().points()["write"], nullptr);
  for (const char* none : {R"({"time":"x","points":[],"write":[1]})", R"({"time":"x","points":[]})"}) {
    write("state/points.json", none);
    EXPECT_EQ(checkout().points()["write"], nullptr) << none;
  }
  write("state/points.json",
        R"({"time":"2021-07-01T10:00:00","points":[],"write":{"time":"2021-07-01T09:59:00","fault":"write refused",)"
        R"("before":20.5,"sent":21,"taken":null,"restored":20.5,"more":"not given on"}})");
  const json tried = checkout().points()["write"];
  EXPECT_EQ(tried, json::parse(R"({"time":"2021-07-01T09:59:00","fault":"write refused","before":20.5,"sent":21.0,)"
                               R"("taken":null,"restored":20.5})"));
  fs::create_directories(folder / "inbox");
  write("inbox/check-write", "");
  EXPECT_EQ(checkout().points()["waiting"], true);
}

TEST_F(PagePoints, ASignOffEndsWithItsRowOfTheMap) {
  write_reading("2021-07-01T10:00:00", 2531);
  ASSERT_EQ(checkout().sign("room_temp_1\nAnn\n2021-07-01T10:00:00", "installer").status, 200);
  std::string map = read("points.csv");
  const std::size_t row = map.find("\nroom_temp_1,");
  const std::size_t scale = map.find("0.01", row);
  ASSERT_LT(scale, map.find('\n', row + 1));
  map.replace(scale, 4, "0.02");
  write("points.csv", map);
  const Checkout changed = checkout();
  EXPECT_EQ(changed.points()["signed"], 0);
  EXPECT_EQ(point(changed, "room_temp_1")["signed"]["valid"], false);
  write("page/checkout.json", "{torn");
  EXPECT_NE(checkout().points()["trouble"].get<std::string>().find("damaged"), std::string::npos);
}

TEST_F(PagePoints, APageFileIsPackedForWhoeverTakesIt) {
  ASSERT_TRUE(start());
  const auto with = [&](const std::string& line) {
    return ask("GET /style.css HTTP/1.1\r\nHost: " + host() + "\r\n" + line + "\r\n");
  };
  const std::string plain = with(""), packed = with("Accept-Encoding: br, gzip;q=0.8\r\n");
  EXPECT_EQ(plain.find("Content-Encoding"), std::string::npos);
  EXPECT_NE(packed.find("Content-Encoding: gzip"), std::string::npos);
  EXPECT_NE(packed.find("Vary: Accept-Encoding"), std::string::npos);
  EXPECT_LT(2 * body_of(packed).size(), body_of(plain).size());
  write("packed.gz", body_of(packed));
  std::FILE* unpacked = ::popen(("gzip -dc " + (folder / "packed.gz").string()).c_str(), "r");
  std::string text(body_of(plain).size() + 1, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), unpacked));
  EXPECT_EQ(::pclose(unpacked), 0);
  EXPECT_EQ(text, body_of(plain));
  for (const char* line :
       {"Accept-Encoding: gzip;q=0\r\n", "Accept-Encoding: gzipped, br\r\n", "Accept-Encoding: \r\n"}) {
    EXPECT_EQ(with(line).find("Content-Encoding"), std::string::npos) << line;
  }
  const std::size_t at = packed.find("ETag: ") + 6;
  const std::string etag = packed.substr(at, packed.find("\r\n", at) - at);
  EXPECT_EQ(status_of(with("Accept-Encoding: gzip\r\nIf-None-Match: " + etag + "\r\n")), 304);
  EXPECT_EQ(status_of(with("If-None-Match: " + etag + "\r\n")), 200) << "another form of the file";
}

}  // namespace
}  // namespace airside::page
