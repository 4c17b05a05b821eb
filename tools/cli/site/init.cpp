// airside init: a site file and a point map to start from, complete and already in order.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <vector>

#include "airside/topology.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/storage/atomic_file.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/site/ask/init_answers.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

void write(const fs::path& path, const std::string& text) {
  const auto written = hal::write_file_atomically(path.string(), std::as_bytes(std::span(text)));
  if (!written) {
    throw hal::InputError(path.string(), hal::describe(written.error()), "a folder that can be written",
                          "choose another folder");
  }
}

extern "C" void say_that_it_stopped(int) {
  constexpr char word[] = "\nstopped; nothing was written\n";
  static_cast<void>(!::write(STDERR_FILENO, word, sizeof word - 1));
  ::_exit(128 + SIGINT);
}

/// While questions are asked Ctrl-C says what became of the answers, and ends the program.
class StopWord {
 public:
  StopWord() {
    ::sigaction(SIGINT, nullptr, &before_);
    if (before_.sa_handler == SIG_IGN) return;
    struct sigaction action {};
    action.sa_handler = say_that_it_stopped;
    ::sigemptyset(&action.sa_mask);
    ::sigaction(SIGINT, &action, nullptr);
  }
  ~StopWord() { ::sigaction(SIGINT, &before_, nullptr); }
  StopWord(const StopWord&) = delete;
  StopWord& operator=(const StopWord&) = delete;

 private:
  struct sigaction before_ {};
};

/// Makes the folder and a file in it, and takes both away: what only a try can say, before anything is asked.
void try_folder(const std::string& folder) {
  std::error_code error;
  fs::path whole = fs::absolute(folder).lexically_normal();
  if (whole.filename().empty()) whole = whole.parent_path();
  std::vector<fs::path> made;
  for (fs::path p = whole; p.has_relative_path() && !fs::exists(fs::symlink_status(p, error)); p = p.parent_path()) {
    made.push_back(p);
  }
  fs::create_directories(whole, error);
  if (!error) {
    std::string trial = (whole / ".airside-init-XXXXXX").string();
    const int file = ::mkstemp(trial.data());
    if (file < 0) error.assign(errno, std::generic_category());
    if (file >= 0) ::close(file), ::unlink(trial.c_str());
  }
  std::error_code ignored;
  for (const fs::path& p : made) fs::remove(p, ignored);
  if (!error) return;
  throw hal::InputError(folder, error.message(), "a folder that can be made and written", "choose another folder");
}

struct InitCommand {
  std::string folder, topology, name = "Room 301", objective = "mean";
  std::string answers;
  bool force = false, json = false, ask = false;

  bool band() const { return objective == "band"; }

  std::string site_text() const {
    std::string text = hal::example_site_text(topology, band() ? Objective::band : Objective::mean);
    const std::string standard = "\"Room 301\"", own = '"' + name + '"';
    for (std::size_t at = text.find(standard); at != std::string::npos; at = text.find(standard, at + own.size())) {
      text.replace(at, standard.size(), own);
    }
    return text;
  }

  /// What the site's readers say of answers from a file, at the place of the file.
  template <class Make>
  auto of_answers(Make&& make) const {
    try {
      return make();
    } catch (const hal::InputError& e) {
      if (ask || e.place().starts_with(answers)) throw;
      throw hal::InputError(answers + ", which would give " + e.place(), e.found(), e.expected(), e.remedy());
    }
  }

  InitAnswers asked() const {
    try_folder(folder);
    const StopWord stop;
    return ask_answers(std::cin, std::cerr);
  }

