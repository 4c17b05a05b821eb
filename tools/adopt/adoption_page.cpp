// adopt.md.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "hal/text/shell_word.hpp"
#include "tools/adopt/advice.hpp"
#include "tools/adopt/site_text.hpp"

namespace airside::tools {

namespace {

std::string hour_text(double h) {
  return fmt::format("{:02}:{:02}", static_cast<int>(h), static_cast<int>(h * 60) % 60);
}

/// `Monday to Friday 07:00 to 22:00, Saturday 07:00 to 14:00, Sunday nobody`.
std::string week_text(const std::array<PeopleHours, 7>& days) {
  static constexpr std::array names = {"Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday"};
  std::string text;
  for (std::size_t i = 0, last = 0; i < days.size(); i = last + 1) {
    last = i;
    while (last + 1 < days.size() && days[last + 1] == days[i]) ++last;
    text +=
        fmt::format("{}{}{}", text.empty() ? "" : ", ", names[i], last > i ? std::string(" to ") + names[last] : "");
    text += days[i].from_h == days[i].to_h
                ? std::string(" nobody")
                : fmt::format(" {} to {}", hour_text(days[i].from_h), hour_text(days[i].to_h));
  }
  return text;
}

std::string hours_text(const DayHours& hours) {
  return fmt::format("{} to {}{}{}", hour_text(hours.from_h), hour_text(hours.to_h),
                     hours.weekday_only ? ", weekdays" : ", every day",
                     hours.interrupted ? "; the pattern is not one interval, so this is an approximation" : "");
}

std::string found_table(const Adoption& a) {
  std::map<std::string, int> kinds;
  for (const LoopTerminal& t : a.loop.terminals) ++kinds[t.type];
  std::string terminals;
  for (const auto& [type, count] : kinds)
    terminals += fmt::format("{}{} {}", terminals.empty() ? "" : ", ", count, type);
  std::string equipment;
  for (const LoopComponent& c : a.loop.components) equipment += (equipment.empty() ? "" : ", ") + c.type;
  std::string text = "| what | found |\n|---|---|\n";
  const auto row = [&](const char* what, const std::string& found) {
    text += fmt::format("| {} | {} |\n", what, found);
  };
  row("air loop", a.loop.name + ", supply outlet node `" + a.loop.supply_outlet + "`");
  row("equipment, in the air's order", equipment);
  row("supply fan",
      a.loop.fan.name.empty() ? "none: there is no point ahu_on" : a.loop.fan.type + " " + a.loop.fan.name);
  row("terminals", terminals + fmt::format(" ({})", text_of(a.loop.kind())));
  row("fan coils in its zones", a.loop.fcu_zones.empty() ? "none" : std::to_string(a.loop.fcu_zones.size()));
  row("outdoor air", a.loop.mixed_air_node.empty() ? "none"
                     : a.loop.outdoor_air_treated
                         ? "treated before it is mixed: mau_temp is the node `" + a.loop.outdoor_stream_node + "`"
                         : "mixed as it is");
  text += "\n| point | zone | terminal | thermostat |\n|---|---|---|---|\n";
  int n = 0;
  for (const LoopTerminal& t : a.loop.terminals)
    text += fmt::format("| room_temp_{} | {} | {}, {} | {} |\n", ++n, t.zone, t.name, text_of(t.kind),
                        t.thermostat ? "yes" : "no");
  return text;
}

std::string chosen_table(const Adoption& a) {
  const SiteChoices& c = a.choices;
  std::string powers;
  for (const std::string& meter : c.powers) powers += (powers.empty() ? "`" : ", `") + meter + "`";
  std::string text = "| what | chosen | from |\n|---|---|---|\n";
  text += fmt::format("| target | {:.2f} degC | mean of the rooms in working hours of a summer week, own control |\n",
                      c.target_degc);
  text += fmt::format("| working hours | {} | {} |\n", hours_text(c.work),
                      c.people          ? "people in the zones, more than a quarter of the most"
                      : c.assumed_hours ? "**assumed**: neither people nor a schedule of the thermostats"
                                        : "the thermostats' cooling setpoints");
  if (!c.assumed_hours) {
    text += fmt::format("| day types | {} | people (else thermostats) day by day: {}{} |\n",
                        c.work.weekday_only ? "working days, days off"
                        : c.two_day_types   ? "working days, weekends"
                                            : "one",
                        week_text(c.people_by_day),
                        c.people ? "; where the site has `occupied`, comfort is counted by that and not by hours" : "");
  }
  text += fmt::format("| fan | {} | flow at the supply outlet |\n", hours_text(c.fan));
  text += fmt::format(
      "| setpoint range | {:.1f} to {:.1f} degC | the model's own setpoints in both weeks, and what it reached |\n",
      c.min_degc, c.max_degc);
  text += fmt::format(
      "| schedule | {:.1f} degC at work, {:.1f} otherwise | the model's own setpoint, means of the summer week; at "
      "work in "
      "the winter week it was {:.1f} |\n",
      c.work_degc, c.off_degc, c.winter_degc);
  text += fmt::format("| power meters | {} | those named Loop count this loop alone, the others the whole building |\n",
                      powers.empty() ? "none" : powers);
  text += fmt::format("| weather | {} | {} |\n", a.weather_name, a.weather_note);
  return text;
}

/// What brought an older model to the engine's version, type by type; empty where nothing did.
std::string upgrade_section(const Upgrade& upgrade) {
  if (upgrade.from.empty()) return {};
  std::string text = fmt::format("\n## Upgraded from EnergyPlus {} to {}\n\n", upgrade.from, upgrade.to);
  if (!upgrade.programs.empty())
    return text + "By the Transition programs of " + upgrade.programs + ", before all else.\n";
  text += fmt::format(
      "{} objects were changed by the tables of airside, before all else; what no step changed is as it was. Names "
      "of output variables are left as they are: none is read here.\n\n"
      "| object type | changed | by the steps to |\n|---|---|---|\n",
      upgrade.objects());
  for (const UpgradedType& type : upgrade.types)
    text += fmt::format("| {} | {} | {} |\n", type.type, type.objects, type.versions);
  return text;
}

std::string response_row(const char* season, const Response& r) {
  if (!r.known) return fmt::format("| {} | the fan does not run in working hours | | | | |\n", season);
  return fmt::format("| {} | {:.1f} / {:.1f} | {:.2f} | {:.2f} / {:.2f} | {:.3f} | {} | {:.1f} / {:.1f} |\n", season,
                     r.supply_low_degc, r.supply_high_degc, r.supply_gain, r.room_low_degc, r.room_high_degc,
                     r.room_gain,
                     r.damper_low < 0 ? std::string("-") : fmt::format("{:.2f} / {:.2f}", r.damper_low, r.damper_high),
                     r.kw_low, r.kw_high);
}

std::string response_text(const Adoption& a) {
  std::string text = fmt::format(
      "Two days of each season with the setpoint held at {:.1f} and at {:.1f} degC; means over working hours with the "
      "fan "
      "on.\n\n| season | supply reached, degC | K per K | rooms, degC | K per K | dampers | kW of the meters |\n"
      "|---|---|---|---|---|---|---|\n",
      a.probed_min_degc, a.probed_max_degc);
  for (const Comparison& c : a.seasons) text += response_row(text_of(c.season), c.response);
  for (const Comparison& c : a.seasons) {
    if (c.response.known && !c.response.has_authority())
      text += fmt::format(
          "\n**In {} the supply air does not follow the setpoint** ({:.2f} K per K): learning is of no use there.\n",
          text_of(c.season), c.response.supply_gain);
  }
  if (std::abs(a.choices.winter_degc - a.choices.work_degc) > 3)
    text +=
        "\n**The model's own setpoint differs by season**: the schedule of the site file is the summer's. Set [expert] "
        "before a heating season.\n";
  return text;
}

std::string missing_text(const Adoption& a) {
  std::string text = "- rain: `[stand_in] rain = 0`\n- on/off of the boxes: `[stand_in] vav_on = 1`\n";
  if (!a.loop.outdoor_air_treated)
    text += "- make-up air: nothing treats the outdoor air, `[stand_in] mau_temp = 20.0`\n";
  if (!a.shows_people()) text += "- people: no point `occupied`\n";
  if (a.choices.powers.empty()) text += "- power: no meter of fans, cooling or heating\n";
  if (a.loop.fan.name.empty()) text += "- the supply fan: no point `ahu_on`\n";
  for (const LoopTerminal& t : a.loop.terminals) {
    if (!t.thermostat) text += "- a thermostat in zone " + t.zone + "\n";
  }
  if (a.sizes.open > 0)
    text +=
        fmt::format("- a size for {} autosized fields: they stay autosized, and the engine sizes them at each start\n",
                    a.sizes.open);
  return text;
}

}  // namespace

std::string next_steps(const Adoption& a, const std::string& folder) {
  const auto file = [&folder](const char* name) { return hal::shell_word(folder + name); };
  std::string text;
  if (!a.serves_band()) text += fmt::format("airside pretrain --site {} -o {}\n", file("site.toml"), file("site.blob"));
  return text + fmt::format(
                    "airside check {0}\n"
                    "airside serve --site {0} --twin --start 2021-07-05 --days 7 &\n"
                    "airsided --site {0} --until 2021-07-12T00:00:00 --no-sync\n"
                    "airside report {1} --site {0} -o {2}\n",
                    file("site.toml"), file("log"), file("report"));
}

std::string adoption_page(const Adoption& a) {
  std::string text = fmt::format("# {}: air loop {}\n\nWritten by `airside adopt` with EnergyPlus {}. Topology {}.\n\n",
                                 a.model_name, a.loop.name, a.engine, a.topology());
  text += advice_section(a) + "\n## Found\n\n" + found_table(a) + "\n";
  for (const std::string& note : a.loop.notes) text += "- " + note + "\n";
  text += "\n## Chosen\n\n" + chosen_table(a);
  text += upgrade_section(a.upgrade);
  text += "\n## Changed in the model (twin.patch.json)\n\n";
  text += "- the supply-air setpoint is the schedule \"" + a.setpoint.schedule + "\"\n";
  for (const std::string& note : a.setpoint.notes) text += "- " + note + "\n";
  text += fmt::format("- {} autosized fields have the sizes that the engine found\n", a.sizes.written);
  for (const std::string& note : a.notes) text += "- " + note + "\n";
  text += "\n## What the setpoint does\n\n" + response_text(a);
  text += "\n## Not found\n\n" + missing_text(a);
  return text + "\n## Next\n\nIn this folder:\n\n```text\n" + next_steps(a, "") + "```\n";
}

}  // namespace airside::tools
