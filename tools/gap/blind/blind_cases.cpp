#include "tools/gap/blind/blind_cases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <set>

#include "hal/text/input_error.hpp"
#include "sim/stateless_draw.hpp"
#include "sim/weather/epw.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/blind/blind_plan.hpp"
#include "tools/gap/blind/blind_site.hpp"
#include "tools/gap/case/case_format.hpp"
#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;

struct Sized {
  Hidden hidden;
  Shown shown;
};

struct MadeCase {
  std::vector<Sized> hidden;
  ShownLive live;
  std::vector<Sized> not_reached;  ///< what was tried before: it cannot show so much, or never so little
};

/// Effects that are there or not, nothing between.
std::optional<double> fixed_magnitude(const std::string& effect) {
  if (effect == "swapped_sensors" || effect == "fcu_runs_unrecorded") return 1;
  if (effect == "fcu_rests_unrecorded") return 0;
  return std::nullopt;
}

class Generator {
 public:
  Generator(const BlindPlan& plan, const std::vector<sim::Effect>& effects, const fs::path& folder,
            std::function<void()> done)
      : plan_(plan), effects_(effects), folder_(folder), done_(std::move(done)) {
    write_weather();
    std::map<bool, std::set<BlindWindow>> wanted;
    for (int i = 0; i < plan.total(); ++i) {
      const PlannedCase c = planned_case(plan, i);
      wanted[c.energyplus].insert(c.window);
    }
    for (const auto& [energyplus, some] : wanted) {
      auto& site = energyplus ? energyplus_ : rc_;
      site = energyplus ? make_energyplus_site(setup()) : make_rc_site(setup());
      for (const std::string& kind : plan.kinds) {
        if (!site->kinds().contains(kind))
          throw hal::InputError("the effect " + kind, "that nobody can hide there", "one of airside gap effects",
                                "name another");
      }
      site->prepare({some.begin(), some.end()});
    }
  }

  /// Chooses what is hidden and writes the logs. Thread-safe.
  MadeCase make(int i, const PlannedCase& c, const std::string& name) const {
    const BlindSite& site = c.energyplus ? *energyplus_ : *rc_;
    MadeCase made;
    if (c.set == "single" || c.set == "pair") add_library_effect(made, site, i, c.turn, c, draw_effect);
    if (c.set == "pair") add_library_effect(made, site, i, c.turn + 7, c, draw_second);
    if (c.set == "outside") {
      // A fan coil that hardly runs hides its dial: other places are tried until one shows.
      for (int t = 0; t < 8; ++t) {
        const Hidden h = outside_effect(site, i, c, t);
        const Sized one{h, site.shown(h, c.window)};
        if (made.hidden.empty()) made.hidden.push_back(one);
        if (one.shown.ratio > made.hidden.front().shown.ratio) made.hidden.front() = one;
        if (!(made.hidden.front().shown.ratio < 2)) break;
      }
    }
    std::vector<Hidden> hidden;
    for (const Sized& one : made.hidden) hidden.push_back(one.hidden);
    const BlindLogs logs = site.live(hidden, c.window, seed_of(i));
    if (c.window.feedback && !hidden.empty()) made.live = site.shown_live(logs, c.window, seed_of(i));
    write(c, folder_ / name, logs, site.counts());
    return made;
  }

 private:
  BlindSetup setup() const {
    BlindSetup setup;
    setup.twin = plan_.twin;
    setup.seed = plan_.seed;
    setup.days = plan_.days;
    setup.jobs = plan_.jobs;
    setup.rough = plan_.rough;
    setup.cache = plan_.cache;
    setup.effects = &effects_;
    setup.done = done_;
    for (int w = 0; w < blind_windows; ++w) {
      setup.starts.push_back(start_of_window(w));
      setup.weather.push_back(weather_file(w));
    }
    return setup;
  }

  fs::path weather_file(int window) const { return weather_of_window(folder_, window); }

  void write_weather() const {
    fs::create_directories(folder_ / "weather");
    for (int w = 0; w < blind_windows; ++w) {
      const auto weather = sim::synthetic_weather(plan_.seed * 1000 + static_cast<std::uint64_t>(w));
      sim::write_epw(weather_file(w).string(), *weather, 2021);
    }
  }

  void write(const PlannedCase& c, const fs::path& folder, const BlindLogs& logs,
             const hal::TopologyCounts& counts) const {
    fs::create_directories(folder);
    CaseDescription description;
    description.engine = c.energyplus ? "energyplus" : "rc";
    description.model = plan_.twin;
    description.weather = fmt::format("../weather/{}.epw", c.window.number + 1);
    description.reference_log = "reference.csv";
    description.measured_log = "measured.csv";
    description.window = fmt::format("{}{}", c.window.number + 1, c.window.feedback ? "f" : "s");
    // Fan coils that a schedule drives say nothing of thermostats.
    description.duties = !c.energyplus || c.window.feedback;
    const auto log = [&](const std::string& file, const std::vector<hal::LogRow>& rows) {
      hal::LogWriter writer((folder / file).string(), counts, false);
      for (const hal::LogRow& row : rows) writer.append(row);
      writer.close();
    };
    log(description.reference_log, logs.reference);
    log(description.measured_log, logs.measured);
    write_case(folder, description);
  }