  /// Site file and point map from a person's answers; checked whole before a byte is written.
  void write_answered() {
    refuse_existing({fs::path(folder) / "site.toml", fs::path(folder) / "points.csv"});
    const InitAnswers a = ask ? asked() : read_answers(answers);
    const fs::path dir = folder, site = dir / "site.toml", points = dir / "points.csv", kept = dir / "answers.toml";
    const std::string site_text = site_text_of(a), points_text = points_text_of(a);
    of_answers([&] {
      const hal::SiteFile parsed = hal::parse_site_text(site_text, site.string(), hal::site_rules());
      const hal::PointMap map = hal::PointMap::parse(points_text, points.string());
      hal::refuse_contradiction(parsed, map);
      map.check_topology(a.vavs, a.fcus, a.powers, parsed.stand_ins);
    });
    make_folder({site, points});
    write(site, site_text);
    write(points, points_text);
    write(kept, text_of(a));
    const std::vector<std::string> made_up = unsaid_signals(a);
    if (json) {
      fmt::print(
          "{}\n",
          nlohmann::json{
              {"site", site.string()}, {"points", points.string()}, {"answers", kept.string()}, {"made_up", made_up}}
              .dump());
      return;
    }
    fmt::print("wrote {}, {} and {}\n", site.string(), points.string(), kept.string());
    if (!made_up.empty()) {
      fmt::print("Not in the answers, so {}: {}.\n  Say where each is, or absent = true.\n",
                 a.bacnet ? "taken for absent (heartbeat: the gateway's own)" : "at registers of the simulated AHU",
                 fmt::join(made_up, ", "));
    }
    fmt::print("Next, none of them writes to the AHU:\n");
    for (const char* command : {"check", "doctor", "probe"}) {
      const bool later = a.bacnet && std::string_view(command) == "probe";
      fmt::print("  airside {} {}{}\n", command, hal::shell_word(site.string()),
                 later ? "   # once airside-bacnet runs (docs/bacnet.md)" : "");
    }
  }

  void refuse_existing(const std::vector<fs::path>& files) const {
    for (const fs::path& path : files) {
      if (fs::exists(path) && !force) {
        throw hal::InputError(path.string(), "a file that is already there",
                              "a folder without site.toml and points.csv",
                              "choose another folder, or give --force to overwrite both");
      }
    }
  }

  /// Refuses to overwrite, and makes the folder.
  void make_folder(const std::vector<fs::path>& files) const {
    refuse_existing(files);
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
      throw hal::InputError(folder, error.message(), "a folder that can be made", "choose another folder");
    }
  }

  void run() {
    if (ask || !answers.empty()) return write_answered();
    if (topology.empty()) topology = band() ? "5vav-0fcu-2power" : "5vav-5fcu-2power";
    if (name.empty() || name.find_first_of("\"\\\n\r") != std::string::npos) {
      throw hal::InputError("--name", "'" + name + "'", "a name without quotes, backslashes and line ends",
                            "use letters, digits, spaces and - . , _ / ( )");
    }
    if (band() && parse_shape(topology.c_str()).powers == 0) {
      throw hal::InputError("--topology", topology + " beside --objective band", "at least one power meter",
                            "band learns energy from a meter: name a topology such as 5vav-0fcu-1power, or take mean");
    }
    const fs::path site = fs::path(folder) / "site.toml", points = fs::path(folder) / "points.csv";
    const std::string text = site_text();
    static_cast<void>(hal::parse_site_text(text, site.string(), hal::site_rules()));
    make_folder({site, points});
    write(site, text);
    const hal::TopologyCounts counts = built_in_site(topology).counts;
    write(points, hal::default_point_map(counts.vavs, counts.fcus, counts.powers, {}, band()));
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"site", site.string()}, {"points", points.string()}}.dump());
      return;
    }
    fmt::print("wrote {} and {}\n", site.string(), points.string());
    fmt::print("Edit both to match the room: targets and schedule in the first, registers in the second. Then:\n");
    fmt::print("  airside check {}\n", hal::shell_word(site.string()));
  }
};

}  // namespace

void add_init(CLI::App& app) {
  auto self = std::make_shared<InitCommand>();
  CLI::App* c = app.add_subcommand("init", "write a site file and a point map to start from");
  c->add_option("folder", self->folder, "where; it is made if it is not there")->required();
  c->add_option("--topology", self->topology,
                "VAV boxes, fan coil units, power meters (default: 5vav-5fcu-2power; for band 5vav-0fcu-2power)")
      ->check(a_topology());
  c->add_option("--objective", self->objective,
                "mean: hold the mean room temperature; band: boxes modulate and show their dampers, least energy with "
                "zones\nin their band")
      ->check(CLI::IsMember({"mean", "band"}))
      ->capture_default_str();
  c->add_option("--name", self->name, "of the room")->capture_default_str();
  CLI::Option* given =
      c->add_option("--answers", self->answers,
                    "TOML file of answers: counts, bus, limits, and where the signals are (docs/formats.md)")
          ->check(CLI::ExistingFile);
  CLI::Option* asked =
      c->add_flag("--ask", self->ask, "ask for them instead; answers.toml in the folder repeats it")->excludes(given);
  for (const char* other : {"--topology", "--objective", "--name"}) {
    given->excludes(other);
    asked->excludes(other);
  }
  c->add_flag("--force", self->force, "overwrite what is there");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
