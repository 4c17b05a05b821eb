// airside, as the box has it: look at the daemon, give it weights and wishes. Training and simulation stay on the host.

#include <cstdio>

#include "hal/system/version.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/finish_output.hpp"

int main(int argc, char** argv) {
  using namespace airside;
  CLI::App app{
      "airside on the box: what airsided is doing, and a word to it. Site file and point map are checked by\n"
      "`airsided --check --site /etc/airside/site.toml`; training and simulation are done on another machine,\n"
      "by the program of the same name.\n\n"
      "Exit codes: 0 done, 1 bad input, 2 a command line that cannot be understood.",
      "airside"};
  app.set_version_flag("--version", hal::version_line("airside") + " (box)");
  app.require_subcommand(1);
  tools::add_doctor(app);
  tools::add_probe(app);
  tools::add_status(app);
  tools::add_watch(app);
  tools::add_weights(app);
  try {
    app.parse(argc, argv);
    return tools::finish_output(0);
  } catch (const CLI::RuntimeError& e) {  // a command with exit codes of its own
    return tools::finish_output(e.get_exit_code());
  } catch (const CLI::ParseError& e) {
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands().empty()) {
      std::fprintf(stderr, "airside: the box has no command \"%s\"; airside --help lists those it has\n", argv[1]);
      return 2;
    }
    return tools::finish_output(app.exit(e) == 0 ? 0 : 2);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "airside: %s\n", e.what());
    return 1;
  }
}
