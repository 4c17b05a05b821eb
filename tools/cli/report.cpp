// airside report: from logs, of the box or of simulations, to the page that people look at.

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <thread>

#include "airside/supervision/schedule.hpp"
#include "hal/text/shell_word.hpp"
#include "hal/text/unfinished.hpp"
#include "tools/cli/command.hpp"
#include "tools/report/charts/report_text.hpp"
#include "tools/report/logged_method.hpp"
#include "tools/report/report.hpp"
#include "tools/report/run_record.hpp"
#include "tools/report/zone_band.hpp"
#include "tools/run/run_facts.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

/// Whether every applied setpoint is the schedule's.
bool follows_schedule(const Site& site, const ControlRun& run) {
  for (const CycleSample& c : run.cycles) {
    if (std::abs(c.setpoint_degc - expert_setpoint_degc(site.settings, c.time)) > site.settings.round_k) return false;
  }
  return true;
}

MethodResult::Kind kind_of(const Site& site, const LoggedMethod& m, bool charted) {
  if (charted) return MethodResult::Kind::ours;
  if (m.name.starts_with("floor-")) return MethodResult::Kind::floor;
  return follows_schedule(site, m.run) ? MethodResult::Kind::schedule : MethodResult::Kind::peer;
}

std::string period_text(const hal::Log& log) {
  return fmt::format("{} to {}, {} rows, {} missing", minute_text(log.summary.first), minute_text(log.summary.last),
                     log.summary.rows, log.summary.missing_rows);
}

/// The page as a picture, by an installed browser. Returns what hindered it, or "".
std::string picture_of(const fs::path& page, const fs::path& png) {
  const std::string shot = "--screenshot=" + png.string(), url = "file://" + fs::absolute(page).string();
  for (const char* browser : {"chromium", "chromium-browser", "google-chrome"}) {
    std::vector<std::string> words = {browser,
                                      "--headless",
                                      "--no-sandbox",
                                      "--disable-gpu",
                                      "--hide-scrollbars",
                                      "--window-size=1280,4500",
                                      "--virtual-time-budget=4000",
                                      shot,
                                      url};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&quiet, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t child = 0;
    const int failed = posix_spawnp(&child, browser, &quiet, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&quiet);
    if (failed != 0) continue;
    const hal::UnfinishedChild unfinished(child);
    int status = -1;
    for (int tenths = 0; waitpid(child, &status, WNOHANG) == 0; ++tenths) {
      if (tenths == 600) kill(child, SIGKILL);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    std::error_code ignored;
    if (status == 0 && fs::exists(png, ignored)) return "";
    return fmt::format("{} did not draw the page", browser);
  }
  return "no browser is installed; apt-get install chromium";
}

struct ReportCommand {
  SiteOptions site;
  std::vector<std::string> logs, names;
  std::string out = "report";
  bool png = false, json = false;

  std::string again() const {
    std::string text = "airside report";
    for (const std::string& log : logs) text += " " + hal::shell_word(log);
    text += " -o " + hal::shell_word(out);
    for (const std::string& name : names) text += " --name " + hal::shell_word(name);
    if (!site.path.empty()) text += " --site " + hal::shell_word(site.path);
    if (!site.preset.empty()) text += " --preset " + site.preset;
    if (site.path.empty()) text += " --topology " + site.topology;
    return text;
  }

  void run() const {
    const Site s = make_site(site);
    const std::vector<LoggedMethod> methods = read_logged_methods(s, group_logs(logs, names));
    const LoggedMethod& charted = methods.front();
    RunRecord record = make_run_record(s, charted.run);
    record.plant = "as logged in " + charted.place();
    record.versions = program_text();
    record.command = again();
    std::vector<std::string> other_days;
    for (const LoggedMethod& m : methods) {
      record.methods.push_back({m.name, kind_of(s, m, &m == &charted), {m.metrics}});
      record.more_facts.push_back({"log of " + m.name, m.place() + ": " + period_text(m.log)});
      const hal::LogSummary &a = charted.log.summary, &b = m.log.summary;
      if (a.first.day() != b.first.day() || a.last.day() != b.last.day()) other_days.push_back(m.name);
    }
    if (!other_days.empty()) {
      const std::string note = fmt::format("{} on other days than {}", fmt::join(other_days, ", "), charted.name);
      record.more_facts.push_back({"not on the same days", note});
      fmt::print(stderr, "note: {}; the table compares unlike weather\n", note);
    }
    const fs::path page = fs::path(out) / "index.html";
    const std::vector<fs::path> files = write_report(page, make_run_report(record));
    std::string picture, hindrance;
    if (png) {
      picture = (fs::path(out) / "report.png").string();
      hindrance = picture_of(page, picture);
      if (!hindrance.empty()) fmt::print(stderr, "no picture: {}\n", hindrance);
    }
    if (json) {
      nlohmann::json j = {{"page", page.string()}, {"files", files.size()}};
      add_program_to(j);
      for (const LoggedMethod& m : methods) {
        nlohmann::json figures = json_of(m.metrics);
        figures["log"] = m.place();
        figures["files"] = m.paths;
        figures["rows"] = m.log.summary.rows;
        figures["missing_rows"] = m.log.summary.missing_rows;
        if (const ZoneBand band = zone_band(s, m.run.rows); !band.zones.empty()) {
          figures["zone_degree_hours_above_per_day_degch"] = band.above_degch_per_day();
          if (band.shows_heating) figures["zone_degree_hours_below_per_day_degch"] = band.below_degch_per_day();
          if (!band.dampers.empty()) figures["boxes_fully_open_per_day_h"] = band.saturated_h_per_day();
        }
        j["methods"][m.name] = figures;
      }
      if (png) j["picture"] = hindrance.empty() ? nlohmann::json(picture) : nlohmann::json();
      fmt::print("{}\n", j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
      return;
    }
    print_figures_header();
    for (const LoggedMethod& m : methods) print_figures(m.name, m.metrics);
    fmt::print("report: {} and {} charts beside it\n", page.string(), files.size() - 1);
    if (png && hindrance.empty()) fmt::print("picture: {}\n", picture);
  }
};

}  // namespace

void add_report(CLI::App& app) {
  auto self = std::make_shared<ReportCommand>();
  CLI::App* c = app.add_subcommand("report",
                                   "draw logs as one HTML page with charts and a table.\n"
                                   "The first log is charted; the others are compared with it in the table.\n"
                                   "A box's daily files of one folder, such as log/*.csv, are one log.");
  c->add_option("logs", self->logs, "CSV logs, or folders of daily ones")->required();
  c->add_option("-o,--out", self->out, "folder for index.html and its SVG charts")->capture_default_str();
  c->add_option("--name", self->names,
                "name of a method, once for each in order (default: the file's or folder's); with more names than "
                "methods, once for each file, and files of one name are one method")
      ->allow_extra_args(false);
  add_site_options(*c, self->site);
  c->add_flag("--png", self->png, "also a picture of the page, by an installed chromium");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
