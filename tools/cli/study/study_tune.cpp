// airside study tune: the gains of the peers, found on rooms and days that are never scored.

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hal/text/input_error.hpp"
#include "tools/baselines/tuning.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools {

namespace {

constexpr std::array<const char*, 3> tuned_figures = {"dae_degc", "me_degc", "darv_degc"};

struct TuneCommand : StudyOptions {
  std::string start = "2021-07-10", search = "descent";
  std::vector<std::string> rooms, methods;

  struct Figures {
    std::array<double, tuned_figures.size()> mean{};
  };

  std::string run_one(const TunablePeer& peer, const std::vector<double>& gains, const std::string& room,
                      std::uint64_t seed) const {
    const Trial trial{built_in_site(), choice(room, seed, start), expert_days, days};
    Prepared prepared = prepare(trial);
    const auto baseline = peer.make(trial.site.settings, gains);
    const nlohmann::json all = json_of(
        metrics_of(trial.site, run_baseline(trial.site, prepared.room(), *baseline, prepared.history, prepared.until)));
    nlohmann::json judged = nlohmann::json::array();
    for (const char* name : tuned_figures) judged.push_back(all[name]);
    return judged.dump();
  }

  /// Means over rooms and seeds of each candidate.
  std::vector<Figures> score(const TunablePeer& peer, std::span<const std::vector<double>> candidates) const {
    const std::size_t runs = rooms.size() * static_cast<std::size_t>(seeds);
    Progress bar(fmt::format("{}: {} candidates on {} runs", peer.method, candidates.size(), runs),
                 candidates.size() * runs);
    const auto texts = run_children(
        candidates.size() * runs, jobs,
        [&](std::size_t i) {
          const std::size_t run = i % runs;
          return run_one(peer, candidates[i / runs], rooms[run % rooms.size()], 1 + run / rooms.size());
        },
        [&](std::size_t i) {
          return fmt::format("{} {} on {}", peer.method, fmt::join(candidates[i / runs], "/"),
                             rooms[i % runs % rooms.size()]);
        },
        [&bar] { bar.advance(); });
    bar.finish();
    std::vector<Figures> out(candidates.size());
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const auto judged = nlohmann::json::parse(texts[i]);
      for (std::size_t f = 0; f < tuned_figures.size(); ++f) {
        out[i / runs].mean[f] += judged[f].get<double>() / static_cast<double>(runs);
      }
    }
    return out;
  }

  static nlohmann::json candidate_json(const TunablePeer& peer, const std::vector<double>& gains, const Figures& f) {
    nlohmann::json j;
    for (std::size_t a = 0; a < gains.size(); ++a) j["gains"][peer.axes[a].name] = gains[a];
    for (std::size_t i = 0; i < tuned_figures.size(); ++i) j[tuned_figures[i]] = f.mean[i];
    return j;
  }

