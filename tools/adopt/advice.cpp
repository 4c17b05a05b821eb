#include "tools/adopt/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string_view>
#include <vector>

namespace airside::tools {

namespace {

using nlohmann::json;

constexpr double sensor_tolerance_k = 0.2;
constexpr double load_saves = 0.1;  ///< share
constexpr const char* section_title = "## Is a setpoint worth it";
constexpr std::string_view headline_mark = "**Advice: ";

/// Seasons of which something is known.
std::vector<const Comparison*> known_seasons(const Adoption& a) {
  std::vector<const Comparison*> out;
  for (const Comparison& c : a.seasons) {
    if (c.known()) out.push_back(&c);
  }
  return out;
}

using Seasons = std::vector<const Comparison*>;

/// "1.0 in summer, 2.0 in winter and 3.0 in autumn".
template <class Text>
std::string by_season(const Seasons& seasons, Text&& text) {
  std::string out;
  for (std::size_t n = 0; n < seasons.size(); ++n)
    out += fmt::format("{}{} in {}",
                       n == 0                    ? ""
                       : n + 1 == seasons.size() ? " and "
                                                 : ", ",
                       text(*seasons[n]), text_of(seasons[n]->season));
  return out;
}

/// "12.3 % less".
std::string beside(double kwh, double other_kwh) {
  if (other_kwh <= 0) return "not to be compared: the other takes nothing";
  const double percent = 100 * (kwh - other_kwh) / other_kwh;
  return fmt::format("{:.1f} % {}", std::abs(percent), percent < 0 ? "less" : "more");
}

bool metered(const Adoption& a) { return !a.choices.powers.empty(); }
double range_k(const Adoption& a) { return a.choices.max_degc - a.choices.min_degc; }

double most_room_gain(const Seasons& seasons) {
  double most = 0;
  for (const Comparison* c : seasons) most = std::max(most, std::abs(c->response.room_gain));
  return most;
}

/// Sums over the seasons.
struct Sums {
  DayFigures own, best;
  double allowance_degch = 0;
};

Sums sums_of(const Seasons& seasons) {
  Sums sums;
  for (const Comparison* c : seasons) {
    sums.own.kwh += c->own.kwh;
    sums.own.outside_degch += c->own.outside_degch;
    sums.best.kwh += c->best().figures.kwh;
    sums.best.outside_degch += c->best().figures.outside_degch;
    sums.allowance_degch += c->allowance_degch();
  }
  return sums;
}

bool better_by_load(const Seasons& seasons) {
  const Sums sums = sums_of(seasons);
  return sums.own.kwh <= (1 - load_saves) * sums.best.kwh &&
         sums.own.outside_degch <= sums.best.outside_degch + sums.allowance_degch;
}

/// -1: the coldest of the range is the best constant in every season in which the supply follows; 1: the warmest; 0:
/// neither.
int best_end(const Seasons& seasons) {
  const auto always = [&](auto&& end) {
    return std::ranges::all_of(
        seasons, [&](const Comparison* c) { return !c->response.has_authority() || &c->best() == &end(*c); });
  };
  if (always([](const Comparison& c) -> const HeldDays& { return c.constants.front(); })) return -1;
  return always([](const Comparison& c) -> const HeldDays& { return c.constants.back(); }) ? 1 : 0;
}

std::string best_constants(const Adoption& a, const Seasons& seasons) {
  if (!metered(a)) return " Nothing meters which constant takes least.";
  return " The best constant was " +
         by_season(seasons,
                   [](const Comparison& c) {
                     const HeldDays& best = c.best();
                     return fmt::format("{:.1f} degC ({:.1f} kWh a day, {} than under the model's own control)",
                                        best.setpoint_degc, best.figures.kwh, beside(best.figures.kwh, c.own.kwh));
                   }) +
         ".";
}

Advice by_schedule(const Adoption& a, const Seasons& seasons, std::string reason) {
  return {Verdict::schedule, "", "leave the setpoint to a schedule", std::move(reason) + best_constants(a, seasons)};
}

Advice by_load(const Seasons& seasons) {
  const Sums sums = sums_of(seasons);
  const auto days = static_cast<double>(seasons.size());
  std::string why =
      "Under control by load its coils and fan rest when the zone needs nothing; a day took " +
      by_season(seasons, [](const Comparison& c) { return fmt::format("{:.1f} kWh", c.own.kwh); }) +
      ". Adopting switches the unit to a setpoint, and held at the best constant it took " +
      by_season(seasons,
                [](const Comparison& c) {
                  return fmt::format("{:.1f} kWh ({:.1f} degC)", c.best().figures.kwh, c.best().setpoint_degc);
                }) +
      fmt::format(": {:.1f} kWh a day more, mean of these days, which is {}.", (sums.best.kwh - sums.own.kwh) / days,
                  beside(sums.best.kwh, sums.own.kwh));
  why += fmt::format(" Zones were outside their band by {:.2f} degree-hours a day under load, by {:.2f} at constants.",
                     sums.own.outside_degch / days, sums.best.outside_degch / days);
  return {Verdict::own_control, "", "leave the unit under its own control by load", why};
}

Advice worth_mean(const Adoption& a, const Seasons& seasons) {
  std::string why =
      "1 K of setpoint moves the rooms by " +
      by_season(seasons, [](const Comparison& c) { return fmt::format("{:.2f} K", c.response.room_gain); }) + ".";
  if (metered(a)) {
    why += " A day took " +
           by_season(seasons,
                     [](const Comparison& c) {
                       const HeldDays& best = c.best();
                       return fmt::format(
                           "{:.1f} kWh at the best constant, {:.1f} degC ({} than under the model's own control)",
                           best.figures.kwh, best.setpoint_degc, beside(best.figures.kwh, c.own.kwh));
                     }) +
           ".";
  }
  if (a.setpoint.knew_the_load)
    why += " The model's own control is no rival that a building can have: it takes the zone's load of the same step.";
  return {Verdict::control, "mean", "worth controlling, with objective = \"mean\"", why};
}

Advice worth_band(const Adoption& a, const Seasons& seasons) {
  std::string why = "Boxes and thermostats hold the rooms, and the setpoint decides what that takes.";
  if (metered(a)) {
    why += best_constants(a, seasons) + " What is best moves with the weather, and \"band\" follows it.";
  }
  return {Verdict::control, "band", "worth controlling, with objective = \"band\"", why};
}

}  // namespace

const char* text_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::control: return "control";
    case Verdict::schedule: return "schedule";
    case Verdict::own_control: return "own-control";
    case Verdict::undecided: break;
  }
  return "undecided";
}

