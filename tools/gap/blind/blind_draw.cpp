#include "tools/gap/blind/blind_draw.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "sim/stateless_draw.hpp"
#include "sim/weather/epw.hpp"
#include "sim/weather/synthetic_weather.hpp"

namespace airside::tools::gap {

namespace {

/// Effects that are there or not, nothing between.
std::optional<double> fixed_magnitude(const std::string& effect) {
  if (effect == "swapped_sensors" || effect == "fcu_runs_unrecorded") return 1;
  if (effect == "fcu_rests_unrecorded") return 0;
  return std::nullopt;
}

class CaseDrawing {
 public:
  CaseDrawing(const BlindPlan& plan, const BlindSite& site) : plan_(plan), site_(site) {}

  DrawnCase of(int i, const PlannedCase& c) const {
    DrawnCase made;
    if (c.set == "single" || c.set == "pair") add_library_effect(made, i, c.turn, c, draw_effect);
    if (c.set == "pair") add_library_effect(made, i, c.turn + 7, c, draw_second);
    if (c.set == "outside") {
      // A fan coil that hardly runs hides its dial: other places are tried until one shows.
      for (int t = 0; t < 8; ++t) {
        const Hidden h = outside_effect(i, c, t);
        const Sized one{h, site_.shown(h, c.window)};
        if (made.hidden.empty()) made.hidden.push_back(one);
        if (one.shown.ratio > made.hidden.front().shown.ratio) made.hidden.front() = one;
        if (!(made.hidden.front().shown.ratio < 2)) break;
      }
    }
    return made;
  }

 private:
  std::uint64_t seed_of(int i) const { return seed_of_case(plan_.seed, i); }
  double uniform(int i, CaseDraw what) const { return sim::draw_uniform(seed_of(i), what, 0, 0); }
  int lot(int i, CaseDraw what, int count) const {
    return std::min(count - 1, static_cast<int>(uniform(i, what) * count));
  }

  /// A kind by turns, a place by lot, a size that shows `ratio` times above the noise. A kind that cannot show so much
  /// within its bounds, or never so little, gives its turn to the next.
  void add_library_effect(DrawnCase& made, int i, int turn, const PlannedCase& c, CaseDraw draw) const {
    constexpr int most_tries = 8;
    std::vector<Sized> tried;
    for (int t = 0; t < most_tries; ++t) {
      const auto& places = places_of_turn(turn + t);
      const sim::EffectAt at = places[static_cast<std::size_t>(lot(i, draw, static_cast<int>(places.size())))];
      const int first = uniform(i, draw_magnitude) < 0.5 ? 0 : 1;
      for (const int which : {first, 1 - first}) {
        const Sized one = sized(at, at.effect->probe[static_cast<std::size_t>(which)], c);
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

  const std::vector<sim::EffectAt>& places_of_turn(int turn) const {
    auto kind = site_.kinds().begin();
    if (plan_.kinds.empty())
      std::advance(kind, kind_of_turn(turn, std::ssize(site_.kinds())));
    else
      kind = site_.kinds().find(plan_.kinds[static_cast<std::size_t>(turn) % plan_.kinds.size()]);
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

  Sized sized(const sim::EffectAt& at, double probe, const PlannedCase& c) const {
    const sim::Effect& e = *at.effect;
    const auto fixed = fixed_magnitude(e.name);
    Sized one{{e.name, at.place, fixed.value_or(probe)}, {}};
    one.shown = site_.shown(one.hidden, c.window);
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
      one.shown = site_.shown(one.hidden, c.window);
    }
    return one;
  }

  /// A log's clock stands on its grid of rows.
  static double whole_rows(double hours) {
    const double rows = std::round(hours * 3600 / row_s);
    return (rows == 0 ? 1 : rows) * row_s / 3600;
  }

  Hidden outside_effect(int i, const PlannedCase& c, int attempt) const {
    const auto kind_at = [](int turn) {
      return outside_kinds()[static_cast<std::size_t>(turn) % outside_kinds().size()];
    };
    int turn = c.turn;
    while (!site_.has_outside(kind_at(turn), c.window)) ++turn;
    const std::string kind = kind_at(turn);
    const int places = site_.outside_places(kind);
    const double sign = (uniform(i, draw_sign) < 0.5) == (attempt % 2 == 0) ? -1 : 1,
                 share = uniform(i, draw_magnitude);
    const auto between = [share](double low, double high) {
      return std::round(100 * (low + share * (high - low))) / 100;
    };
    Hidden h{kind, places > 0 ? (lot(i, draw_place, places) + attempt / 2) % places : -1, 0};
    if (kind == "fcu_dial") h.magnitude = sign * between(1.2, 2.0);
    if (kind == "odd_heater") h.magnitude = between(900, 1800);
    if (kind == "escape_door") h.magnitude = between(5, 10);
    if (kind == "ahu_time_switch") h.magnitude = between(1.5, 3.5);
    if (kind == "hot_gas_bypass") h.magnitude = between(0.3, 0.5);
    return h;
  }

  const BlindPlan& plan_;
  const BlindSite& site_;
};

}  // namespace

DrawnCase drawn_case(const BlindPlan& plan, const BlindSite& site, int i, const PlannedCase& c) {
  return CaseDrawing(plan, site).of(i, c);
}

void write_window_weather(const std::filesystem::path& folder, std::uint64_t seed) {
  std::filesystem::create_directories(folder / "weather");
  for (int w = 0; w < blind_windows; ++w) {
    const auto weather = sim::synthetic_weather(seed * 1000 + static_cast<std::uint64_t>(w), {},
                                                fmt::format("of window {}, seed {}", w, seed));
    sim::write_epw(weather_of_window(folder, w).string(), *weather, 2021);
  }
}

BlindSetup setup_of(const BlindPlan& plan, const std::vector<sim::Effect>& effects,
                    const std::filesystem::path& folder) {
  BlindSetup setup;
  setup.twin = plan.twin;
  setup.seed = plan.seed;
  setup.days = plan.days;
  setup.jobs = plan.jobs;
  setup.rough = plan.rough;
  setup.cache = plan.cache;
  setup.effects = &effects;
  for (int w = 0; w < blind_windows; ++w) {
    setup.starts.push_back(start_of_window(w));
    setup.weather.push_back(weather_of_window(folder, w));
  }
  return setup;
}

}  // namespace airside::tools::gap