  std::uint64_t seed_of(int i) const { return seed_of_case(plan_.seed, i); }
  double uniform(int i, CaseDraw what) const { return sim::draw_uniform(seed_of(i), what, 0, 0); }
  int lot(int i, CaseDraw what, int count) const {
    return std::min(count - 1, static_cast<int>(uniform(i, what) * count));
  }

  /// A kind by turns, a place by lot, a size that shows `ratio` times above the noise. A kind that cannot show so much
  /// within its bounds, or never so little, gives its turn to the next.
  void add_library_effect(MadeCase& made, const BlindSite& site, int i, int turn, const PlannedCase& c,
                          CaseDraw draw) const {
    constexpr int most_tries = 8;
    std::vector<Sized> tried;
    for (int t = 0; t < most_tries; ++t) {
      const auto& places = places_of_turn(site, turn + t);
      const sim::EffectAt at = places[static_cast<std::size_t>(lot(i, draw, static_cast<int>(places.size())))];
      const int first = uniform(i, draw_magnitude) < 0.5 ? 0 : 1;
      for (const int which : {first, 1 - first}) {
        const Sized one = sized(site, at, at.effect->probe[static_cast<std::size_t>(which)], c);
        if (is_as_wanted(one, c.ratio)) {
          made.hidden.push_back(one);
          made.not_reached.insert(made.not_reached.end(), tried.begin(), tried.end());
          return;
        }
        tried.push_back(one);
        if (fixed_magnitude(at.effect->name)) break;
      }
    }
    const auto off = [&c](const Sized& s) { return std::abs(std::log(std::max(1e-9, s.shown.ratio) / c.ratio)); };
    const auto nearest =
        std::min_element(tried.begin(), tried.end(), [&off](const auto& a, const auto& b) { return off(a) < off(b); });
    made.hidden.push_back(*nearest);
    tried.erase(nearest);
    made.not_reached.insert(made.not_reached.end(), tried.begin(), tried.end());
  }

  const std::vector<sim::EffectAt>& places_of_turn(const BlindSite& site, int turn) const {
    auto kind = site.kinds().begin();
    if (plan_.kinds.empty())
      std::advance(kind, kind_of_turn(turn, std::ssize(site.kinds())));
    else
      kind = site.kinds().find(plan_.kinds[static_cast<std::size_t>(turn) % plan_.kinds.size()]);
    return kind->second;
  }

  /// In an order in which a small set too sees every sort of kind: neighbours in the alphabet are alike.
  std::ptrdiff_t kind_of_turn(int turn, std::ptrdiff_t kinds) const {
    std::ptrdiff_t stride = 17;
    while (std::gcd(stride, kinds) != 1) ++stride;
    return (turn * stride + static_cast<std::ptrdiff_t>(plan_.seed % static_cast<std::uint64_t>(kinds))) % kinds;
  }

  /// What is there or not may be louder than asked where the loudest is asked for.
  static bool is_as_wanted(const Sized& one, double ratio) {
    const bool may_be_louder = ratio >= 3 && fixed_magnitude(one.hidden.effect).has_value();
    return one.shown.ratio >= 0.8 * ratio && (may_be_louder || one.shown.ratio <= 1.5 * ratio);
  }

  Sized sized(const BlindSite& site, const sim::EffectAt& at, double probe, const PlannedCase& c) const {
    const sim::Effect& e = *at.effect;
    const auto fixed = fixed_magnitude(e.name);
    Sized one{{e.name, at.place, fixed.value_or(probe)}, {}};
    one.shown = site.shown(one.hidden, c.window);
    // Responses are nearly linear; where they are not, what was too little and too much enclose the size.
    double too_little = 0, too_much = std::numeric_limits<double>::infinity();  // from null
    for (int again = 0; !fixed && again < 6 && (one.shown.ratio > 1e-6 || again > 0); ++again) {
      const double wanted = c.ratio / std::max(1e-9, one.shown.ratio);
      if (std::abs(wanted - 1) < 0.02) break;
      double& m = one.hidden.magnitude;
      const double from_null = std::abs(m - e.null_value);
      (wanted > 1 ? too_little : too_much) = from_null;
      double share = wanted;
      if (from_null * share <= too_little || from_null * share >= too_much)
        share = (too_little + std::min(too_much, 2 * from_null)) / 2 / from_null;
      double next = std::clamp(e.null_value + share * (m - e.null_value), e.low, e.high);
      if (e.name == "clock_shift") next = whole_rows(next);
      if (next == m || next == e.null_value) break;
      m = next;
      one.shown = site.shown(one.hidden, c.window);
    }
    return one;
  }