Advice advice_on(const Adoption& a) {
  const Seasons seasons = known_seasons(a);
  if (seasons.empty()) {
    return {Verdict::undecided, "", "nothing can be said",
            "The fan did not run in the working hours of the days that were tried."};
  }
  if (a.setpoint.unit_switched && !metered(a)) {
    return {Verdict::undecided, "", "nothing can be said",
            "The unit was under control by load, and nothing meters what the switch to a setpoint costs."};
  }
  if (a.setpoint.unit_switched && better_by_load(seasons)) return by_load(seasons);
  if (std::ranges::none_of(seasons, [](const Comparison* c) { return c->response.has_authority(); })) {
    return by_schedule(a, seasons,
                       "The supply air does not follow the setpoint: " + by_season(seasons, [](const Comparison& c) {
                         return fmt::format("{:.2f} K per K", c.response.supply_gain);
                       }) + ".");
  }
  if (a.serves_band()) {
    const int end = best_end(seasons);
    if (end == 0 || !metered(a)) return worth_band(a, seasons);
    return by_schedule(a, seasons,
                       fmt::format("The {} air of the range was the best constant in every season, so there is nothing "
                                   "to follow.",
                                   end < 0 ? "coldest" : "warmest"));
  }
  const double gain = most_room_gain(seasons);
  if (a.loop.kind() == TerminalKind::fixed && gain * range_k(a) >= sensor_tolerance_k) return worth_mean(a, seasons);
  const std::string moved =
      fmt::format("1 K of setpoint moves the rooms by at most {:.3f} K, its whole range of {:.1f} K by {:.2f} K", gain,
                  range_k(a), gain * range_k(a));
  if (a.loop.kind() == TerminalKind::fixed) {
    return by_schedule(a, seasons,
                       moved + fmt::format(", less than the {:.1f} K by which a room sensor may be off: equipment in "
                                           "the rooms holds them.",
                                           sensor_tolerance_k));
  }
  return by_schedule(a, seasons,
                     moved +
                         ": dampers or coils of the boxes hold them. The objective \"band\" would need a damper and "
                         "a thermostat of every box, and \"mean\" would work against the boxes.");
}

