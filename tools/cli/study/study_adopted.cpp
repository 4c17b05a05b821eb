// airside study adopted: an adopted building under its own control, constants, integral, Guideline 36, MPC and ours.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/study/building_run.hpp"

namespace airside::tools {

namespace {

using Kind = BuildingMethod::Kind;
constexpr std::array gains_per_h = {0.5, 1.0, 2.0, 4.0, 8.0};
constexpr int pretrain_days = 28;
constexpr int tuning_lead_days = 28;  ///< at least; tuning days are never scored

constexpr std::array<std::pair<const char*, Kind>, 7> kind_names = {{{"own", Kind::own},
                                                                     {"schedule", Kind::schedule},
                                                                     {"constants", Kind::constant},
                                                                     {"integral", Kind::integral},
                                                                     {"guideline-36", Kind::guideline36},
                                                                     {"mpc", Kind::mpc},
                                                                     {"ours", Kind::ours}}};
std::string name_of(Kind kind) {
  for (const auto& [name, of] : kind_names) {
    if (of == kind) return name;
  }
  return {};
}
std::vector<std::string> all_kind_names() {
  std::vector<std::string> names;
  for (const auto& [name, kind] : kind_names) names.emplace_back(name);
  return names;
}

struct AdoptedCommand {
  std::vector<std::string> paths, starts = {"2021-07-05", "2021-10-04"}, only;
  std::string out;
  int seeds = 3, days = 14, schedule_days = 5, jobs = 2;
  bool json = false;

  /// One building in one season.
  struct Case {
    std::string path, start;
    Site site;
    CivilTime from;
  };
  struct Line {
    std::string name;
    BuildingMethod method;
    std::vector<BuildingFigures> runs;
  };
  struct Table {
    Case about;
    std::vector<Line> lines;
    std::string constant_of_other_days;
    double gain_per_h = 0;
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

  std::vector<Line> lines_of(const Case& about, const Tuned& tuned) const {
    std::vector<Line> lines = {{"own control", {Kind::own}, {}}, {"schedule", {Kind::schedule}, {}}};
    for (const double degc : building_constants(about.site))
      lines.push_back({fmt::format("constant {:.1f}", degc), {Kind::constant, degc}, {}});
    const double gain = best_gain(tuned);
    lines.push_back({fmt::format("integral, {:g} 1/h", gain), {Kind::integral, gain}, {}});
    lines.push_back({"guideline-36, 16", {Kind::guideline36, 16}, {}});
    lines.push_back({"guideline-36, 18", {Kind::guideline36, 18}, {}});
    lines.push_back({"mpc", {Kind::mpc}, {}});
    const bool band = about.site.settings.objective == Objective::band;
    lines.push_back({band ? "ours, band" : "ours, mean", {Kind::ours}, {}});
    std::erase_if(lines, [this](const Line& line) { return !wants(line.method.kind); });
    return lines;
  }

  std::vector<Table> compare() const {
    const std::vector<Case> list = cases();
    const std::vector<Tuned> tuned = tune(list);
    std::vector<Table> tables;
    std::vector<Task> tasks;
    for (std::size_t c = 0; c < list.size(); ++c) {
      const auto constants = building_constants(list[c].site);
      tables.push_back({list[c], lines_of(list[c], tuned[c]),
                        tuned[c].constants.empty()
                            ? ""
                            : fmt::format("constant {:.1f}", constants[best_for(list[c].site, tuned[c].constants)]),
                        tuned[c].gains.empty() ? 0 : best_gain(tuned[c])});
      for (const Line& line : tables.back().lines) {
        for (int seed = 1; seed <= seeds; ++seed) {
          Task task{c, run_of(list[c], seed), line.method};
          if (!tuned[c].blob.empty()) task.run.blob = &tuned[c].blob;
          tasks.push_back(task);
        }
      }
    }
    const auto texts = run_all(fmt::format("{} runs", tasks.size()), list, tasks);
    std::size_t i = 0;
    for (Table& table : tables) {
      for (Line& line : table.lines) {
        for (int seed = 0; seed < seeds; ++seed) line.runs.push_back(figures_of(nlohmann::json::parse(texts[i++])));
      }
    }
    return tables;
  }

