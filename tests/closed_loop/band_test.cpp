// The objective band on RC rooms whose boxes modulate: init, simulate, serve, airsided and report, without any weights.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "airside/splitmix64.hpp"
#include "support/bench.hpp"
#include "support/test_folder.hpp"

namespace airside::closed_loop {
namespace {

/// The schedule's 14 degC until enough has been learned: some days.
constexpr int days_of_learning = 6;

BenchOptions band_site(const std::string& name, const std::string& topology, const std::string& room, int days) {
  return {.name = name,
          .topology = topology,
          .plant = rc_room(room, "2021-04-08"),
          .expert_days = 0,
          .days = days,
          .band = true};
}

/// Setpoints that differ from the schedule's.
int choices_of(const tools::ControlRun& run) {
  std::set<double> different;
  for (const tools::CycleSample& c : run.cycles) different.insert(c.setpoint_degc);
  return static_cast<int>(different.size());
}

std::string said_by(const std::vector<std::string>& command, const std::filesystem::path& log) {
  Child child(command, log.string());
  EXPECT_EQ(child.wait(200), 0) << child.said();
  return child.said();
}

TEST(BandOnModbus, DaemonOfFiveZonesDecidesAsTheSimulationToTheBit) {
  for (const std::string room : {"modulating-mild", "modulating-reheat-2"}) {
    SCOPED_TRACE(room);
    Bench bench(band_site("band", "5vav-0fcu-2power", room, days_of_learning + 3));
    const LogText& expected = bench.expected();
    EXPECT_GT(choices_of(bench.run()), 20) << "a run without choices proves nothing";
    bench.start_server();
    const auto daemon = bench.start_daemon();
    ASSERT_EQ(daemon->wait(200), 0) << daemon->said();
    expect_same_rows(bench.log(), expected);
  }
}

TEST(BandOnModbus, ItLearnsFromTheHistoryOfTheSchedulesDays) {
  BenchOptions options = band_site("band_history", "5vav-0fcu-2power", "modulating-mild", 2);
  options.expert_days = days_of_learning;
  Bench bench(options);
  const LogText& expected = bench.expected();
  EXPECT_GT(choices_of(bench.run()), 20) << "without its history two days are too few to choose anything";
  bench.start_server();
  const auto daemon = bench.start_daemon();
  ASSERT_EQ(daemon->wait(200), 0) << daemon->said();
  expect_same_rows(bench.log(), expected);
}

TEST(BandOnModbus, KilledDaemonsOfSeveralShapesGoOnExactly) {
  for (const std::string topology : {"5vav-0fcu-2power", "12vav-0fcu-1power", "1vav-0fcu-3power"}) {
    SCOPED_TRACE(topology);
    Bench bench(band_site("band_kill", topology, "modulating-mild", days_of_learning + 1));
    const LogText& expected = bench.expected();
    bench.start_server();
    SplitMix64 draw(5);
    const std::size_t rows = bench.rows();
    int struck = 0;
    for (std::size_t k = 1; k <= 12; ++k) {
      const std::size_t at = rows * k / 13 + draw.below(20);
      const auto daemon = bench.start_daemon();
      while (bench.logged_rows() < at) {
        ASSERT_TRUE(daemon->running()) << daemon->said();
        sleep_s(0.0005);
      }
      sleep_s(0.01 * draw.uniform());
      daemon->signal(SIGKILL);
      struck += daemon->wait(10) == 128 + SIGKILL ? 1 : 0;
    }
    EXPECT_GE(struck, 11);
    const auto daemon = bench.start_daemon();
    ASSERT_EQ(daemon->wait(200), 0) << daemon->said();
    expect_same_rows(bench.log(), expected);
  }
}

TEST(BandCommands, InitSimulateAndReportNeedNoEditAndNoWeights) {
  const hal::TestFolder folder("band_commands");
  const auto file = [&](const char* name) { return folder.file(name).string(); };
  const std::string airside = std::string(AIRSIDE_BIN_DIR) + "/airside";
  (void)said_by({airside, "init", file("site"), "--objective", "band"}, folder.file("init.txt"));
  const std::string site = file("site") + "/site.toml";
  (void)said_by({airside, "check", site}, folder.file("check.txt"));
  const std::string figures = said_by({airside,         "simulate",
                                       "--site",        site,
                                       "--plant",       "rc",
                                       "--room",        "modulating-mild",
                                       "--start",       "2021-04-08",
                                       "--expert-days", "0",
                                       "--days",        "10",
                                       "--compare",     "expert",
                                       "--log",         file("log.csv"),
                                       "--report",      file("simulated"),
                                       "--json"},
                                      folder.file("simulate.txt"));
  const auto j = nlohmann::json::parse(figures.substr(figures.find('{')), nullptr, false);
  ASSERT_FALSE(j.is_discarded()) << figures;
  EXPECT_LT(j["hvac_kwh"].get<double>(), j["compared"]["expert"]["hvac_kwh"].get<double>());
  EXPECT_NE(j["weather"].get<std::string>().find("temperate"), std::string::npos) << j["weather"];
  (void)said_by({airside, "report", file("log.csv"), "-o", file("report"), "--site", site}, folder.file("report.txt"));
  EXPECT_TRUE(std::filesystem::exists(folder.file("report") / "index.html"));
}

TEST(BandCommands, RoomsThatDoNotModulateAndWeightsThatHaveNoPartAreRefused) {
  const hal::TestFolder folder("band_refused");
  const auto file = [&](const char* name) { return folder.file(name).string(); };
  const std::string airside = std::string(AIRSIDE_BIN_DIR) + "/airside";
  (void)said_by({airside, "init", file("site"), "--objective", "band"}, folder.file("init.txt"));
  const std::string site = file("site") + "/site.toml";
  const auto refused = [&](std::vector<std::string> command, const std::vector<std::string>& words) {
    command.insert(command.begin(), airside);
    Child child(command, file("refused.txt"));
    EXPECT_EQ(child.wait(60), 1) << child.said();
    for (const std::string& word : words) EXPECT_NE(child.said().find(word), std::string::npos) << child.said();
  };
  refused({"simulate", "--site", site, "--plant", "rc", "--room", "301-real"}, {"do not modulate", "modulating-mild"});
  refused({"simulate", "--site", site, "--plant", "rc", "--room", "modulating-mild", "--transfer"},
          {"--transfer", "leave it out"});
  refused({"simulate", "--site", site, "--plant", "rc", "--room", "modulating-attic"}, {"modulating-attic", "-duct"});
  refused({"simulate", "--plant", "rc", "--room", "modulating-mild-2", "--method", "expert"},
          {"fan coil units", "5vav-0fcu-2power", "--objective band"});
  refused({"serve", "--topology", "5vav-0fcu-4power", "--plant", "rc", "--room", "modulating-mild", "--port", "0"},
          {"4 meters", "0 to 3 meters"});
}

}  // namespace
}  // namespace airside::closed_loop
