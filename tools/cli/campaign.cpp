// airside campaign and airside library: hand over to the Python programs that run many of these, on one machine or on a
// cluster, and that keep what comes of them.

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/text/input_error.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {

namespace {

struct CampaignOptions {
  std::string file, address;
  int jobs = 0;
  bool serial = false, list = false, example = false, json = false;
};

std::vector<std::string> words_to(const char* program) {
  return {program, "--program", std::filesystem::read_symlink("/proc/self/exe").string()};
}

std::vector<std::string> words_of(const CampaignOptions& options) {
  std::vector<std::string> words = words_to("airside-campaign");
  if (!options.address.empty()) words.insert(words.end(), {"--address", options.address});
  if (options.jobs > 0) words.insert(words.end(), {"--jobs", std::to_string(options.jobs)});
  if (options.serial) words.emplace_back("--serial");
  if (options.list) words.emplace_back("--list");
  if (options.example) words.emplace_back("--example");
  if (options.json) words.emplace_back("--json");
  if (!options.file.empty()) words.insert(words.end(), {"--", options.file});
  return words;
}

void hand_over(const char* command, std::vector<std::string> words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execvp(argv.front(), argv.data());
  throw hal::InputError(command, fmt::format("no program {} that can be run ({})", words.front(), std::strerror(errno)),
                        "the Python package of tools/campaign", "pip install ./tools/campaign");
}

}  // namespace

void add_campaign(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("campaign",
                         "run many of these commands from one file, on this machine or on a Ray cluster.\n"
                         "Jobs that are done are left out: a campaign that was stopped goes on with the same command.\n"
                         "The Python package of tools/campaign does it (docs/campaigns.md).");
  const auto options = std::make_shared<CampaignOptions>();
  command->add_option("file", options->file, "campaign.toml");
  command->add_option("--address", options->address, "HOST:PORT of a Ray cluster (default: this machine)");
  command->add_option("--jobs", options->jobs, "processes on this machine (default: its cores)")
      ->check(CLI::Range(1, 4096));
  command->add_flag("--serial", options->serial, "one after the other, without Ray");
  command->add_flag("--list", options->list, "run nothing: each job, its key, whether it is done, its command");
  command->add_flag("--example", options->example, "print a campaign file to begin with");
  command->add_flag("--json", options->json, "print one JSON object and nothing else on standard output");
  command->callback([options] { hand_over("airside campaign", words_of(*options)); });
}

void add_weight_library(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "library",
      "keep weight blobs with a signed index: who trained them on what, how good they are, what they "
      "were made from.\n"
      "airside library add, find, show, lineage, revoke, get, check; airside library add --help "
      "tells more.\n"
      "The Python package of tools/campaign does it (docs/campaigns.md).");
  command->prefix_command();
  command->callback([command] {
    std::vector<std::string> words = words_to("airside-library");
    const std::vector<std::string> given = command->remaining();
    words.insert(words.end(), given.begin(), given.end());
    hand_over("airside library", std::move(words));
  });
}

}  // namespace airside::tools
