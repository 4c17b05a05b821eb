// airside study method and airside study all: the studies of the published method, with the published figure beside
// ours.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>

#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "hal/text/staged_file.hpp"
#include "sim/learned/environment_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/report/report.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/options/option_checks.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/study/method/claims.hpp"
#include "tools/study/method/peer_rows.hpp"
#include "tools/study/method/report.hpp"
#include "tools/study/method/results.hpp"
#include "tools/study/method/run.hpp"
#include "tools/study/method/runs_file.hpp"
#include "tools/study/method/tables.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

constexpr int least_seeds = 5;

struct MethodCommand {
  MethodStudy study;
  std::vector<std::string> table_names;
  std::vector<MethodTable> tables;
  int first_seed = 1, seeds = 5, jobs = 2;
  bool json = false, report_only = false, always_reports = false;
  std::vector<std::string> peer_files;
  std::string report_folder, keep_file;
  std::vector<std::string> from_files;

  fs::path file_of(const MethodJob& job) const { return fs::path(study.folder) / (job.name() + ".json"); }

  std::string run_job(const MethodJob& job) const {
    nlohmann::json j = run_method_job(study, job);
    add_program_to(j);
    hal::StagedFile file(file_of(job).string());
    file.write(j.dump(1) + "\n");
    file.commit();
    return "";
  }

  /// Those that start from weights wait until the others have made them.
  void run_missing(const std::vector<MethodJob>& list) const {
    Progress bar(fmt::format("{} runs", list.size()), list.size());
    for (std::size_t begin = 0; begin < list.size();) {
      std::size_t end = begin;
      while (end < list.size() && list[end].seed == list[begin].seed) ++end;
      for (const bool waits : {false, true}) {
        std::vector<MethodJob> part;
        for (std::size_t i = begin; i < end; ++i) {
          const bool starts = !list[i].source_name().empty() || list[i].row->work == MethodWork::offline;
          if (starts == waits) part.push_back(list[i]);
        }
        (void)run_children(
            part.size(), jobs, [&](std::size_t i) { return run_job(part[i]); },
            [&](std::size_t i) { return part[i].name(); }, [&bar] { bar.advance(); });
      }
      begin = end;
    }
    bar.finish();
  }

  /// A row that is missing and starts from weights which the folder lacks needs the pretraining again.
  std::vector<MethodJob> missing_jobs() const {
    std::vector<MethodJob> all = method_jobs(study, tables, first_seed, seeds);
    std::set<std::string> wanted;
    for (const MethodJob& job : all) {
      if (fs::exists(file_of(job))) continue;
      wanted.insert(job.name());
      for (const std::string& source : job.sources()) {
        if (!fs::exists(fs::path(study.folder) / (source + ".blob"))) wanted.insert(source);
      }
    }
    std::erase_if(all, [&wanted](const MethodJob& job) { return !wanted.contains(job.name()); });
    return all;
  }

  /// What repeats the page.
  std::string command() const {
    std::string text = fmt::format("airside study {} --plant {} --seeds {} -o {}", always_reports ? "all" : "method",
                                   study.kind, seeds, hal::shell_word(study.folder));
    if (!peer_files.empty()) text += " --peers " + hal::shell_word(fmt::format("{}", fmt::join(peer_files, ",")));
    return text;
  }

  void report() const {
    const MethodResults results = MethodResults::read(study);
    const nlohmann::json found = method_tables_of(results);
    PeerRows peers;
    for (const std::string& file : peer_files) add_peer_rows(peers, file);
    const std::vector<ClaimVerdict> claims = judge_claims(results, peers);
    if (!report_folder.empty() || always_reports) {
      const fs::path folder = report_folder.empty() ? fs::path(study.folder) / "report" : fs::path(report_folder);
      const auto files = write_report(folder / "index.html", method_report(study, results, peers, claims, command()));
      if (!json) fmt::print(stderr, "page: {}, and {} pictures beside it\n", files.front().string(), files.size() - 1);
    }
    if (json) {
      nlohmann::json j{{"study", study.facts()},
                       {"tables", found},
                       {"claims", json_of(claims)},
                       {"runs", results.runs()},
                       {"seeds", results.seeds()}};
      add_program_to(j);
      fmt::print("{}\n", j.dump());
      return;
    }
    for (const nlohmann::json& table : found) fmt::print("{}\n", method_table_markdown(table));
    fmt::print("{}\n{} runs of {} seed{} in {}; mean ± sd over rooms and seeds. By {}.\n", claims_markdown(claims),
               results.runs(), results.seeds(), results.seeds() == 1 ? "" : "s", study.folder, program_text());
    if (results.seeds() < least_seeds) {
      fmt::print("The rules of the claims ask for {} seeds at least: these verdicts are provisional.\n", least_seeds);
    }
  }

