#include "tools/cli/gap/gap_output.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/text/shell_word.hpp"
#include "hal/text/staged_folder.hpp"
#include "tools/cli/command.hpp"
#include "tools/gap/map/mapping.hpp"
#include "tools/gap/report/gap_report.hpp"
#include "tools/gap/run/detectable.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/report/report.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

void say(const gap::GapRun& run, const nlohmann::json& j, const RunFacts& facts) {
  if (!run.request.source.reference_log.empty()) print_clean_up(stdout, run.loaded.logs.reference);
  print_clean_up(stdout, run.loaded.logs.measured);
  for (const gap::AddedDays& added : run.added) print_clean_up(stdout, added.log);
  fmt::print("{}\n", gap::sentence_of(run));
  for (const gap::CandidateBeforeAfter& c : gap::candidates_before_after(run))
    fmt::print("  {:<28} gain {:>6.0f} -> {:>6.0f} (limit {:.0f})\n", c.id, c.before, c.after, c.limit);
  for (const gap::Finding& f : run.verdict.findings) {
    fmt::print("  {}: gain {:.0f} (limit {:.0f}), {:.1f} x the next; on site: {}\n", f.at.id(), f.log_likelihood_ratio,
               f.log_likelihood_limit, std::min(f.margin, 999.0), f.at.effect->confirm);
  }
  for (const gap::Finding& f : run.verdict.unsure) {
    fmt::print("  {}: not sure, {}: gain {:.0f} (limit {:.0f}); on site: {}\n", f.at.id(), f.why_not,
               f.log_likelihood_ratio, f.log_likelihood_limit, f.at.effect->confirm);
  }
  for (std::size_t i = 0; i < run.verdict.posteriors.size(); ++i)
    fmt::print("{}", gap::text_of(run.verdict.posteriors[i], run.verdict.alternatives[i]));
  if (run.heat) {
    for (const gap::ZoneHeat& z : run.heat->zones) {
      if (!z.text.empty()) fmt::print("  {}\n", z.text);
    }
  }
  fmt::print("{}", gap::suspicions_text(run));
  if (!run.experiments.empty()) {
    const fs::path folder = fs::path(j["report"].get<std::string>()).parent_path();
    fmt::print("when that test is done: airside gap next {} --measured LOG --test {}\n",
               hal::shell_word(folder.string()), hal::shell_word(run.experiments.front().name));
  }
  const auto& days = j["locked_days"];
  const auto figure = [&days](const char* when, const char* what) { return days[when][what].get<double>(); };
  fmt::print(
      "locked days ({}): temperatures {:.2f} -> {:.2f} K, powers {:.2f} -> {:.2f} kW (the twin as given: "
      "{:.2f} K, {:.2f} kW)\n",
      days["days"].get<int>(), figure("before", "temp_rmse_k"), figure("after", "temp_rmse_k"),
      figure("before", "power_rmse_kw"), figure("after", "power_rmse_kw"), figure("given", "temp_rmse_k"),
      figure("given", "power_rmse_kw"));
  if (!run.loaded.engine->plays_commands()) {
    const std::string invisible = gap::invisible_text(gap::detectable_sizes(run));
    if (const std::string& map = run.request.source.map; !map.empty())
      fmt::print("{}\n", fmt::join(gap::lines_of(gap::read_mapping(map)), "\n"));
    fmt::print("{}\n", gap::own_control_text(*run.loaded.engine));
    if (!invisible.empty()) fmt::print("{}\n", invisible);
    for (const gap::NotApplicable& n : run.not_applicable) fmt::print("not applicable: {}: {}\n", n.id, n.why);
  }
  if (run.retraining) fmt::print("{}{}\n", gap::text_of(*run.retraining), gap::sentence_of(*run.retraining));
  fmt::print("by {}\n", text_of(facts));
  for (const auto& file : j["files"]) fmt::print("{}\n", file.get<std::string>());
}

}  // namespace

void print_clean_up(std::FILE* to, const gap::CleanLog& log) { fmt::print(to, "{}", gap::text_of(log)); }

nlohmann::json write_gap_folder(const gap::GapRun& run, const RunFacts& facts, const GapFolder& to) {
  const fs::path folder = to.out;
  hal::StagedFolder staged(folder);
  nlohmann::json j;
  j["report"] = (folder / "index.html").string();
  std::vector<std::string> files{j["report"], (folder / "gap.json").string()};
  if (run.patched) {
    const auto write = [&](const char* name, const nlohmann::json& content) {
      gap::write_whole_file(staged.path() / name, content.dump(1) + "\n");
      files.push_back((folder / name).string());
      return files.back();
    };
    j["patch"] = write("twin-patch.json", run.patched->patch);
    j["ledger"] = write("ledger.json", gap::ledger_of(run));
    if (!to.apply.empty()) {
      j["applied"] = to.apply;
      files.insert(files.end(), {to.apply, to.apply + ".ledger.json"});
    }
    if (to.patched_room) write("patched-room.json", run.patched->after);
  }
  j["files"] = files;
  j.update(gap::json_of(run));
  tools::add_to(j, facts);
  gap::write_whole_file(staged.path() / "gap.json", gap::readable_text(j));
  write_report(staged.path() / "index.html", make_gap_report(run));
  staged.commit("index.html", {"twin-patch.json", "ledger.json", "patched-room.json"});
  return j;
}

void print_gap(const gap::GapRun& run, const nlohmann::json& j, const RunFacts& facts, bool json) {
  if (json)
    fmt::print("{}\n", j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  else
    say(run, j, facts);
}

}  // namespace airside::tools
