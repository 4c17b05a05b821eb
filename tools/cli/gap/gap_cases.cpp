// airside gap run-cases and test-cases: verdicts on a folder of cases, the tests that they propose done on the hidden
// rooms, and verdicts anew.

#include <fmt/format.h>

#include <cstdio>
#include <map>
#include <mutex>
#include <optional>

#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "sim/json/json_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/gap/gap.hpp"
#include "tools/gap/blind/blind_tests.hpp"
#include "tools/gap/case/case_loader.hpp"
#include "tools/gap/case/case_tests.hpp"
#include "tools/gap/model/parallel.hpp"
#include "tools/gap/model/patched_model.hpp"
#include "tools/gap/run/proposed_tests.hpp"
#include "tools/gap/run/tested_case.hpp"
#include "tools/gap/surrogate/asked_model.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

struct RunCasesCommand : GapOptions {
  std::string folder, out = "verdicts.json", cache;
  bool go_on = false, propose = false, after_tests = false, no_reference = false;
  std::optional<int> buildings;

  using Done = std::function<void(const fs::path&, nlohmann::json)>;
  using Found = std::map<fs::path, nlohmann::json>;

  /// Verdicts of an earlier run on these cases.
  Found found_before(const std::vector<fs::path>& folders) const {
    Found found;
    if ((!go_on && !after_tests) || !fs::exists(out)) return found;
    const nlohmann::json before = sim::read_json(out);
    const auto list = before.find("verdicts");
    if (list == before.end() || !list->is_array())
      throw hal::InputError(out, "no list of verdicts", "what run-cases wrote",
                            "leave --continue out, or name another -o");
    for (const nlohmann::json& one : *list) {
      const auto at = std::find_if(folders.begin(), folders.end(), [&one](const fs::path& path) {
        return one.is_object() && one.value("case", "") == path.filename().string();
      });
      if (at == folders.end())
        throw hal::InputError(out, "a verdict on " + one.value("case", "no case"), "one of the cases in " + folder,
                              "leave --continue out, or name another -o");
      found[*at] = one;
    }
    return found;
  }

  /// One bad log among hundreds of cases is a verdict too.
  std::optional<gap::LoadedCase> load(const fs::path& path, const Done& done) const {
    const std::string name = path.filename().string();
    try {
      gap::CaseDescription c = gap::read_case(path);
      if (no_reference) c.reference_log.clear();
      return gap::load_case(c, name, cache);
    } catch (const gap::RefusedLog& e) {
      fmt::print(stderr, "{}: refused: {}\n", name, e.what());
      done(path, gap::refused_json(name, e.what()));
      return std::nullopt;
    }
  }

  gap::Rules rules(const gap::Engine& engine) const {
    gap::Rules rules;
    rules.buildings = buildings.value_or(engine.usual_buildings());
    return rules;
  }

  void judge(const fs::path& path, const gap::LoadedCase& c, const std::vector<sim::Effect>& list,
             const Done& done) const {
    gap::AskedModel asked(*c.engine);
    gap::WindowResponses responses = asked.responses(gap::library_of(asked.engine(), list), c.data, 1);
    const gap::Verdict verdict = asked.analyse(c.data, responses, rules(asked.engine()));
    nlohmann::json j = gap::json_of(verdict, c.name, responses.test, c.engine->channels());
    if (propose && gap::proposes_tests(verdict)) {
      j["experiments"] =
          gap::proposals_json(gap::proposed_tests(asked.engine(), c.data.test, verdict, responses.test, 1));
    }
    done(path, std::move(j));
  }

  void keep(const Found& found) const {
    nlohmann::json verdicts = nlohmann::json::array();
    for (const auto& [name, one] : found) verdicts.push_back(one);
    gap::write_whole_file(out, nlohmann::json{{"format", 1}, {"verdicts", verdicts}}.dump(1) + "\n");
  }

  void judge_all(const std::vector<fs::path>& folders, const std::vector<sim::Effect>& list, Found& found) const {
    std::vector<fs::path> open;
    for (const fs::path& path : folders) {
      if (!found.contains(path)) open.push_back(path);
    }
    std::mutex mutex;
    Progress bar(fmt::format("{} cases", open.size()), open.size());
    const Done done = [&](const fs::path& path, nlohmann::json verdict) {
      const std::lock_guard lock(mutex);
      found[path] = std::move(verdict);
      keep(found);  // what is known is kept if the run is ended
      bar.advance();
    };
    gap::in_parallel(open.size(), jobs, [&](std::size_t i) {
      if (const auto c = load(open[i], done)) judge(open[i], *c, list, done);
    });
    bar.finish();
  }

  static std::size_t judged_tests(const nlohmann::json& verdict) {
    const auto judged = verdict.find("after_tests");
    if (judged == verdict.end() || judged->empty()) return 0;
    return judged->back().value("tests", nlohmann::json::array()).size();
  }

  /// The second verdict stands beside the first, which stays as it is.
  void judge_tested(const std::vector<fs::path>& folders, const std::vector<sim::Effect>& list, Found& found) const {
    std::vector<fs::path> waiting;
    for (const fs::path& path : folders) {
      const std::size_t tests = gap::read_case_tests(path).size();
      if (tests == 0) continue;
      if (!found.contains(path)) {
        throw hal::InputError(path.string(), "no verdict of its measured days in " + out, "a verdict before the tests",
                              "judge them first: airside gap run-cases --propose --continue");
      }
      if (tests > judged_tests(found.at(path))) waiting.push_back(path);
    }
    std::mutex mutex;
    Progress bar(fmt::format("{} cases after tests", waiting.size()), waiting.size());
    gap::in_parallel(waiting.size(), jobs, [&](std::size_t i) {
      nlohmann::json verdict = gap::judge_with_tests(waiting[i], list, cache, 1, propose, buildings);
      const std::lock_guard lock(mutex);
      found[waiting[i]]["after_tests"].push_back(std::move(verdict));
      keep(found);
      bar.advance();
    });
    bar.finish();
  }

