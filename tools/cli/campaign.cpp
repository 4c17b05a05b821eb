// airside campaign, library and fleet: hand over to the Python programs that run many of these, on one machine or on a
// cluster, that keep what comes of them, and that send it to many boxes.

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

namespace {

struct LibraryOption {
  const char *name, *what;
  const char* value = "";  ///< what its value is called in the help
};
struct LibraryAction {
  const char *name, *what;
  bool writes;
  LibraryOption positional;
  std::vector<LibraryOption> options, flags;
};

const std::vector<LibraryAction>& library_actions() {
  static const std::vector<LibraryAction> all{
      {"add",
       "add blobs, or all that a campaign's folder has, with what is known of them",
       true,
       {"FILE", "*.blob, or a folder that `airside campaign` left"},
       {{"--room", "whose room or which building"},
        {"--twin", "what it was trained on, such as a model's name"},
        {"--data", "the days that it has learned from, 2021-07-01..2021-07-31"},
        {"--by", "who trained it (default: the key's name)"},
        {"--parent", "weights that it was made from; may be given again"},
        {"--effect", "an effect that the twin has; may be given again"},
        {"--figure", "NAME=NUMBER, how good it was; may be given again"}},
       {}},
      {"find",
       "list weights, newest first; those that are revoked, or made from such, only with --all",
       false,
       {nullptr, nullptr},
       {{"--topology", "such as 5vav-5fcu-2power"},
        {"--room", "part of the room's name"},
        {"--effect", "an effect that the twin must have"}},
       {{"--all", "revoked ones too"}}},
      {"show", "all that is known of weights", false, {"DIGEST", "its first 8 or more digits"}, {}, {}},
      {"lineage",
       "what weights were made from, and what was made from them",
       false,
       {"DIGEST", "its first 8 or more digits"},
       {},
       {}},
      {"revoke",
       "mark weights as not to be used, and with them all that was made from them",
       true,
       {"DIGEST", "the first 8 or more digits of each"},
       {{"--why", "in words, for whoever asks later"}},
       {}},
      {"get",
       "write a blob to a file; one that is revoked only with --revoked",
       false,
       {"DIGEST", "its first 8 or more digits"},
       {{"-o,--out", "the file"}},
       {{"--revoked", "though it is revoked, to look into"}}},
      {"check", "read every blob and compare it with the index", false, {nullptr, nullptr}, {}, {}},
  };
  return all;
}

/// What was given to `action`, as it was given.
std::vector<std::string> words_given(const CLI::App& action) {
  std::vector<std::string> words{action.get_name()}, places;
  for (const CLI::Option* option : action.get_options()) {
    if (option->count() == 0) continue;
    if (option->get_positional()) {
      places.insert(places.end(), option->results().begin(), option->results().end());
    } else if (option->get_expected_max() == 0) {
      words.push_back(option->get_single_name().size() == 1 ? "-" + option->get_single_name()
                                                            : "--" + option->get_single_name());
    } else {
      for (const std::string& value : option->results()) {
        words.push_back("--" + option->get_single_name());
        words.push_back(value);
      }
    }
  }
  if (!places.empty()) words.emplace_back("--");
  words.insert(words.end(), places.begin(), places.end());
  return words;
}

void add_library_action(CLI::App& library, const LibraryAction& action) {
  CLI::App* command = library.add_subcommand(action.name, action.what);
  command->add_option("--library",
                      "folder, or what fsspec knows, such as s3://bucket/weights (default: "
                      "$AIRSIDE_LIBRARY, else ./library)");
  command->add_option("--keys",
                      "public keys that are believed: a .pub file, or a folder of them (default: "
                      "$AIRSIDE_LIBRARY_KEYS, else the .pub beside --key, else ./keys)");
  command->add_option("--at-least", "refuse an index of a lower serial number: somebody put it back");
  if (action.writes) command->add_option("--key", "secret key that signs the index (airside keygen)")->required();
  for (const LibraryOption& option : action.options) command->add_option(option.name, option.what)->take_all();
  for (const LibraryOption& flag : action.flags) command->add_flag(flag.name)->description(flag.what);
  command->add_flag("--json")->description("print one JSON object and nothing else on standard output");
  const auto places = std::make_shared<std::vector<std::string>>();
  if (action.positional.name != nullptr)
    command->add_option(action.positional.name, *places, action.positional.what)->required();
  command->callback([command, places] {
    std::vector<std::string> words = words_to("airside-library");
    const std::vector<std::string> given = words_given(*command);
    words.insert(words.end(), given.begin(), given.end());
    hand_over("airside library", std::move(words));
  });
}

}  // namespace

void add_weight_library(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "library",
      "keep weight blobs with a signed index: who trained them on what, how good they are, what they were made from.\n"
      "The Python package of tools/campaign does it (docs/campaigns.md).");
  command->require_subcommand(1);
  for (const LibraryAction& action : library_actions()) add_library_action(*command, action);
}

namespace {

struct FleetAction {
  const char *name, *what;
  std::vector<LibraryOption> places, options, flags;
};

const std::vector<FleetAction>& fleet_actions() {
  static const LibraryOption by{"--by", "for the ledger (default: the user's name)", "NAME"};
  static const std::vector<FleetAction> all{
      {"push",
       "send signed weights to every box, in waves; the same command goes on after a stop",
       {{"file", "fleet.toml"}},
       {{"--blob", "the weights, signed and for any site", "FILE"},
        {"--from-library", "the weights, from a library: first 8 or more digits", "DIGEST"},
        {"--library", "whose revoked weights are refused (default: $AIRSIDE_LIBRARY, else none)", "ADDRESS"},
        {"--library-keys", "whose index is believed (default: $AIRSIDE_LIBRARY_KEYS, else ./keys)", "PLACE"},
        {"--at-least", "refuse an index of a lower serial number: somebody put it back", "SERIAL"},
        by},
       {{"--dry-run", "check everything, print the waves, send nothing"},
        {"--example", "print a fleet file to begin with"}}},
      {"status",
       "ask every box what it does and what became of pushed weights; with the last push",
       {{"file", "fleet.toml"}},
       {},
       {}},
      {"undo",
       "let every box of a push return to the weights before it",
       {{"file", "fleet.toml"}, {"DIGEST", "of the pushed weights: its first 8 or more digits"}},
       {by},
       {}},
  };
  return all;
}

void add_fleet_action(CLI::App& fleet, const FleetAction& action) {
  CLI::App* command = fleet.add_subcommand(action.name, action.what);
  for (const LibraryOption& place : action.places) command->add_option(place.name)->description(place.what);
  for (const LibraryOption& option : action.options)
    command->add_option(option.name)->description(option.what)->type_name(option.value);
  for (const LibraryOption& flag : action.flags) command->add_flag(flag.name)->description(flag.what);
  command->add_flag("--json")->description("print one JSON object and nothing else on standard output");
  command->callback([command] {
    std::vector<std::string> words = words_to("airside-fleet");
    const std::vector<std::string> given = words_given(*command);
    words.insert(words.end(), given.begin(), given.end());
    hand_over("airside fleet", std::move(words));
  });
}

}  // namespace

void add_fleet(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "fleet",
      "send signed weights to many boxes: a canary share first, then waves; it halts when trials end in rollbacks.\n"
      "The Python package of tools/campaign does it (docs/fleet.md).");
  command->require_subcommand(1);
  for (const FleetAction& action : fleet_actions()) add_fleet_action(*command, action);
}

}  // namespace airside::tools
