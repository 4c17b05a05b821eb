// airside-mqtt: what the box is doing, for an MQTT broker and Home Assistant, beside airsided and apart from it.

#include <sys/prctl.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <string>

#include "firmware/mqtt/publisher.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/system/version.hpp"
#include "hal/text/input_error.hpp"

namespace {

volatile std::sig_atomic_t stop_requested = 0;
extern "C" void request_stop(int) { stop_requested = 1; }
extern "C" void end_a_wait(int) {}

/// Nothing here needs more than this; what breaks in finds less.
void give_up_rights() {
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  const rlimit descriptors{32, 32}, no_core{0, 0};
  ::setrlimit(RLIMIT_NOFILE, &descriptors);
  ::setrlimit(RLIMIT_CORE, &no_core);
  ::setpriority(PRIO_PROCESS, 0, 10);  // control first
}

void take_signals() {
  struct sigaction action {};  // without SA_RESTART: a signal ends whatever is waited for
  action.sa_handler = request_stop;
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGINT, &action, nullptr);
  action.sa_handler = end_a_wait;
  ::sigaction(SIGALRM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

enum class Job { publish, check, list, forget };

int run(const std::string& site_path, Job job) {
  using namespace airside;
  const hal::SiteFile site = hal::read_site_file(site_path, hal::site_rules());
  if (!site.mqtt) {
    throw hal::InputError(site_path + ": [mqtt]", "no such table", "the broker to publish to",
                          "add [mqtt] with host; docs/mqtt.md has an example");
  }
  if (job == Job::list) {
    for (const mqtt::Message& message : mqtt::discovery(site)) {
      std::printf("%s\t%s\n", message.topic.c_str(), message.payload.c_str());
    }
    std::printf("%s\n%s\n", mqtt::status_topic(*site.mqtt).c_str(), mqtt::availability_topic(*site.mqtt).c_str());
    return std::fflush(stdout) == 0 ? 0 : 1;
  }
  if (const std::string warning = hal::warning_of(*site.mqtt); !warning.empty()) {
    std::fprintf(stderr, "airside-mqtt: %s: %s\n", site_path.c_str(), warning.c_str());
  }
  give_up_rights();
  take_signals();
  mqtt::Publisher publisher(site);
  if (job == Job::publish) {
    publisher.run(stop_requested);
    return 0;
  }
  const bool forget = job == Job::forget;
  const std::string wrong =
      publisher.send_once(forget ? mqtt::withdrawal(site) : std::vector<mqtt::Message>{}, stop_requested);
  if (!wrong.empty()) {
    std::fprintf(stderr, "airside-mqtt: %s\n", wrong.c_str());
    return 1;
  }
  std::printf(forget ? "%s port %d: what was retained of \"%s\" is withdrawn\n"
                     : "%s port %d: the broker takes airside-mqtt of \"%s\"\n",
              site.mqtt->host.c_str(), site.mqtt->port, site.name.c_str());
  return std::fflush(stdout) == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "airside-mqtt publishes what airsided is doing to the MQTT broker of [mqtt] in the site file: the status as\n"
      "JSON, whether it is fresh, and the documents by which Home Assistant finds both. It subscribes to nothing: no\n"
      "command comes this way. Run it as a user of its own that may read the state folder. A broker that is away is\n"
      "tried again after 1 s, then 2, 4 and so on up to every minute; the newest status counts.\n"
      "Exit codes: 0 stopped in order, or done; 1 bad input, or a broker that --check or --forget could not reach;\n"
      "2 bad command line.",
      "airside-mqtt"};
  app.set_version_flag("--version", airside::hal::version_line("airside-mqtt"));
  std::string site_path;
  bool check = false, list = false, forget = false;
  app.add_option("--site", site_path, "site file, such as /etc/airside/site.toml")->required();
  app.add_flag("--check", check, "connect once, publish nothing, say whether the broker takes us");
  app.add_flag("--list", list, "connect to nothing; print topics and discovery documents, tab between");
  app.add_flag("--forget", forget,
               "take everything off the broker that it retains of this site, and end;\n"
               "for a box that is taken away, or before topic_prefix changes");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  if (int{check} + int{list} + int{forget} > 1) {
    std::fprintf(stderr, "airside-mqtt: found two of --check, --list, --forget; expected one; run them one by one\n");
    return 2;
  }
  try {
    return run(site_path, check ? Job::check : list ? Job::list : forget ? Job::forget : Job::publish);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "airside-mqtt: %s\n", e.what());
    return 1;
  }
}
