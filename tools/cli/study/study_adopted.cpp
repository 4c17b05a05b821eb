// airside study adopted: an adopted building under its own control, constants, integral, Guideline 36, MPC and ours.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "sim/json/json_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/study/building_run.hpp"
#include "tools/study/building_table.hpp"

namespace airside::tools {

namespace {

using Kind = BuildingMethod::Kind;
constexpr std::array gains_per_h = {0.5, 1.0, 2.0, 4.0, 8.0};
constexpr int pretrain_days = 28;
constexpr int tuning_lead_days = 28;  ///< at least; tuning days are never scored

struct AdoptedCommand {
  std::vector<std::string> paths, from, starts = {"2021-07-05", "2021-10-04"}, only;
  std::string out;
  int seeds = 3, days = 14, schedule_days = 5, jobs = 2;
  bool json = false;

  /// One building in one season.
  struct Case {
    std::string path, start;
    Site site;
    CivilTime from;
  };
  /// What other days have shown of a case.
  struct Tuned {
    std::vector<BuildingFigures> constants, gains;
    BlobBytes blob;
  };
  struct Task {
    std::size_t about = 0;
    BuildingRun run;
    BuildingMethod method;
    bool pretrains = false;
  };

  std::vector<Case> cases() const {
    std::vector<Case> all;
    for (const std::string& path : paths) {
      for (const std::string& start : starts) {
        PlantChoice choice;
        choice.start = start;
        all.push_back({path, start, load_site(path), start_of(choice)});
        check_building(all.back().site);
        refuse_other_years(all.back());
      }
    }
    return all;
  }

  /// The engine's year is 2021, and each run begins in it and ends in it.
  void refuse_other_years(const Case& about) const {
    const auto midnight = [](const char* date) {
      PlantChoice choice;
      choice.start = date;
      return start_of(choice).seconds;
    };
    const std::int64_t before_days = std::max({tuning_lead_days, days, pretrain_days}) + schedule_days;
    const std::int64_t first = about.from.seconds - before_days * seconds_per_day;
    const std::int64_t last = about.from.seconds + std::int64_t{seeds} * days * seconds_per_day;
    if (first >= midnight("2021-01-01") && last <= midnight("2021-12-31")) return;
    throw hal::InputError(
        "--starts", about.start,
        fmt::format("a day with {} days of 2021 before it and {} after it", before_days, seeds * days),
        "choose another start, or fewer --seeds or --days");
  }

  /// Runs tasks in child processes; a blob comes back as its bytes, figures as JSON.
  std::vector<std::string> run_all(const std::string& what, const std::vector<Case>& list,
                                   const std::vector<Task>& tasks) const {
    Progress bar(what, tasks.size());
    auto texts = run_children(
        tasks.size(), jobs,
        [&](std::size_t i) -> std::string {
          const Task& task = tasks[i];
          const Site& site = list[task.about].site;
          if (!task.pretrains) return json_of(run_building(site, task.run, task.method)).dump();
          const BlobBytes blob = pretrain_building(site, task.run.from, pretrain_days, task.run.seed);
          return {reinterpret_cast<const char*>(blob.data()), blob.size()};
        },
        [&](std::size_t i) { return list[tasks[i].about].path; }, [&bar] { bar.advance(); });
    bar.finish();
    return texts;
  }

  BuildingRun run_of(const Case& about, int seed) const {
    BuildingRun run;
    run.from = {about.from.seconds + (seed - 1) * days * seconds_per_day};
    run.days = days;
    run.schedule_days = schedule_days;
    run.seed = static_cast<std::uint64_t>(seed);
    return run;
  }

