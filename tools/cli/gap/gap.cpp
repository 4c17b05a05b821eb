// airside gap: where simulation and measurement disagree, which effect is missing, and how sure that is.

#include <fmt/format.h>

#include <cstdio>
#include <map>

#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "sim/json/json_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/gap/gap.hpp"
#include "tools/cli/gap/gap_fit.hpp"
#include "tools/gap/blind/blind_cases.hpp"
#include "tools/gap/model/patched_model.hpp"
#include "tools/gap/report/confusion_svg.hpp"
#include "tools/gap/report/reliability_svg.hpp"
#include "tools/gap/score/score.hpp"
#include "tools/run/options/option_checks.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

struct EffectsCommand : GapOptions {
  void run() const {
    const auto list = effects();
    nlohmann::json j = nlohmann::json::array();
    constexpr const char* places[] = {"floor", "facade", "zone", "vav", "fcu", "vav_pair"};
    for (const sim::Effect& e : list) {
      const char* engines = e.on_rc && e.on_energyplus ? "both" : e.on_rc ? "rc" : "energyplus";
      j.push_back({{"name", e.name},
                   {"title", e.title},
                   {"place", places[static_cast<int>(e.place)]},
                   {"unit", e.unit},
                   {"null", e.null_value},
                   {"low", e.low},
                   {"high", e.high},
                   {"least", e.least},
                   {"prior_sd", e.prior_sd},
                   {"engines", engines},
                   {"looks_like", e.looks_like},
                   {"confirm", e.confirm}});
      if (json) continue;
      fmt::print("{} ({}, {}; {} to {} {}, nothing at {})\n  {}\n  looks like: {}\n  on site: {}\n", e.name,
                 places[static_cast<int>(e.place)], engines, e.low, e.high, e.unit, e.null_value, e.title, e.looks_like,
                 e.confirm);
    }
    if (json) fmt::print("{}\n", nlohmann::json{{"effects", j}}.dump());
  }
};

struct BlindCommand : GapOptions {
  int cases = 20;
  std::uint64_t seed = 1;
  std::string folder = "blind", key = "blind-key.json", room = "301", engine = "rc", cache;
  int days = 14, window = 0;
  double ratio = 0;
  std::string only;
  std::vector<std::string> kinds;
  bool rough = false;

  void run() const {
    const auto list = effects();
    gap::BlindPlan plan = gap::plan_of(cases, seed);
    if (!only.empty()) {
      const std::map<std::string, int gap::BlindPlan::*> sets{{"single", &gap::BlindPlan::single},
                                                              {"null", &gap::BlindPlan::null},
                                                              {"outside", &gap::BlindPlan::outside},
                                                              {"pair", &gap::BlindPlan::pairs}};
      for (const auto& [set, count] : sets) plan.*count = set == only ? cases : 0;
    }
    plan.window = window;
    plan.ratio = ratio;
    plan.kinds = kinds;
    plan.twin = room;
    plan.days = days;
    plan.jobs = jobs;
    plan.engine = engine == "rc"           ? gap::BlindEngine::rc
                  : engine == "energyplus" ? gap::BlindEngine::energyplus
                                           : gap::BlindEngine::mixed;
    plan.rough = rough;
    plan.cache = cache;
    Progress bar(fmt::format("hiding effects in {} cases", plan.total()),
                 static_cast<std::uint64_t>(gap::blind_steps(plan)));
    gap::make_blind_cases(plan, list, folder, key, [&bar] { bar.advance(); });
    bar.finish();
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"cases", plan.total()},
                                        {"folder", folder},
                                        {"key", key},
                                        {"engine", engine},
                                        {"seeds", {seed}},
                                        {"single", plan.single},
                                        {"null", plan.null},
                                        {"outside", plan.outside},
                                        {"pairs", plan.pairs}}
                             .dump());
      return;
    }
    fmt::print(
        "{} cases in {}, the key in {}\nnext: airside gap run-cases {} -o verdicts.json; airside gap score "
        "verdicts.json {}\n",
        plan.total(), folder, key, hal::shell_word(folder), hal::shell_word(key));
  }
};

struct ScoreCommand : GapOptions {
  std::vector<std::string> files;
  std::string picture, reliability;

  void run() const {
    std::map<std::string, double> null_of;
    for (const sim::Effect& e : effects()) null_of[e.name] = e.null_value;
    if (files.size() % 2 != 0) {
      throw hal::InputError("airside gap score", std::to_string(files.size()) + " files",
                            "as many keys as verdicts: verdicts.json key.json, or all verdicts and then all keys",
                            "give the missing one");
    }
    const std::size_t drawings = files.size() / 2;
    std::vector<gap::JudgedCases> judged;
    for (std::size_t i = 0; i < drawings; ++i)
      judged.push_back({sim::read_json(files[i]), sim::read_json(files[drawings + i])});
    const gap::ScoreTable table = gap::score(judged, null_of);
    if (!picture.empty()) gap::write_whole_file(picture, gap::confusion_svg(table.confusion, "hidden and said"));
    if (!reliability.empty()) {
      gap::write_whole_file(reliability,
                            gap::reliability_svg(table.posteriors.reliability, "How probable, and how often true"));
    }
    if (json) {
      fmt::print("{}\n", gap::json_of(table).dump());
    } else {
      fmt::print("{}", gap::text_of(table));
    }
  }
};