  template <class Figure>
  static Spread spread(const Line& line, Figure figure) {
    std::vector<double> values;
    for (const BuildingFigures& f : line.runs) values.push_back(figure(f));
    return spread_of(values);
  }

  /// Whether ours and something simple are there.
  static bool has_verdict(const Table& table) {
    return table.lines.size() > 1 && table.lines.back().method.kind == Kind::ours &&
           table.lines.front().method.kind != Kind::mpc;
  }

  /// Of the lines that need no learning (and, with `hindsight` false, no knowledge of the scored days) the best one.
  static const Line& best_simple(const Table& table, bool hindsight) {
    std::vector<BuildingFigures> means;
    std::vector<const Line*> lines;
    for (const Line& line : table.lines) {
      const bool constant = line.method.kind == Kind::constant;
      if (line.method.kind == Kind::ours || line.method.kind == Kind::mpc) continue;
      if (constant && !hindsight && line.name != table.constant_of_other_days) continue;
      BuildingFigures mean;
      mean.dae_degc = spread(line, [](const auto& f) { return f.dae_degc; }).mean;
      mean.above_degch = spread(line, [](const auto& f) { return f.outside_degch(); }).mean;
      mean.kwh_per_day = {spread(line, [](const auto& f) { return f.total_kwh(); }).mean};
      means.push_back(mean);
      lines.push_back(&line);
    }
    return *lines[best_for(table.about.site, means)];
  }

  /// Ours less a simple one, run by run: the objective's figure, and degree-hours outside the band.
  struct Verdict {
    std::string rival;
    Spread value, outside_degch;
  };
  static Verdict verdict(const Table& table, bool hindsight) {
    const Line& simple = best_simple(table, hindsight);
    const Line& ours = table.lines.back();
    const bool band = table.about.site.settings.objective == Objective::band;
    std::vector<double> value, outside;
    for (std::size_t i = 0; i < ours.runs.size(); ++i) {
      const BuildingFigures &a = ours.runs[i], &b = simple.runs[i];
      value.push_back(band ? 100 * (a.total_kwh() / std::max(1e-9, b.total_kwh()) - 1) : a.dae_degc - b.dae_degc);
      outside.push_back(a.outside_degch() - b.outside_degch());
    }
    return {simple.name, spread_of(value), spread_of(outside)};
  }

  static std::string sentence(const Table& table, bool hindsight) {
    const Verdict v = verdict(table, hindsight);
    const bool band = table.about.site.settings.objective == Objective::band;
    return fmt::format("  ours less {}{}: {:+.{}f} +- {:.{}f} {}, {:+.2f} +- {:.2f} degree-hours a day\n", v.rival,
                       hindsight ? " (best in hindsight)" : " (best simple)", v.value.mean, band ? 1 : 3, v.value.sd,
                       band ? 1 : 3, band ? "% energy" : "degC DAE", v.outside_degch.mean, v.outside_degch.sd);
  }

