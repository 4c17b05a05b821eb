// airside: the host's program. One file a subcommand (tools/cli/*.cpp).

#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include "hal/text/toml_section.hpp"
#include "hal/text/unfinished.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/finish_output.hpp"
#include "tools/run/run_facts.hpp"

int main(int argc, char** argv) {
  using namespace airside;
  CLI::App app{
      "airside trains, tries and explains learning control of an air handling unit.\n\n"
      "A first run:\n"
      "  airside pretrain --room 301 -o room301.blob          train on the twin of room 301\n"
      "  airside simulate --room 301-real --expert-days 5 --days 14 --weights room301.blob \\\n"
      "                   --transfer --report out/            try it on the room that differs from the twin\n\n"
      "Every command that computes takes --json. Exit codes: 0 done, 1 bad input or a run that failed,\n"
      "2 a command line that cannot be understood.",
      "airside"};
  app.set_version_flag("--version", tools::program_text());
  app.require_subcommand(1);
  tools::add_check(app);
  tools::add_init(app);
  tools::add_doctor(app, tools::look_at_host);
  tools::add_adopt(app);
  tools::add_tags(app);
  tools::add_pretrain(app);
  tools::add_residual(app);
  tools::add_transfer(app);
  tools::add_simulate(app);
  tools::add_serve(app);
  tools::add_chaos(app);
  tools::add_study(app);
  tools::add_campaign(app);
  tools::add_weight_library(app);
  tools::add_fleet(app);
  tools::add_blob(app);
  tools::add_report(app);
  tools::add_footprint(app);
  tools::add_probe(app);
  tools::add_status(app);
  tools::add_watch(app);
  tools::add_weights(app, tools::send_over_http);
  tools::add_pull(app);
  tools::add_gap(app);
  tools::add_completion(app);
  // A limit on the size of files is a complaint like any other, not the end of the program.
  std::signal(SIGXFSZ, SIG_IGN);
  hal::clean_up_on_signals();
  try {
    app.parse(argc, argv);
    return tools::finish_output(0);
  } catch (const CLI::RuntimeError& e) {  // a command with exit codes of its own
    return tools::finish_output(e.get_exit_code());
  } catch (const CLI::ParseError& e) {
    if (argc > 1 && argv[1][0] != '-' && app.get_subcommands().empty()) {
      std::vector<std::string> known;
      for (const CLI::App* command : app.get_subcommands({})) known.push_back(command->get_name());
      const std::string near = hal::nearest_name(argv[1], known);
      std::fprintf(stderr, "airside: found no command \"%s\"; %sairside --help lists them\n", argv[1],
                   near.empty() ? "" : ("did you mean " + near + "? ").c_str());
      return 2;
    }
    return tools::finish_output(app.exit(e) == 0 ? 0 : 2);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "airside: %s\n", e.what());
    return 1;
  }
}