struct RevertCommand {
  std::string ledger, model, out;
  bool json = false;

  void run() const {
    const nlohmann::json back = gap::reverted_model(sim::read_json(model), sim::read_json(ledger), model, ledger);
    gap::write_whole_file(out, back.dump(1) + "\n");
    if (json)
      fmt::print("{}\n", nlohmann::json{{"model", out}, {"digest", gap::model_digest(back)}}.dump());
    else
      fmt::print("{}: the model as it was before\n", out);
  }
};

}  // namespace

void add_gap(CLI::App& app) {
  CLI::App* gap = app.add_subcommand(
      "gap", "find where simulation and measurement disagree, name the missing effect, show the gap shrink");
  gap->require_subcommand(0, 1);

  auto list = std::make_shared<EffectsCommand>();
  CLI::App* c = gap->add_subcommand("effects", "every effect that can be found, with how to confirm it on site");
  list->add_effects(*c);
  list->add_json(*c);
  c->callback([list] { list->run(); });

  auto blind = std::make_shared<BlindCommand>();
  c = gap->add_subcommand("blind", "make sealed cases in which something is hidden, and their key apart");
  c->add_option("--cases", blind->cases, "how many in all")->check(CLI::Range(1, 10000))->capture_default_str();
  c->add_option("--seed", blind->seed, "of rooms, effects and noise")->check(seed_check())->capture_default_str();
  c->add_option("--room", blind->room, "the workflow's room")->capture_default_str();
  c->add_option("--days", blind->days, "of the reference, and again of the measured period")
      ->check(CLI::Range(4, 60))
      ->capture_default_str();
  c->add_option("-o,--out", blind->folder, "folder for the cases; new or empty")->capture_default_str();
  c->add_option("--engine", blind->engine,
                "what measures: rc, energyplus, or mixed: every fourth case of each set by EnergyPlus")
      ->check(CLI::IsMember({"rc", "energyplus", "mixed"}))
      ->capture_default_str();
  c->add_option("--only", blind->only, "one set alone: single, null, outside or pair")
      ->check(CLI::IsMember({"single", "null", "outside", "pair"}));
  c->add_option("--hide", blind->kinds, "effects that are hidden, by turns; else all")->delimiter(',');
  c->add_option("--ratio", blind->ratio, "of every single effect to the noise; else 0.5, 1 and 3 by turns")
      ->check(CLI::Range(0.1, 20.0));
  c->add_option("--window", blind->window, "all cases in this stretch of weather, 1 to 5; else in all by turns")
      ->check(CLI::Range(1, 5));
  c->add_flag("--rough", blind->rough, "sizes by a table of noise instead of fits: quick, not exact");
  c->add_option("--cache", blind->cache, "folder of finished EnergyPlus runs, used again");
  c->add_option("--key", blind->key, "file for the answers, outside that folder")->capture_default_str();
  blind->add_effects(*c);
  blind->add_jobs(*c);
  blind->add_json(*c);
  c->callback([blind] { blind->run(); });

  add_gap_run_cases(*gap);
  add_gap_test_cases(*gap);

  auto score = std::make_shared<ScoreCommand>();
  c = gap->add_subcommand("score", "compare verdicts with the key");
  c->add_option("files", score->files,
                "verdicts from run-cases and their key from blind; of several drawings all verdicts, then all keys in "
                "the same order")
      ->required()
      ->expected(2, -1);
  c->add_option("--picture", score->picture, "SVG file with the confusion matrix");
  c->add_option("--reliability", score->reliability,
                "SVG file: probabilities of explanations, and how often they came");
  score->add_effects(*c);
  score->add_json(*c);
  c->callback([score] { score->run(); });

  auto revert = std::make_shared<RevertCommand>();
  c = gap->add_subcommand("revert", "the model as it was before a patch");
  c->add_option("ledger", revert->ledger, "ledger.json of the patch")->required();
  c->add_option("model", revert->model, "the patched model")->required();
  c->add_option("-o,--out", revert->out, "file for the model before")->required();
  c->add_flag("--json", revert->json, "print one JSON object and nothing else on standard output");
  c->callback([revert] { revert->run(); });
  add_gap_fit(*gap);
  add_gap_retrain(*gap);
  add_gap_next(*gap);
  add_gap_watch(*gap);
  add_gap_bills(*gap);
  add_gap_run(*gap);
}

}  // namespace airside::tools