std::string advice_section(const Adoption& a) {
  const Advice advice = advice_on(a);
  std::string text = fmt::format("{}\n\n**Advice: {}.** {}\n", section_title, advice.headline, advice.why);
  if (known_seasons(a).empty()) return text;
  text +=
      "\n| season | own control | the site's schedule | best constant | all constants | rooms, K per K |\n"
      "|---|---|---|---|---|---|\n";
  const auto figures = [](const DayFigures& f) { return fmt::format("{:.1f} / {:.2f}", f.kwh, f.outside_degch); };
  for (const Comparison* c : known_seasons(a)) {
    std::string all;
    for (const HeldDays& held : c->constants)
      all += fmt::format("{}{:.1f}: {}", all.empty() ? "" : "; ", held.setpoint_degc, figures(held.figures));
    text += fmt::format("| {} | {} | {} | {:.1f} degC: {} | {} | {:.3f} |\n", text_of(c->season), figures(c->own),
                        figures(c->schedule), c->best().setpoint_degc, figures(c->best().figures), all,
                        c->response.room_gain);
  }
  return text +
         "\nkWh a day by the power meters below / zone degree-hours a day above cooling setpoint + 0.5 K and "
         "below heating setpoint - 0.5 K while people are there. The same Monday and Tuesday each time. The "
         "best constant takes least energy among those that hold the zones as well as any, to 0.05 degree-hours "
         "a zone and day. No setpoint was controlled here: a controller can do better than a constant.\n";
}

std::string advice_lines(const Adoption& a) {
  const Advice advice = advice_on(a);
  return fmt::format("advice: {}.\n  {}\n", advice.headline, advice.why);
}

json json_of(const Advice& advice) {
  return {{"verdict", text_of(advice.verdict)},
          {"objective", advice.objective.empty() ? json(nullptr) : json(advice.objective)},
          {"headline", advice.headline},
          {"why", advice.why}};
}

json json_of(const Comparison& c) {
  if (!c.response.known) return nullptr;
  const Response& r = c.response;
  json out = {{"supply_gain", r.supply_gain}, {"room_gain", r.room_gain}, {"kw_low", r.kw_low}, {"kw_high", r.kw_high}};
  const auto figures = [](const DayFigures& f) {
    return json{{"kwh_per_day", f.kwh}, {"outside_degch_per_day", f.outside_degch}};
  };
  out["own"] = figures(c.own);
  out["schedule"] = figures(c.schedule);
  for (const HeldDays& held : c.constants) {
    json constant = figures(held.figures);
    constant["setpoint_degc"] = held.setpoint_degc;
    out["constants"].push_back(std::move(constant));
  }
  if (c.known()) out["best_constant_degc"] = c.best().setpoint_degc;
  return out;
}

std::string advice_of_page(const std::filesystem::path& page) {
  std::ifstream in(page);
  std::string line;
  while (std::getline(in, line) && line != section_title) continue;
  while (std::getline(in, line)) {
    if (line.empty()) continue;
    if (!line.starts_with(headline_mark)) return {};
    std::erase(line, '*');
    return line.substr(std::string_view("Advice: ").size());
  }
  return {};
}

}  // namespace airside::tools