  /// Constants, gains and weights of the days that begin four weeks before those that are scored.
  std::vector<Tuned> tune(const std::vector<Case>& list) const {
    std::vector<Task> tasks;
    for (std::size_t c = 0; c < list.size(); ++c) {
      BuildingRun run = run_of(list[c], 1);
      run.from.seconds -= std::max(tuning_lead_days, days) * seconds_per_day;
      const bool mean = list[c].site.settings.objective == Objective::mean;
      if (mean && wants(Kind::ours)) tasks.push_back({c, run_of(list[c], 1), {}, true});
      if (wants(Kind::constant)) {
        for (const double degc : building_constants(list[c].site)) tasks.push_back({c, run, {Kind::constant, degc}});
      }
      if (wants(Kind::integral)) {
        for (const double gain : gains_per_h) tasks.push_back({c, run, {Kind::integral, gain}});
      }
    }
    if (tasks.empty()) return std::vector<Tuned>(list.size());
    const auto texts = run_all(fmt::format("tuning on other days, {} runs", tasks.size()), list, tasks);
    std::vector<Tuned> tuned(list.size());
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      Tuned& t = tuned[tasks[i].about];
      const auto* bytes = reinterpret_cast<const std::byte*>(texts[i].data());
      if (tasks[i].pretrains) {
        t.blob.assign(bytes, bytes + texts[i].size());
      } else {
        auto& of_kind = tasks[i].method.kind == Kind::constant ? t.constants : t.gains;
        of_kind.push_back(figures_of(nlohmann::json::parse(texts[i])));
      }
    }
    return tuned;
  }

  static double best_gain(const Tuned& tuned) {
    if (tuned.gains.empty()) return gains_per_h.front();
    const auto better = [](const BuildingFigures& a, const BuildingFigures& b) { return a.dae_degc < b.dae_degc; };
    const auto best = std::min_element(tuned.gains.begin(), tuned.gains.end(), better);
    return gains_per_h[static_cast<std::size_t>(best - tuned.gains.begin())];
  }

  bool wants(Kind kind) const {
    return only.empty() || std::find(only.begin(), only.end(), name_of(kind)) != only.end();
  }

  std::vector<BuildingLine> lines_of(const Case& about, const Tuned& tuned) const {
    std::vector<BuildingLine> lines = {{"own control", {Kind::own}, {}}, {"schedule", {Kind::schedule}, {}}};
    for (const double degc : building_constants(about.site))
      lines.push_back({fmt::format("constant {:.1f}", degc), {Kind::constant, degc}, {}});
    const double gain = best_gain(tuned);
    lines.push_back({fmt::format("integral, {:g} 1/h", gain), {Kind::integral, gain}, {}});
    lines.push_back({"guideline-36, 16", {Kind::guideline36, 16}, {}});
    lines.push_back({"guideline-36, 18", {Kind::guideline36, 18}, {}});
    lines.push_back({"mpc", {Kind::mpc}, {}});
    const bool band = about.site.settings.objective == Objective::band;
    lines.push_back({band ? "ours, band" : "ours, mean", {Kind::ours}, {}});
    std::erase_if(lines, [this](const BuildingLine& line) { return !wants(line.method.kind); });
    return lines;
  }

  BuildingTable table_of(const Case& about, const Tuned& tuned) const {
    BuildingTable table{.site = about.path,
                        .start = about.start,
                        .meters = about.site.file.twin->names->powers,
                        .objective = about.site.settings.objective,
                        .zones = about.site.counts.vavs,
                        .constant_of_other_days = {},
                        .gain_per_h = tuned.gains.empty() ? 0 : best_gain(tuned),
                        .lines = lines_of(about, tuned)};
    if (!tuned.constants.empty()) {
      const std::size_t best = best_for(table.objective, table.zones, tuned.constants);
      table.constant_of_other_days = fmt::format("constant {:.1f}", building_constants(about.site)[best]);
    }
    return table;
  }

