#include "tools/gap/blind_cases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "hal/input_error.hpp"
#include "sim/epw.hpp"
#include "sim/rc_room_file.hpp"
#include "sim/stateless_draw.hpp"
#include "sim/synthetic_weather.hpp"
#include "tools/gap/case_file.hpp"
#include "tools/gap/log_window.hpp"
#include "tools/site.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;

constexpr int windows = 5;
constexpr double ratios[] = {0.5, 1.0, 3.0};
enum CaseDraw : std::uint64_t { draw_effect = 810, draw_place, draw_second, draw_magnitude, draw_name };

CivilTime start_of_window(int window) {
  constexpr int month_day[windows][2] = {{5, 10}, {6, 20}, {7, 15}, {8, 20}, {9, 25}};
  return sim::civil_midnight(2021, month_day[window][0], month_day[window][1]);
}

/// What cases of one window and one way of control share.
struct Setting {
  CaseData null_case;
  Responses test;
  Eigen::VectorXd noise;
};

struct PlannedCase {
  std::string set;
  int window = 0;
  bool feedback = true;
  double ratio = 0;
  std::vector<Hidden> hidden;
};

class Generator {
 public:
  Generator(const BlindPlan& plan, const std::vector<sim::Effect>& effects)
      : plan_(plan),
        effects_(effects),
        twin_(sim::load_room(plan.twin)),
        engine_(twin_),
        library_(library_of(engine_, effects)) {
    for (int w = 0; w < windows; ++w)
      weather_.push_back(sim::synthetic_weather(plan.seed * 1000 + static_cast<std::uint64_t>(w)));
    for (const sim::EffectAt& at : library_.candidates) places_[at.effect->name].push_back(at);
  }

  PlannedCase plan_case(int i) {
    PlannedCase c;
    c.window = i % windows;
    c.feedback = i / windows % 2 == 0;
    int at = i;
    const auto belongs = [&at](int count) {
      if (at < count) return true;
      at -= count;
      return false;
    };
    if (belongs(plan_.single)) {
      c.set = "single";
      c.ratio = ratios[at / windows % 3];
      c.hidden = {library_effect(i, at, c, draw_effect)};
    } else if (belongs(plan_.null)) {
      c.set = "null";
    } else if (belongs(plan_.outside)) {
      c.set = "outside";
      c.hidden = {outside_effect(i, at)};
    } else {
      c.set = "pair";
      c.ratio = 3;
      c.hidden = {library_effect(i, at, c, draw_effect), library_effect(i, at + 7, c, draw_second)};
    }
    return c;
  }

  void write(int i, const PlannedCase& c, const fs::path& folder, const std::string& name) {
    const std::uint64_t seed = seed_of(i);
    const sim::RcRoom room = measured_room(twin_, seed, c.feedback);
    const MeasuredRun reference{start_of_window(c.window), plan_.days, seed, c.feedback, 0.002};
    const MeasuredRun test = after(reference);
    const auto weather = weather_[static_cast<std::size_t>(c.window)];
    fs::create_directories(folder / name);
    const hal::TopologyCounts counts{"", twin_.vavs, twin_.fcus, twin_.powers};
    const auto log = [&](const char* file, const std::vector<hal::LogRow>& rows) {
      hal::LogWriter writer((folder / name / file).string(), counts, false);
      for (const hal::LogRow& row : rows) writer.append(row);
      writer.close();
    };
    log("reference.csv", measure(room, weather, reference));
    log("measured.csv", measure(hide(room, c.hidden, effects_), weather, test, c.hidden));
    CaseDescription description;
    description.model = plan_.twin;
    description.weather = fmt::format("../weather/{}.epw", c.window + 1);
    description.reference_log = "reference.csv";
    description.measured_log = "measured.csv";
    description.window = fmt::format("{}{}", c.window + 1, c.feedback ? "f" : "s");
    write_case(folder / name, description);
  }

  void write_weather(const fs::path& folder) const {
    fs::create_directories(folder / "weather");
    for (int w = 0; w < windows; ++w) {
      sim::write_epw((folder / "weather" / fmt::format("{}.epw", w + 1)).string(),
                     *weather_[static_cast<std::size_t>(w)], 2021);
    }
  }

 private:
  std::uint64_t seed_of(int i) const { return plan_.seed * 1'000'003 + static_cast<std::uint64_t>(i) * 2; }
  MeasuredRun after(MeasuredRun run) const {
    run.start.seconds += run.days * std::int64_t{86400};
    run.seed += 1;
    return run;
  }
  double uniform(int i, CaseDraw what) const { return sim::draw_uniform(seed_of(i), what, 0, 0); }

  /// A kind by turns, a place by lot, a size that shows `ratio` times above the noise.
  Hidden library_effect(int i, int turn, const PlannedCase& c, CaseDraw draw) {
    auto kind = places_.begin();
    std::advance(kind, turn % std::ssize(places_));
    const auto& places = kind->second;
    const auto place = static_cast<std::size_t>(uniform(i, draw) * static_cast<double>(places.size()));
    const sim::EffectAt at = places[std::min(place, places.size() - 1)];
    return {at.effect->name, at.place, magnitude(i, at, c)};
  }