  static void print(const Table& table) {
    const auto& meters = table.about.site.file.twin->names->powers;
    fmt::print("{}, from {}; meters: {}\n", table.about.path, table.about.start, fmt::join(meters, ", "));
    fmt::print("  {:<20} {:>18}  {:>14}  {:>14}  {:>5}  {:>15}  {:>5}  {:>5}  kWh a day by meter\n", "method",
               "kWh a day", "above", "below", "open", "DAE", "DARV", "setp");
    for (const Line& line : table.lines) {
      const Spread total = spread(line, [](const auto& f) { return f.total_kwh(); });
      const Spread above = spread(line, [](const auto& f) { return f.above_degch; });
      const Spread below = spread(line, [](const auto& f) { return f.below_degch; });
      const Spread dae = spread(line, [](const auto& f) { return f.dae_degc; });
      std::string by_meter;
      for (std::size_t m = 0; m < line.runs.front().kwh_per_day.size(); ++m) {
        by_meter += fmt::format(" {:.1f}", spread(line, [m](const auto& f) { return f.kwh_per_day[m]; }).mean);
      }
      const bool own = line.method.kind == Kind::own;  // its setpoint is no point of the site
      const auto shown = [&](double value) { return own ? std::string("-") : fmt::format("{:.2f}", value); };
      fmt::print(
          "  {:<20} {:9.1f} +- {:5.1f}  {:6.2f} +- {:4.2f}  {:6.2f} +- {:4.2f}  {:5.1f}  {:6.3f} +- {:5.3f}  {:>5}  "
          "{:>5} {}{}\n",
          line.name, total.mean, total.sd, above.mean, above.sd, below.mean, below.sd,
          spread(line, [](const auto& f) { return f.saturated_h; }).mean, dae.mean, dae.sd,
          shown(spread(line, [](const auto& f) { return f.darv_degc; }).mean),
          shown(spread(line, [](const auto& f) { return f.setpoint_degc; }).mean), by_meter,
          line.name == table.constant_of_other_days ? "  <- by other days" : "");
    }
    if (has_verdict(table)) fmt::print("{}{}", sentence(table, false), sentence(table, true));
  }

  static nlohmann::json json_of_verdict(const Verdict& v) {
    return {{"rival", v.rival},
            {"mean", v.value.mean},
            {"sd", v.value.sd},
            {"outside_degch_mean", v.outside_degch.mean},
            {"outside_degch_sd", v.outside_degch.sd}};
  }

  static nlohmann::json json_of_table(const Table& table) {
    nlohmann::json methods = nlohmann::json::array();
    for (const Line& line : table.lines) {
      nlohmann::json runs = nlohmann::json::array();
      for (const BuildingFigures& f : line.runs) runs.push_back(json_of(f));
      methods.push_back({{"method", line.name}, {"runs", runs}});
    }
    nlohmann::json j = {
        {"site", table.about.path},
        {"start", table.about.start},
        {"meters", table.about.site.file.twin->names->powers},
        {"objective", table.about.site.settings.objective == Objective::band ? "band" : "mean"},
        {"constant_of_other_days", table.constant_of_other_days},
        {"integral_gain_per_h", table.gain_per_h > 0 ? nlohmann::json(table.gain_per_h) : nlohmann::json()},
        {"methods", methods}};
    if (has_verdict(table)) {
      j["against_simple"] = json_of_verdict(verdict(table, false));
      j["against_hindsight"] = json_of_verdict(verdict(table, true));
    }
    return j;
  }

  void run() {
    if (!out.empty()) hal::StagedFile{out};  // can it be written at all?
    const std::vector<Table> tables = compare();
    nlohmann::json j;
    add_program_to(j);
    j["seeds"] = seeds;
    j["days"] = days;
    for (const Table& table : tables) j["tables"].push_back(json_of_table(table));
    if (give_json(j, out, json)) return;
    for (const Table& table : tables) print(table);
    fmt::print("\nBy {}.\n", program_text());
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
  c->add_option("sites", self->paths, "site files of adopted models")->required()->check(CLI::ExistingFile);
  c->add_option("--starts", self->starts, "first scored days, comma-separated")->delimiter(',')->capture_default_str();
  c->add_option("--seeds", self->seeds, "fortnights from each start")->check(CLI::Range(1, 20))->capture_default_str();
  c->add_option("--days", self->days, "days that are scored, a seed")->check(CLI::Range(4, 100))->capture_default_str();
  c->add_option("--schedule-days", self->schedule_days, "days under the schedule before")
      ->check(CLI::Range(1, 20))
      ->capture_default_str();
  c->add_option("--methods", self->only,
                "of " + fmt::format("{}", fmt::join(all_kind_names(), ", ")) + " (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(all_kind_names()));
  c->add_option("--jobs", self->jobs, "child processes at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_option("-o,--out", self->out, "JSON file with every run");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
