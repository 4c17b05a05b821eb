// airside-page: status and weights of the box over HTTP, beside airsided and apart from it.

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <span>
#include <string>

#include "firmware/page/page_server.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/storage/atomic_file.hpp"
#include "hal/system/version.hpp"
#include "hal/text/input_error.hpp"

namespace {

volatile std::sig_atomic_t stop_requested = 0;
extern "C" void request_stop(int) { stop_requested = 1; }

/// Nothing here needs more than this; what breaks in finds less.
void give_up_rights() {
  ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  const rlimit descriptors{96, 96}, no_core{0, 0};
  ::setrlimit(RLIMIT_NOFILE, &descriptors);
  ::setrlimit(RLIMIT_CORE, &no_core);
  ::setpriority(PRIO_PROCESS, 0, 10);  // control first
}

}  // namespace

int main(int argc, char** argv) {
  using namespace airside;
  CLI::App app{
      "airside-page serves what airsided is doing (GET /status.json) and the weights that it has learned\n"
      "(GET /weights.blob), and takes signed weights (POST /weights) into the daemon's inbox.\n"
      "It listens where [page] of the site file says, on 127.0.0.1:8350 without it. Run it as a user of its own\n"
      "that may read the state folder and write the inbox. Exit codes: 0 stopped in order, 1 bad input, 2 bad\n"
      "command line.",
      "airside-page"};
  app.set_version_flag("--version", hal::version_line("airside-page"));
  std::string site_path, ready_file;
  int port = -1;
  app.add_option("--site", site_path, "site file, such as /etc/airside/site.toml")->required();
  app.add_option("--port", port, "instead of the site file's; 0 for any")->check(CLI::Range(0, 65535));
  app.add_option("--ready", ready_file, "write address and port to this file once it answers");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  sigset_t stops, before;
  sigemptyset(&stops);
  sigaddset(&stops, SIGTERM);
  sigaddset(&stops, SIGINT);
  ::sigprocmask(SIG_BLOCK, &stops, &before);  // until it waits: none can be missed
  struct sigaction action {};
  action.sa_handler = request_stop;
  ::sigaction(SIGTERM, &action, nullptr);
  ::sigaction(SIGINT, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    hal::SiteFile site = hal::read_site_file(site_path, hal::site_rules());
    if (port >= 0) site.page.port = port;
    give_up_rights();
    page::PageServer server(site);
    std::fprintf(stderr, "airside-page: %s of \"%s\" at %s port %d%s\n", site.page.tls_cert.empty() ? "HTTP" : "HTTPS",
                 site.name.c_str(), site.page.listen.c_str(), server.port(),
                 ::geteuid() == 0 ? "; it runs as root, which it need not" : "");
    if (!ready_file.empty()) {
      const std::string text = site.page.listen + ':' + std::to_string(server.port()) + '\n';
      if (!hal::write_file_atomically(ready_file, std::as_bytes(std::span(text)), hal::Sync::none)) {
        throw hal::InputError("--ready " + ready_file, "a file that cannot be written", "a writable path",
                              "choose another");
      }
    }
    server.run(stop_requested, before);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "airside-page: %s\n", e.what());
    return 1;
  }
}
