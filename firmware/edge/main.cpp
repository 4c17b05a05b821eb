// airsided: the daemon on the box beside the AHU.

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "firmware/edge/any_daemon.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/system/version.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"

namespace {

volatile std::sig_atomic_t stop_requested = 0;
extern "C" void request_stop(int) { stop_requested = 1; }

int run(int argc, char** argv) {
  using namespace airside;
  // First of all: a stop during a long start must end in order too.
  std::signal(SIGTERM, request_stop);
  std::signal(SIGINT, request_stop);
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app{
      "airsided controls one air handling unit over Modbus and goes on learning from it.\n"
      "It reads the site file, resumes from its state folder (or starts from the weight blob, or runs the\n"
      "schedule if there is none), and once a control cycle (18 min, or as the site has it)\n"
      "chooses the supply-air temperature setpoint.\n"
      "While the plant does not answer at the start, it waits. Exit codes: 0 stopped in order, 1 bad input,\n"
      "2 bad command line.",
      "airsided"};
  app.set_version_flag("--version", hal::version_line("airsided"));
  std::string site_path, until;
  edge::DaemonOptions options;
  bool check_only = false, no_sync = false;
  app.add_option("--site", site_path, "site file, such as /etc/airside/site.toml")->required();
  app.add_option("--until", until, "stop at this local time, such as 2021-08-20T00:00:00");
  app.add_flag("--check", check_only,
               "read site, points, weights, history and keys, say whether they are in order, list the keys, and stop");
  app.add_flag("--no-sync", no_sync, "do not force state to the disk each row; for simulations");
  app.add_option("--backoff", options.backoff_first_s, "first wait after a lost link, s")
      ->check(CLI::Range(0.01, 60.0));
  app.add_option(
         "--crash-limit", options.crash_limit,
         "this many starts within ten minutes are a crash loop, after which the schedule runs for an hour; 0: never")
      ->check(CLI::Range(0, 8));
  app.add_option("--clock-speed", options.clock_speed,
                 "let the system clock run N times as fast from the start on, beside `airside serve --speed`; started\n"
                 "again, it goes on from the last row; for measurements")
      ->check(CLI::Range(1.0, 10000.0));
  app.add_option("--stall", options.stall_s, "how long a simulated plant's clock may stand still, s")
      ->check(CLI::Range(1.0, 1e6));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    const hal::SiteFile site = hal::read_site_file(site_path, hal::site_rules());
    if (!site.modbus) {
      throw hal::InputError(site_path + ": [modbus]", "no such section", "how to reach the AHU",
                            "add [modbus] with host or device and points");
    }
    const hal::PointMap points = hal::PointMap::load(site.modbus->points);
    hal::refuse_contradiction(site, points);  // before the topology's check, whose advice is a stand-in
    if (no_sync) options.sync = hal::Sync::none;
    if (!until.empty()) {
      options.until = hal::parse_civil_text(until);
      if (!options.until) {
        throw hal::InputError("--until", "'" + until + "'", "a local time such as 2021-08-20T00:00:00", "correct it");
      }
    }
    const auto daemon = edge::make_daemon(site, points, options, hal::StopFlag(&stop_requested));
    if (!daemon) {
      throw hal::InputError(site_path + ": topology", "'" + site.topology + "'", "a topology of this build",
                            "build with it in AIRSIDE_TOPOLOGIES");
    }
    if (check_only) {
      const std::string keys = daemon->check();
      std::printf("%s: site, points, weights, history and keys are in order\nkeys: %s\n", site_path.c_str(),
                  keys.c_str());
      return 0;
    }
    daemon->start();
    return daemon->run();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "airsided: %s\n", e.what());
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {  // no memory for the command line's own words
    std::fprintf(stderr, "airsided: %s\n", e.what());
    return 1;
  }
}
