// Which clock the page goes by: files from the future, acknowledgements long after the last status, daylight saving.

#include <ctime>
#include <nlohmann/json.hpp>

#include "firmware/page/auth/access_file.hpp"
#include "firmware/page/data/checkout.hpp"
#include "firmware/page/data/facts.hpp"
#include "hal/modbus/plant_clock.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/civil_text.hpp"
#include "page_http/page_rig.hpp"

namespace airside::page {
namespace {

using nlohmann::json;

class PageClock : public PageRig {
 protected:
  PageClock() { fs::create_directory(folder / "page"); }
  /// Of a file: written `s` ago; below 0: in the future.
  void set_age(const std::string& name, int s) const {
    fs::last_write_time(folder / name, fs::file_time_type::clock::now() - std::chrono::seconds(s));
  }
  static double header_of(const std::string& answer, const std::string& name) {
    const std::size_t at = answer.find("\r\n" + name + ": ");
    return at == std::string::npos ? -1 : std::stod(answer.substr(at + name.size() + 4));
  }
  /// What `airside::hal::SystemClock` shows, within `s`.
  static void expect_now(const std::string& text, int s = 60) {
    const auto at = hal::parse_civil_text(text);
    ASSERT_TRUE(at.has_value()) << text;
    EXPECT_NEAR(static_cast<double>(at->seconds), static_cast<double>(hal::SystemClock().now().seconds), s) << text;
  }
};

TEST_F(PageClock, AStatusFromTheFutureIsNotTakenForANewOne) {
  ASSERT_TRUE(start()) << read("said.txt");
  set_age("state/status.json", 1200);
  std::string answer = ask(get("/status.json"));
  EXPECT_NEAR(header_of(answer, "Age"), 1200, 30) << answer;
  EXPECT_EQ(answer.find("X-Airside-Ahead"), std::string::npos) << answer;
  set_age("state/status.json", -3600);
  answer = ask(get("/status.json"));
  EXPECT_NEAR(header_of(answer, "Age"), 3600, 30) << answer;
  EXPECT_NEAR(header_of(answer, "X-Airside-Ahead"), 3600, 30) << answer;
}

TEST_F(PageClock, AReadingFromTheFutureHasANegativeAge) {
  write("points.csv", hal::default_point_map(5, 5, 2));
  write("site.toml",
        "[site]\nname = \"Room 301\"\ntopology = \"5vav-5fcu-2power\"\n[modbus]\nhost = \"127.0.0.1\"\n"
        "points = \"points.csv\"\n");
  const Checkout checkout(hal::read_site_file(folder / "site.toml", hal::site_rules()));
  write("state/points.json", R"({"time":"2021-07-01T10:00:00","points":[]})");
  set_age("state/points.json", -3600);
  EXPECT_NEAR(checkout.points()["age_s"].get<double>(), -3600, 30);
  set_age("state/points.json", 90);
  EXPECT_NEAR(checkout.points()["age_s"].get<double>(), 90, 30);
}

TEST_F(PageClock, AnAcknowledgementHasItsOwnTimeAlsoWhereTheDaemonDiedDaysAgo) {
  const std::string key(64, 'a');
  Access access;
  access.keys.push_back({Role::operator_, digest_of_key(key), "building system"});
  write_access(folder / "page", access);
  constexpr int three_days_s = 3 * 86400;
  const std::string died = hal::civil_text({hal::SystemClock().now().seconds - three_days_s});
  const auto seen_after = [&](const std::string& time, const std::string& clock) {
    page.reset();
    fs::remove(folder / "page/ledger.json");
    write("state/status.json",
          R"({"time":")" + time + R"(","reason":"none","alarms":[{"reason":"no reading","since":")" + time + R"("}]})");
    set_age("state/status.json", three_days_s);
    EXPECT_TRUE(start(clock)) << read("said.txt");
    const auto order = [&](const std::string& path, const std::string& body) {
      return status_of(ask("POST " + path + " HTTP/1.1\r\nHost: " + host() + "\r\nAuthorization: Bearer " + key +
                           "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body));
    };
    EXPECT_EQ(status_of(ask(get("/status.json"))), 200);
    EXPECT_EQ(order("/alarms/seen", "all 0"), 400);
    EXPECT_EQ(order("/alarms/seen", "all 1"), 200);
    EXPECT_EQ(order("/alarms/seen", "all 1"), 404);
    EXPECT_EQ(order("/rollback", ""), 202);
    const json events = json::parse(body_of(ask(get("/weights.json"))))["events"];
    EXPECT_EQ(events[0]["what"], "rollback asked");
    const json alarm = json::parse(body_of(ask(get("/alarms.json"))))["alarms"][0];
    EXPECT_EQ(alarm["since"], time) << "what a status reports has the time of that";
    EXPECT_EQ(alarm["seen_at"].get<std::string>().substr(0, 16), events[0]["at"].get<std::string>().substr(0, 16));
    return alarm["seen_at"].get<std::string>();
  };
  expect_now(seen_after(died, ""));
  // The clock of the AHU is another one; what passed since the status is known.
  const std::string other = seen_after("2021-07-01T10:00:00", "[clock]\nsource = \"plant\"");
  EXPECT_EQ(other.substr(0, 15), "2021-07-04T10:0") << other;
}

TEST_F(PageClock, TheSitesClockIsThatOfWinterTheWholeYear) {
  const char* before = std::getenv("TZ");
  const std::string kept = before == nullptr ? "" : before;
  const auto facts = [this](const char* zone, const std::string& clock) {
    ::setenv("TZ", zone, 1);
    ::tzset();
    write_site(clock);
    return site_facts(hal::read_site_file(folder / "site.toml", hal::site_rules()));
  };
  EXPECT_EQ(facts("CET-1CEST,M3.5.0,M10.5.0/3", "")["utc_offset_min"], 60);
  EXPECT_EQ(facts("NST3:30NDT,M3.2.0,M11.1.0", "")["utc_offset_min"], -210);
  EXPECT_TRUE(facts("CET-1CEST,M3.5.0,M10.5.0/3", "[clock]\nsource = \"plant\"")["utc_offset_min"].is_null());
  before == nullptr ? ::unsetenv("TZ") : ::setenv("TZ", kept.c_str(), 1);
  ::tzset();
}

}  // namespace
}  // namespace airside::page