  void run() {
    for (int t = 0; t < method_tables; ++t) {
      const auto table = static_cast<MethodTable>(t);
      const bool named = std::ranges::find(table_names, text_of(table)) != table_names.end();
      const bool all = table_names.empty() && (study.environment.empty() || runs_in_environment(table));
      if (named || all) tables.push_back(table);
    }
    for (const MethodTable table : tables) {
      if (study.environment.empty() || runs_in_environment(table)) continue;
      throw hal::InputError(std::string("--tables ") + text_of(table), "a table of several rooms, and --environment",
                            "control, score, ablation", "leave one of them out");
    }
    if (!study.environment.empty()) {
      study.environment_from = sim::environment_start(study.environment);
      (void)sim::read_environment(study.environment, built_in_site().counts);
    }
    const bool is_new = !fs::exists(study.folder);
    if (report_only && from_files.empty() && is_new) {
      throw hal::InputError("-o " + study.folder, "no such folder", "one with runs to report on",
                            "correct the name, or leave --report-only out");
    }
    fs::create_directories(study.folder);
    try {
      for (const std::string& file : from_files) (void)take_runs(study, file);
      if (!report_only) run_missing(missing_jobs());
    } catch (...) {
      std::error_code kept;
      if (is_new) fs::remove(study.folder, kept);  // only where nothing is in it
      throw;
    }
    if (!keep_file.empty()) (void)keep_runs(study, keep_file);
    report();
  }
};

void add_options(CLI::App* c, const std::shared_ptr<MethodCommand>& self) {
  c->add_option("--plant", self->study.kind, "rc or energyplus")
      ->check(CLI::IsMember({"rc", "energyplus"}))
      ->capture_default_str();
  c->add_option("--seeds", self->seeds, "seeds a row and room")->check(CLI::Range(1, 100))->capture_default_str();
  c->add_option("--first-seed", self->first_seed, "the others follow it")->check(seed_check())->capture_default_str();
  c->add_option("--days", self->study.days, "controlled days")->check(CLI::Range(1, 60))->capture_default_str();
  c->add_option("--pretrain-days", self->study.pretrain_days, "days in the twin")
      ->check(CLI::Range(2, 180))
      ->capture_default_str();
  c->add_option("--operated-days", self->study.operated_days, "days of the room that others learn from")
      ->check(CLI::Range(2, 80))
      ->capture_default_str();
  c->add_option("--summer-days", self->study.summer_days, "logged days, offline comparison")
      ->check(CLI::Range(1, 90))
      ->capture_default_str();
  c->add_option("--winter-days", self->study.winter_days, "logged days, offline comparison")
      ->check(CLI::Range(1, 90))
      ->capture_default_str();
  c->add_option("--steps", self->study.steps, "optimiser steps of fine-tuning")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  c->add_option("--jobs", self->jobs, "child processes at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_option("--from", self->from_files,
                "files of runs that --keep wrote: those that the folder lacks are put there")
      ->check(CLI::ExistingFile);
  c->add_option("--keep", self->keep_file, "write all runs of the folder into this one file, without weights");
  c->add_option("--peers", self->peer_files,
                "what tools/gym/method_peers control --json and transfer --json printed, comma-separated")
      ->delimiter(',')
      ->check(CLI::ExistingFile);
  c->add_option("--report", self->report_folder, "folder for a page with tables, pictures and verdicts");
  c->add_flag("--report-only", self->report_only, "run nothing: tables and verdicts of what the folder has");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->add_option("-o,--out", self->study.folder, "folder for the runs")->required();
  c->callback([self] { self->run(); });
}

}  // namespace

void add_study_method(CLI::App& study) {
  auto self = std::make_shared<MethodCommand>();
  CLI::App* c = study.add_subcommand(
      "method",
      "the studies of the published method (preset `paper`), the published figure beside ours, a verdict on each "
      "claim.\n"
      "A run is one row, room and seed, and one JSON file of --out; runs that the folder has are left out, so a study "
      "that\nwas stopped goes on. A run takes 10 s to 4 min of one core, all rows of a seed about an hour.\n"
      "Tables: control (Fig. 7), score (Table IV), ablation (V), physics, pretraining (Fig. 9), deployment (11, 12), "
      "data\n(schedule days before control), neighbours (13), offline (Table VI), cycle (Fig. 10: 6 to 24 "
      "min, preset `product` too).");
  std::vector<std::string> names;
  for (int t = 0; t < method_tables; ++t) names.emplace_back(text_of(static_cast<MethodTable>(t)));
  c->add_option("--environment", self->study.environment,
                "a learned environment (tools/learn_environment) in the place of room 301; tables control, score and "
                "ablation");
  c->add_option("--tables", self->table_names, "which, comma-separated (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  add_options(c, self);
}

void add_study_all(CLI::App& study) {
  auto self = std::make_shared<MethodCommand>();
  self->always_reports = true;
  CLI::App* c = study.add_subcommand(
      "all",
      "every study of the published method as one page (OUT/report/index.html, or --report): tables III to VII and "
      "figures 7 to 13\n"
      "with the printed figures beside ours, and a verdict on each of 24 claims. Runs what the folder lacks, as "
      "airside "
      "study method\n"
      "does; other learners (Table VII, OSLN, DDQN, FATDM, DAF) come from tools/gym/method_peers by --peers.");
  add_options(c, self);
}

}  // namespace airside::tools