  /// How often each verdict was drawn, the last one of each case.
  static std::map<std::string, int> count_of(const Found& found) {
    std::map<std::string, int> count;
    for (const auto& [path, verdict] : found) {
      const bool tested = judged_tests(verdict) > 0;
      ++count[(tested ? verdict["after_tests"].back() : verdict).value("verdict", "")];
    }
    return count;
  }

  void run() const {
    require_writable("--out", out, false);
    if (after_tests && !fs::exists(out)) {
      throw hal::InputError(out, "no file", "the verdicts of the measured days, which are kept",
                            "judge them first: airside gap run-cases --propose");
    }
    const auto list = effects();
    const auto folders = gap::case_folders(folder);
    Found found = found_before(folders);
    if (after_tests)
      judge_tested(folders, list, found);
    else
      judge_all(folders, list, found);
    const std::map<std::string, int> count = count_of(found);
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"cases", folders.size()}, {"verdicts", out}, {"count", count}}.dump());
      return;
    }
    for (const auto& [kind, n] : count) fmt::print("{:>5} {}\n", n, kind);
    fmt::print("verdicts: {}\n", out);
  }
};

struct TestCasesCommand : GapOptions {
  std::string folder, verdicts = "verdicts.json", key = "blind-key.json", site, cache;
  int most_tests = 1;

  void run() const {
    const auto list = effects();
    gap::BlindTests tests;
    tests.folder = folder;
    tests.key = sim::read_json(key);
    tests.verdicts = sim::read_json(verdicts);
    tests.most_tests = most_tests;
    tests.jobs = jobs;
    tests.cache = cache;
    const Site within = site.empty() ? built_in_site() : load_site(site);
    const SafetyEnvelope envelope(within.settings);
    const std::size_t total = gap::case_folders(folder).size();
    Progress bar(fmt::format("tests on {} cases", total), total);
    const auto cases = gap::do_blind_tests(tests, list, envelope, [&bar] { bar.advance(); });
    bar.finish();
    std::map<std::string, int> done, left;
    for (const gap::TestedCase& one : cases) ++(one.test.empty() ? left[one.why_not] : done[one.test]);
    if (json) {
      nlohmann::json j = {{"cases", total}, {"done", done}, {"left", left}, {"tests", nlohmann::json::array()}};
      for (const gap::TestedCase& one : cases) {
        if (!one.test.empty()) j["tests"].push_back({{"case", one.name}, {"test", one.test}});
      }
      fmt::print("{}\n", j.dump());
      return;
    }
    for (const auto& [test, n] : done) fmt::print("{:>5} {}\n", n, test);
    for (const auto& [why, n] : left) fmt::print("{:>5} none: {}\n", n, why);
    fmt::print("next: airside gap run-cases {} -o {} --after-tests\n", hal::shell_word(folder),
               hal::shell_word(verdicts));
  }
};

}  // namespace

void add_gap_run_cases(CLI::App& gap) {
  auto cases = std::make_shared<RunCasesCommand>();
  CLI::App* c = gap.add_subcommand("run-cases", "a verdict for every case of a folder");
  c->add_option("folder", cases->folder, "folder of cases")->required();
  c->add_option("-o,--out", cases->out, "file for the verdicts")->capture_default_str();
  c->add_option("--cache", cases->cache, "folder of finished EnergyPlus runs, used again");
  c->add_flag("--continue", cases->go_on, "keep the verdicts in --out, judge the other cases");
  c->add_flag("--propose", cases->propose, "list with each open verdict the tests on site that would decide it");
  CLI::Option* alone = c->add_flag("--no-reference", cases->no_reference,
                                   "leave the reference logs aside: parameters are what their priors have");
  CLI::Option* tested =
      c->add_flag("--after-tests", cases->after_tests,
                  "judge the cases anew on which test-cases has done a test, and keep both verdicts in --out");
  alone->excludes(tested);
  add_gap_buildings(*c, cases->buildings);
  cases->add_effects(*c);
  cases->add_jobs(*c);
  cases->add_json(*c);
  c->callback([cases] { cases->run(); });
}

void add_gap_test_cases(CLI::App& gap) {
  auto self = std::make_shared<TestCasesCommand>();
  CLI::App* c = gap.add_subcommand(
      "test-cases", "do on the hidden rooms of blind cases the tests that their verdicts propose, and log those days");
  c->add_option("folder", self->folder, "folder of cases, from blind")->required();
  c->add_option("--verdicts", self->verdicts, "from run-cases --propose")->capture_default_str();
  c->add_option("--key", self->key, "from blind")->capture_default_str();
  c->add_option("--site", self->site, "site file whose limits of setpoint and rate hold (default: the built-in site)");
  c->add_option("--most-tests", self->most_tests, "of a case, each judged before the next")
      ->check(CLI::Range(1, 5))
      ->capture_default_str();
  c->add_option("--cache", self->cache, "folder of finished EnergyPlus runs, used again");
  self->add_effects(*c);
  self->add_jobs(*c);
  self->add_json(*c);
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
