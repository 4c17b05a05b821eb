// airside-page: status and weights of the box over HTTP, beside airsided and apart from it.

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <span>
#include <string>

#include "firmware/page/auth/set_password.hpp"
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
      "airside-page serves a page for people (http://127.0.0.1:8350/) that shows what airsided is doing and why, and\n"
      "lets those who sign in release the AHU, hand it back and roll weights back. Programs find the same at\n"
      "/status.json and /metrics, take the weights that were learned (/weights.blob) and send signed ones.\n"
      "It listens where [page] of the site file says, on 127.0.0.1:8350 without it. Run it as a user of its own\n"
      "that may read the state folder and write the inbox. Nobody can sign in before a password is set here:\n"
      "  airside-page --site /etc/airside/site.toml --set-password operator\n"
      "Exit codes: 0 stopped in order, 1 bad input, 2 bad command line.",
      "airside-page"};
  app.set_version_flag("--version", hal::version_line("airside-page"));
  std::string site_path, ready_file;
  int port = -1;
  app.add_option("--site", site_path, "site file, such as /etc/airside/site.toml")->required();
  app.add_option("--port", port, "instead of the site file's; 0 for any")->check(CLI::Range(0, 65535));
  app.add_option("--ready", ready_file, "write address and port to this file once it answers");
  std::string set_role, clear_role, key_role, key_name = "no name";
  const CLI::IsMember roles({"viewer", "operator", "installer"});
  auto* set =
      app.add_option("--set-password", set_role,
                     "set the password of viewer, operator or installer and end: asked for at a terminal, else\n"
                     "one line of standard input")
          ->check(roles);
  auto* clear = app.add_option("--clear-password", clear_role, "take a role's password away and end")->check(roles);
  auto* key =
      app.add_option("--new-key", key_role, "print a key with a role's rights, for a program, and end")->check(roles);
  app.add_option("--key-name", key_name, "whose key --new-key makes, for the log")->needs(key);
  set->excludes(clear)->excludes(key);
  clear->excludes(key);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    const auto dir = [&site_path] { return hal::read_site_file(site_path, hal::site_rules()).page.dir; };
    if (!set_role.empty()) page::set_password(dir(), page::role_of(set_role));
    if (!clear_role.empty()) page::clear_password(dir(), page::role_of(clear_role));
    if (!key_role.empty()) page::new_key(dir(), page::role_of(key_role), key_name);
    if (!set_role.empty() || !clear_role.empty() || !key_role.empty()) return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "airside-page: %s\n", e.what());
    return 1;
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
    ::mkdir(site.page.dir.c_str(), 0700);  // where it cannot be made, nothing is kept, and the page says so
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