  double magnitude(int i, const sim::EffectAt& at, const PlannedCase& c) {
    const sim::Effect& e = *at.effect;
    if (e.name == "swapped_sensors" || e.name == "fcu_runs_unrecorded") return 1;
    if (e.name == "fcu_rests_unrecorded") return 0;
    const Setting& s = setting(c);
    const std::size_t second = uniform(i, draw_magnitude) < 0.5 ? 0 : 1;
    std::size_t seen = 0;
    for (const Candidate& candidate : s.test.candidates) {
      if (candidate.at.id() != at.id() || seen++ != second) continue;
      double most = 0;
      for (Eigen::Index k = 0; k < s.noise.size(); ++k) {
        const double rms =
            std::sqrt(candidate.response.col(k).squaredNorm() / static_cast<double>(candidate.response.rows()));
        if (std::isfinite(rms)) most = std::max(most, rms / s.noise(k));
      }
      const double steps = most > 1e-6 ? c.ratio / most : 1;
      return std::clamp(e.null_value + steps * (candidate.probe - e.null_value), e.low, e.high);
    }
    return e.probe[0];
  }

  Hidden outside_effect(int i, int turn) const {
    const int fcu = static_cast<int>(uniform(i, draw_place) * twin_.fcus);
    switch (turn % 2) {
      case 0: return {"fcu_dial", fcu, uniform(i, draw_magnitude) < 0.5 ? -1.5 : 1.5};
      default: return {"damper_opening", 0, uniform(i, draw_magnitude) < 0.5 ? 0.75 : 1.25};
    }
  }

  const Setting& setting(const PlannedCase& c) {
    const auto [at, added] = settings_.try_emplace({c.window, c.feedback});
    Setting& s = at->second;
    if (!added) return s;
    const auto weather = weather_[static_cast<std::size_t>(c.window)];
    const std::uint64_t seed = plan_.seed + 77;
    const sim::RcRoom room = measured_room(twin_, seed, c.feedback);
    const MeasuredRun reference{start_of_window(c.window), plan_.days, seed, c.feedback, 0};
    const auto window = [&](const MeasuredRun& run) {
      return window_of(measure(room, weather, run), engine_.channels(), weather, "null");
    };
    s.null_case = {window(reference), window(after(reference))};
    const Responses responses =
        simulate_responses(engine_, library_, s.null_case.reference.recording, true, plan_.jobs);
    s.noise = fit_reference(engine_, responses, s.null_case.reference).noise.spread();
    s.test = simulate_responses(engine_, library_, s.null_case.test.recording, true, plan_.jobs);
    return s;
  }

  const BlindPlan& plan_;
  const std::vector<sim::Effect>& effects_;
  sim::RcRoom twin_;
  RcEngine engine_;
  Library library_;
  std::vector<std::shared_ptr<const sim::Weather>> weather_;
  std::map<std::string, std::vector<sim::EffectAt>> places_;
  std::map<std::pair<int, bool>, Setting> settings_;
};

std::string id_of(const Hidden& h, const std::vector<sim::Effect>& effects) {
  const auto found = std::find_if(effects.begin(), effects.end(), [&h](const auto& e) { return e.name == h.effect; });
  if (found == effects.end()) return h.effect + "@" + std::to_string(h.place + 1);
  return sim::EffectAt{&*found, h.place}.id();
}

/// Numbers in an order that says nothing: cases of one set must not stand together.
std::vector<int> shuffled(const BlindPlan& plan) {
  std::vector<int> rank(static_cast<std::size_t>(plan.total()));
  std::iota(rank.begin(), rank.end(), 0);
  std::sort(rank.begin(), rank.end(), [&plan](int a, int b) {
    return sim::draw_bits(plan.seed, draw_name, 0, a) < sim::draw_bits(plan.seed, draw_name, 0, b);
  });
  return rank;
}

}  // namespace

BlindPlan plan_of(int cases, std::uint64_t seed) {
  BlindPlan plan;
  plan.seed = seed;
  const auto share = [cases](int of) { return static_cast<int>(std::lround(cases * of / 760.0)); };
  plan.null = share(300);
  plan.outside = share(60);
  plan.pairs = share(100);
  plan.single = std::max(0, cases - plan.null - plan.outside - plan.pairs);
  return plan;
}

void make_blind_cases(const BlindPlan& plan, const std::vector<sim::Effect>& effects, const fs::path& folder,
                      const fs::path& key, const std::function<void()>& done) {
  std::error_code failed;
  if (fs::exists(folder) && !fs::is_empty(folder, failed)) {
    throw hal::InputError(folder.string(), "a folder that is not empty", "a new folder for the cases",
                          "name another with -o");
  }
  const fs::path inside = fs::weakly_canonical(key).lexically_relative(fs::weakly_canonical(folder));
  if (!inside.empty() && *inside.begin() != "..") {
    throw hal::InputError("--key " + key.string(), "a file in the folder of the cases", "a file outside it",
                          "whoever sees the cases must not see the key");
  }
  Generator generator(plan, effects);
  generator.write_weather(folder);
  nlohmann::json answers = {{"format", 1}, {"seed", plan.seed}, {"cases", nlohmann::json::object()}};
  const std::vector<int> rank = shuffled(plan);
  for (int i = 0; i < plan.total(); ++i) {
    const PlannedCase c = generator.plan_case(i);
    const std::string name = fmt::format("case-{:04}", 1 + rank[static_cast<std::size_t>(i)]);
    generator.write(i, c, folder, name);
    nlohmann::json hidden = nlohmann::json::array();
    for (const Hidden& h : c.hidden) hidden.push_back({{"id", id_of(h, effects)}, {"magnitude", h.magnitude}});
    answers["cases"][name] = {{"set", c.set},       {"engine", "rc"},   {"workflow", "rc"}, {"feedback", c.feedback},
                              {"window", c.window}, {"ratio", c.ratio}, {"hidden", hidden}};
    if (done) done();
  }
  std::ofstream out(key);
  out << answers.dump(1) << '\n';
  if (!out)
    throw hal::InputError("--key " + key.string(), "a file that cannot be written", "a writable path",
                          "choose another");
}

}  // namespace airside::tools::gap