  nlohmann::json tune(const TunablePeer& peer) const {
    const std::vector<double> frozen = peer.frozen(tuned_gains(plant()));
    std::vector<std::pair<std::vector<double>, Figures>> all;
    const auto costs = [&](std::span<const std::vector<double>> candidates) {
      const std::vector<Figures> judged = score(peer, candidates);
      std::vector<double> dae;
      for (std::size_t i = 0; i < judged.size(); ++i) {
        all.emplace_back(candidates[i], judged[i]);
        dae.push_back(judged[i].mean[0]);
      }
      return dae;
    };
    const GridSearch found = search == "grid" ? search_grid(peer.axes, costs) : descend_grid(peer.axes, frozen, costs);
    const auto figures_of = [&](const std::vector<double>& gains) {
      const auto at = std::find_if(all.begin(), all.end(), [&](const auto& c) { return c.first == gains; });
      return at != all.end() ? at->second : score(peer, std::vector<std::vector<double>>{gains}).front();
    };
    nlohmann::json j{{"method", peer.method}, {"tried", all.size()}, {"edges", found.edges}};
    for (const TuningAxis& axis : peer.axes) j["grid"][axis.name] = axis.values;
    j["best"] = candidate_json(peer, found.best.gains, figures_of(found.best.gains));
    j["frozen"] = candidate_json(peer, frozen, figures_of(frozen));
    j["frozen_is_best"] = found.best.gains == frozen;
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.second.mean[0] < b.second.mean[0]; });
    for (const auto& [gains, judged] : all) j["candidates"].push_back(candidate_json(peer, gains, judged));
    return j;
  }

  PlantKind plant() const { return kind == "energyplus" ? PlantKind::energyplus : PlantKind::rc; }

  static void print(const nlohmann::json& peer) {
    const auto line = [](const char* what, const nlohmann::json& c) {
      std::string gains;
      for (const auto& [name, value] : c["gains"].items()) gains += fmt::format(" {} {:g}", name, value.get<double>());
      fmt::print("  {:<7}{:<34} DAE {:.4f}  ME {:.4f}  DARV {:.4f}\n", what, gains, c["dae_degc"].get<double>(),
                 c["me_degc"].get<double>(), c["darv_degc"].get<double>());
    };
    fmt::print("{}: {} candidates tried\n", peer["method"].get<std::string>(), peer["tried"].get<int>());
    line("best", peer["best"]);
    if (!peer["frozen_is_best"].get<bool>()) line("frozen", peer["frozen"]);
    int shown = 0;
    for (const auto& c : peer["candidates"]) {
      if (c == peer["best"]) continue;
      if (++shown > 3) break;
      line("next", c);
    }
    for (const auto& edge : peer["edges"]) {
      fmt::print("  {} is at the edge of its grid: widen it in tools/baselines/tuning.cpp\n", edge.get<std::string>());
    }
  }

  void run() {
    RunFacts facts = run_facts(choice("301", 1, start), built_in_site());
    kind = facts.plant;
    if (kind == "rc") facts.weather = "another made-up year for each room and seed";
    if (rooms.empty()) {
      if (kind == "energyplus") {
        rooms = {"301", "401", "402", "701", "702"};
      } else {
        for (int i = 0; i < 8; ++i) rooms.push_back(fmt::format("tuning-{}", i));
      }
    }
    std::vector<std::string> known;
    for (const TunablePeer& peer : tunable_peers()) known.push_back(peer.method);
    if (methods.empty()) methods = known;
    for (const std::string& m : methods) {
      if (std::find(known.begin(), known.end(), m) != known.end()) continue;
      throw hal::InputError("--methods", '"' + m + '"', fmt::format("one of {}", fmt::join(known, ", ")),
                            "choose a name from the list");
    }
    for (const std::string& room : rooms) {
      if (room.starts_with("study-") || room.ends_with("-real")) {
        throw hal::InputError("--rooms", room, "rooms that no table scores",
                              "choose tuning-0 .. tuning-199 (rc), or 301, 401, 402, 701, 702");
      }
      (void)make_plant(choice(room, 1, start), built_in_site(), 1);
    }
    nlohmann::json j{
        {"plant", kind}, {"rooms", rooms},  {"seeds", seeds}, {"start", start}, {"expert_days", expert_days},
        {"days", days},  {"search", search}};
    tools::add_to(j, facts);
    say_fallback(facts);
    for (const TunablePeer& peer : tunable_peers()) {
      if (std::find(methods.begin(), methods.end(), peer.method) == methods.end()) continue;
      j["peers"].push_back(tune(peer));
      if (!json) print(j["peers"].back());
    }
    if (json)
      fmt::print("{}\n", j.dump());
    else
      fmt::print("by {}\n", text_of(facts));
  }
};

}  // namespace

void add_study_tune(CLI::App& study) {
  auto self = std::make_shared<TuneCommand>();
  CLI::App* c = study.add_subcommand(
      "tune",
      "find the gains of the tuned peers by mean DAE, on rooms and days that no table scores.\n"
      "What it finds is frozen in tools/baselines/tuned.hpp, plant by plant; it prints the frozen gains beside it.");
  self->add_to(*c, "days that are judged");
  c->add_option("--methods", self->methods,
                "peers to tune, comma-separated (default: pid-tuned, integral-tuned, arx-2, arx-rls, mpc)")
      ->delimiter(',');
  c->add_option("--rooms", self->rooms,
                "rooms, comma-separated (default: tuning-0 .. tuning-7; energyplus: the five twins)")
      ->delimiter(',');
  c->add_option("--start", self->start, "first day; the tables begin on 2021-08-01")->capture_default_str();
  c->add_option("--search", self->search, "descent: downhill from the frozen gains; grid: every point (PID: 2816)")
      ->check(CLI::IsMember({"descent", "grid"}))
      ->capture_default_str();
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