  /// A log's clock stands on its grid of rows.
  static double whole_rows(double hours) {
    const double rows = std::round(hours * 3600 / row_s);
    return (rows == 0 ? 1 : rows) * row_s / 3600;
  }

  Hidden outside_effect(const BlindSite& site, int i, const PlannedCase& c, int attempt) const {
    const auto kind_at = [](int turn) {
      return outside_kinds()[static_cast<std::size_t>(turn) % outside_kinds().size()];
    };
    int turn = c.turn;
    while (!site.has_outside(kind_at(turn), c.window)) ++turn;
    const std::string kind = kind_at(turn);
    const int places = site.outside_places(kind);
    const double sign = (uniform(i, draw_sign) < 0.5) == (attempt % 2 == 0) ? -1 : 1,
                 share = uniform(i, draw_magnitude);
    const auto between = [share](double low, double high) {
      return std::round(100 * (low + share * (high - low))) / 100;
    };
    Hidden h{kind, places > 0 ? (lot(i, draw_place, places) + attempt / 2) % places : -1, 0};
    if (kind == "fcu_dial") h.magnitude = sign * between(1.2, 2.0);
    if (kind == "odd_heater") h.magnitude = between(900, 1800);
    if (kind == "escape_door") h.magnitude = between(5, 10);
    if (kind == "chilled_water_drift") h.magnitude = between(0.4, 0.8);
    if (kind == "ahu_time_switch") h.magnitude = between(1.5, 3.5);
    if (kind == "pump_power") h.magnitude = between(1.6, 2.4);
    return h;
  }

  const BlindPlan& plan_;
  const std::vector<sim::Effect>& effects_;
  fs::path folder_;
  std::function<void()> done_;
  std::unique_ptr<BlindSite> rc_, energyplus_;
};

nlohmann::json finite_or_null(double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(); }

nlohmann::json key_of(const std::vector<Sized>& list, const std::vector<sim::Effect>& effects) {
  nlohmann::json j = nlohmann::json::array();
  for (const Sized& one : list) {
    j.push_back({{"id", id_of(one.hidden, effects)},
                 {"magnitude", one.hidden.magnitude},
                 {"achieved_ratio", finite_or_null(one.shown.ratio)},
                 {"shows_in", one.shown.channel}});
  }
  return j;
}

nlohmann::json key_entry(const PlannedCase& c, const MadeCase& made, const std::vector<sim::Effect>& effects) {
  const char* engine = c.energyplus ? "energyplus" : "rc";
  nlohmann::json entry = {{"set", c.set},
                          {"engine", engine},
                          {"workflow", engine},
                          {"feedback", c.window.feedback},
                          {"window", c.window.number},
                          {"ratio", c.ratio},
                          {"hidden", key_of(made.hidden, effects)}};
  for (const auto& [kind, shown] : made.live)
    entry["live"][kind] = {{"ratio", shown.ratio}, {"channel", shown.channel}};
  if (!made.not_reached.empty()) entry["not_reached"] = key_of(made.not_reached, effects);
  return entry;
}

}  // namespace

void forget_time(const fs::path& path) {
  const fs::file_time_type then{fs::file_time_type::clock::from_sys(
      std::chrono::sys_seconds{std::chrono::sys_days{std::chrono::year{2021} / std::chrono::December / 1}})};
  fs::last_write_time(path, then);
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
  const Generator generator(plan, effects, folder, done);
  nlohmann::json answers = {{"format", 1}, {"seed", plan.seed}, {"cases", nlohmann::json::object()}};
  const std::vector<int> order = in_order_of_name(plan.seed, plan.total());
  std::mutex mutex;
  in_parallel(order.size(), plan.jobs, [&](std::size_t n) {
    const int i = order[n];
    const PlannedCase c = planned_case(plan, i);
    const std::string name = fmt::format("case-{:04}", n + 1);
    const MadeCase made = generator.make(i, c, name);
    const std::lock_guard lock(mutex);
    answers["cases"][name] = key_entry(c, made, effects);
    if (done) done();
  });
  std::vector<fs::path> all{folder};
  for (const auto& entry : fs::recursive_directory_iterator(folder)) all.push_back(entry.path());
  for (const fs::path& path : all) forget_time(path);
  std::ofstream out(key);
  out << answers.dump(1) << '\n';
  if (!out)
    throw hal::InputError("--key " + key.string(), "a file that cannot be written", "a writable path",
                          "choose another");
}

}  // namespace airside::tools::gap