  std::vector<BuildingTable> compare() const {
    const std::vector<Case> list = cases();
    const std::vector<Tuned> tuned = tune(list);
    std::vector<BuildingTable> tables;
    std::vector<Task> tasks;
    for (std::size_t c = 0; c < list.size(); ++c) {
      tables.push_back(table_of(list[c], tuned[c]));
      for (const BuildingLine& line : tables.back().lines) {
        for (int seed = 1; seed <= seeds; ++seed) {
          Task task{c, run_of(list[c], seed), line.method};
          if (!tuned[c].blob.empty()) task.run.blob = &tuned[c].blob;
          tasks.push_back(task);
        }
      }
    }
    const auto texts = run_all(fmt::format("{} runs", tasks.size()), list, tasks);
    std::size_t i = 0;
    for (BuildingTable& table : tables) {
      for (BuildingLine& line : table.lines) {
        for (int seed = 0; seed < seeds; ++seed) line.runs.push_back(figures_of(nlohmann::json::parse(texts[i++])));
      }
    }
    return tables;
  }

  /// Tables of earlier runs.
  std::vector<BuildingTable> read() const {
    std::vector<BuildingTable> tables;
    for (const std::string& file : from) {
      try {
        const nlohmann::json stored = sim::read_json(file);
        for (const nlohmann::json& table : stored.at("tables")) tables.push_back(building_table_of(table));
      } catch (const nlohmann::json::exception& e) {
        throw hal::InputError(file, e.what(), "what `airside study adopted -o` wrote", "run the study again");
      }
    }
    return tables;
  }

  void run() {
    if (!out.empty()) hal::StagedFile{out};  // can it be written at all?
    if (paths.empty() == from.empty()) {
      throw hal::InputError("airside study adopted", "sites and --from at once, or neither", "one of the two",
                            "name site files, or tables of earlier runs");
    }
    const std::vector<BuildingTable> tables = from.empty() ? compare() : read();
    nlohmann::json j;
    add_program_to(j);
    j["seeds"] = seeds;
    j["days"] = days;
    for (const BuildingTable& table : tables) j["tables"].push_back(json_of(table));
    if (give_json(j, out, json)) return;
    for (const BuildingTable& table : tables) fmt::print("{}", markdown_of(table));
    fmt::print("{}", summary_of(tables));
    if (from.empty()) fmt::print("\nBy {}.\n", program_text());
  }
};

}  // namespace

void add_study_adopted(CLI::App& study) {
  auto self = std::make_shared<AdoptedCommand>();
  CLI::App* c = study.add_subcommand(
      "adopted",
      "buildings that `airside adopt` made sites of: ours beside the model's own control, constants, a tuned\n"
      "integral, Guideline 36 and MPC. Each seed is a fortnight of its own, one after the other, with its own sensor\n"
      "noise. What is tuned is tuned on the fortnight four weeks before the first one, building by building.\n"
      "Degree-hours are those of zones above cooling setpoint + 0.5 K and below heating setpoint - 0.5 K while people\n"
      "are there, sum over zones, a day. Energy is that of the site's meters.");
  c->add_option("sites", self->paths, "site files of adopted models")->check(CLI::ExistingFile);
  c->add_option("--from", self->from, "tables of earlier runs, which are printed and not measured anew")
      ->check(CLI::ExistingFile);
  c->add_option("--starts", self->starts, "first scored days, comma-separated")->delimiter(',')->capture_default_str();
  c->add_option("--seeds", self->seeds, "fortnights from each start")->check(CLI::Range(1, 20))->capture_default_str();
  c->add_option("--days", self->days, "days that are scored, a seed")->check(CLI::Range(4, 100))->capture_default_str();
  c->add_option("--schedule-days", self->schedule_days, "days under the schedule before")
      ->check(CLI::Range(1, 20))
      ->capture_default_str();
  c->add_option("--methods", self->only,
                "of " + fmt::format("{}", fmt::join(building_kinds(), ", ")) + " (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(building_kinds()));
  c->add_option("--jobs", self->jobs, "child processes at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_option("-o,--out", self->out, "JSON file with every run, for --from");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
