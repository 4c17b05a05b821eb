#include "tools/cli/site/site_signals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hal/points/point_map.hpp"
#include "hal/text/civil_text.hpp"
#include "tools/study/missing_signals.hpp"

namespace airside::tools {

namespace {

const char* use_of(SignalKind kind) {
  switch (kind) {
    case SignalKind::fcu_temp: return "temperature at the fan coils, an input of the forecast";
    case SignalKind::vav_on: return "which boxes take air, an input of the forecast";
    case SignalKind::fcu_on: return "which fan coils run, an input of the forecast";
    case SignalKind::power: return "electric power, an input of the forecast and the energy of logs and reports";
    case SignalKind::mau_temp: return "air from the make-up air unit, an input of the forecast";
    case SignalKind::outdoor_temp: return "weather, an input of the forecast";
    case SignalKind::rain: return "wet days, an input of the forecast";
    default: return "control";
  }
}

const char* band_use_of(SignalKind kind) {
  return kind == SignalKind::power ? "electric power, from which band learns what a setpoint costs, and the energy of "
                                     "logs and reports"
                                   : "the forecast of \"mean\"";
}

/// Figures of the results' table of missing meters.
constexpr const char* band_cost_of_meter =
    "what this meter would show is not saved, and reports have no energy of it: energy +1.1 ± 1.7 % without the meter "
    "of cooling, -0.2 ± 0.2 % without those of heat, +0.5 ± 0.3 % without the fan's (two adopted buildings, two "
    "fortnights)";

/// The measured figures are of the objective "mean"; "band" reads but power of these kinds.
std::string cost_of(SignalKind kind, bool band) {
  if (band) {
    return kind == SignalKind::power ? band_cost_of_meter : "none, band does not read it";
  }
  return cost_text(measured_cost_degc(kind)) + (kind == SignalKind::power ? ", and reports have no energy of it" : "");
}

/// Signals in their order; one entry for a row of the same kind and stand-in.
std::vector<LackingSignals> with_stand_ins(const hal::TopologyCounts& counts, bool band) {
  std::vector<LackingSignals> found;
  std::optional<SignalId> last;
  for (int i = 0; i < counts.signals(); ++i) {
    const auto value = counts.stand_in(i);
    if (!value) continue;
    const SignalId id = counts.signal(i);
    if (last && last->kind == id.kind && last->place + 1 == id.place && found.back().stand_in == value) {
      std::string& names = found.back().names;
      names = names.substr(0, names.find(" to ")) + " to " + hal::point_name(id);
    } else {
      found.push_back({hal::point_name(id), band ? band_use_of(id.kind) : use_of(id.kind),
                       fmt::format("{:g} stands in", *value), cost_of(id.kind, band), value});
    }
    last = id;
  }
  return found;
}

/// `damper_1 to damper_3, damper_5` of the places without such a point; "" where none is missing.
std::string missing_places(const hal::PointMap& map, const std::string& stem, int vavs) {
  std::string text;
  const auto lacks = [&](int place) { return place <= vavs && map.find(fmt::format("{}_{}", stem, place)) == nullptr; };
  for (int first = 1; first <= vavs; ++first) {
    if (!lacks(first)) continue;
    int last = first;
    while (lacks(last + 1)) ++last;
    text += fmt::format("{}{}_{}", text.empty() ? "" : ", ", stem, first);
    if (last > first) text += fmt::format(" to {}_{}", stem, last);
    first = last;
  }
  return text;
}

/// A side signal in words, for either objective.
struct SideText {
  const char* name;
  const char* use;
  const char *mean_instead, *mean_cost;
  const char *band_instead, *band_cost;
};

constexpr const char* refused = "nothing, band is refused without it";

constexpr std::array<SideText, 3> zone_texts = {
    {{"damper", "how far each box is open", "nothing, mean does not read it",
      "objective = \"band\" cannot be chosen, and reports have no hours of saturated boxes", refused, "no band"},
     {"zone_setpoint", "above which each zone is cooled", "nothing, mean does not read it",
      "objective = \"band\" cannot be chosen, and reports have no degree-hours above the zones' setpoints", refused,
      "no band"},
     {"zone_heating_setpoint", "below which each zone is heated", "nothing, mean does not read it", "none for control",
      "heating is taken to begin some 3 K below the cooling setpoint, where the zone was seen to be held",
      "no zone counts as too cold, so the setpoint is not warmed for one: energy -0.1 ± 0.6 %, zone degree-hours "
      "+0.10 a day"}}};

constexpr std::array<SideText, 3> single_texts = {
    {{"supply_temp", "whether supply air follows its setpoint", "the setpoint is taken for it",
      "an AHU that does not follow raises no alarm by its air", refused, "no band"},
     {"supply_flow", "air of the supply fan", "nothing, mean only logs it", "none for control",
      "the heat that the air takes is learned from the meters alone",
      "cooling and reheat are separated more slowly: energy -0.2 ± 0.3 %, zone degree-hours +0.07 a day"},
     {"occupied", "whether people are there", "reports count every hour in which the fan is not known to rest",
      "degree-hours of empty hours are counted; none for control",
      "reports count every hour in which the fan is not known to rest",
      "degree-hours of empty hours are counted; none for control"}}};

LackingSignals in_words(const SideText& text, std::string names, bool band) {
  return {std::move(names), text.use, band ? text.band_instead : text.mean_instead,
          band ? text.band_cost : text.mean_cost, std::nullopt};
}

LackingSignals without_ahu_on(const hal::SiteFile& site) {
  const char* measured =
      site.objective == Objective::band ? "energy -0.7 ± 1.2 %, zone degree-hours +0.26 a day" : "not measured";
  const bool always = site.fan_start_s == 0 && site.fan_end_s == 24 * 3600 && !site.fan_weekday_only;
  return {"ahu_on", "whether the fan runs",
          always ? std::string("the fan is taken to run always, as [ahu] has it")
                 : fmt::format("the hours of [ahu] stand in, {} to {}{}", hal::clock_text(site.fan_start_s),
                               hal::clock_text(site.fan_end_s), site.fan_weekday_only ? " on weekdays" : ""),
          always
              ? std::string(
                    "a fan that stands still is not noticed: such hours are learned from, and supply air that cannot "
                    "follow is an alarm; give fan_start and fan_end where it rests")
              : fmt::format("a fan that starts or stops at other times is not noticed: such hours are learned from, or "
                            "left out; {}",
                            measured),
          std::nullopt};
}

}  // namespace

std::vector<LackingSignals> missing_signals(const hal::SiteFile& site, const hal::PointMap& map,
                                            const hal::TopologyCounts& counts) {
  const bool band = site.objective == Objective::band;
  std::vector<LackingSignals> found = with_stand_ins(counts, band);
  if (map.find("ahu_on") == nullptr) found.push_back(without_ahu_on(site));
  for (const SideText& text : single_texts) {
    if (map.find(text.name) == nullptr) found.push_back(in_words(text, text.name, band));
  }
  for (const SideText& text : zone_texts) {
    std::string names = missing_places(map, text.name, counts.vavs);
    if (!names.empty()) found.push_back(in_words(text, std::move(names), band));
  }
  return found;
}

std::string signal_facts(const hal::SiteFile& site, const hal::TopologyCounts& counts,
                         const std::vector<LackingSignals>& missing) {
  const bool has_all = std::ranges::none_of(missing, [](const LackingSignals& m) { return m.stand_in.has_value(); });
  std::string text = has_all ? "each input of the forecast is sensed" : "some inputs of the forecast are not sensed";
  std::string sides;
  for (const hal::SideColumn& side : counts.sides) sides += (sides.empty() ? "" : ", ") + hal::column_of(side);
  if (!sides.empty()) text += "; also shown: " + sides;
  if (!missing.empty()) text += "; missing:";
  for (const LackingSignals& m : missing) {
    text += fmt::format("\n       {}: for {}; {}; cost: {}", m.names, m.use, m.instead, m.cost);
  }
  if (!has_all && site.objective == Objective::mean) {
    text += fmt::format(
        "\n       Figures: {}, each kind alone. DAE {:.3f} ± {:.3f} °C with all inputs, {:.3f} ± {:.3f} °C with room "
        "temperatures, setpoint and outdoor_temp alone (`airside study signals`)",
        measured_on, measured_dae_degc.whole.mean, measured_dae_degc.whole.sd, measured_dae_degc.bare.mean,
        measured_dae_degc.bare.sd);
  }
  if (std::ranges::any_of(missing,
                          [](const LackingSignals& m) { return m.cost.find("energy -") != std::string::npos; })) {
    text += "\n       Figures: four adopted buildings, three fortnights, each kind alone; mean ± sd of the twelve runs";
  }
  return text;
}

}  // namespace airside::tools
