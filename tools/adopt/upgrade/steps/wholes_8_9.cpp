// What the steps to 9.0, 9.1 and 9.2 change beyond single fields.

#include <algorithm>
#include <array>
#include <map>

#include "tools/adopt/upgrade/steps/wholes.hpp"

namespace airside::tools::upgrade {

namespace {

/// Whether a run passes the end of the year; months are in these fields, days behind them.
bool passes_new_year(const IdfObject& period, int begin_month, int end_month) {
  const auto day_of_year = [&](int month) { return 100 * period.number(month) + period.number(month + 1); };
  return day_of_year(end_month) < day_of_year(begin_month);
}

void run_period(IdfObject& old, std::vector<Refusal>& refused) {
  if (!old.field(12).empty() && old.number(12) != 1) {
    refused.push_back({old.type, old.name(), "it is repeated, and no version since repeats a run period", old.line});
    return;
  }
  const std::string year = old.field(14);
  const int end_year = static_cast<int>(old.number(14)) + (passes_new_year(old, 2, 4) ? 1 : 0);
  IdfObject period = old;
  period.fields.clear();
  for (int n = 1; n <= 3; ++n) period.set(n, old.field(n));
  period.set(4, year);
  period.set(5, old.field(4));
  period.set(6, old.field(5));
  if (!year.empty()) period.set(7, std::to_string(end_year));
  if (!IdfText::same(old.field(6), "UseWeatherFile")) period.set(8, old.field(6));
  for (int n = 7; n <= 11; ++n) period.set(n + 2, old.field(n));
  period.mark("9.0");
  old = std::move(period);
}

struct ShadedType {
  const char* type;
  int base, control;  ///< fields of the surface that it lies in, and of its shading control
};
constexpr std::array shaded_types = {ShadedType{"FenestrationSurface:Detailed", 4, 7}, ShadedType{"Window", 3, 4},
                                     ShadedType{"GlazedDoor", 3, 4}};

std::string zone_of_surface(IdfText& idf, const std::string& surface) {
  if (const IdfObject* found = idf.find("BuildingSurface:Detailed", surface)) return found->field(4);
  for (const char* type : {"Wall:Detailed", "RoofCeiling:Detailed", "Floor:Detailed", "Wall:Exterior", "Roof"}) {
    if (const IdfObject* found = idf.find(type, surface)) return found->field(3);
  }
  return {};
}

/// The zones in which a control has windows, with these windows.
std::map<std::string, std::vector<std::string>> windows_by_zone(IdfText& idf, const std::string& control) {
  std::map<std::string, std::vector<std::string>> zones;
  for (const ShadedType& shaded : shaded_types) {
    for (const IdfObject* window : idf.all(shaded.type)) {
      if (!IdfText::same(window->field(shaded.control), control)) continue;
      zones[zone_of_surface(idf, window->field(shaded.base))].push_back(window->name());
    }
  }
  return zones;
}

std::string daylighting_of(IdfText& idf, const std::string& zone) {
  for (const IdfObject* control : idf.all("Daylighting:Controls")) {
    if (IdfText::same(control->field(2), zone)) return control->name();
  }
  return {};
}

void shading_controls(IdfText& idf, std::vector<Refusal>& refused) {
  std::vector<IdfObject> made;
  std::map<std::string, int> in_zone;
  for (IdfObject* old : idf.all("WindowProperty:ShadingControl")) {
    const auto zones = windows_by_zone(idf, old->name());
    if (zones.contains("")) {
      refused.push_back(
          {old->type, old->name(), "it must name the zone of its windows, which is not found", old->line});
    }
    for (const auto& [zone, windows] : zones) {
      IdfObject control{"WindowShadingControl", {}, old->line, {}};
      control.set(1, zones.size() == 1 ? old->name() : old->name() + " " + zone);
      control.set(2, zone);
      control.set(3, std::to_string(++in_zone[zone]));
      for (int n = 2; n <= 12; ++n) control.set(n + 2, old->field(n));
      control.set(15, daylighting_of(idf, zone));
      control.set(16, "Sequential");
      for (std::size_t n = 0; n < windows.size(); ++n) control.set(17 + static_cast<int>(n), windows[n]);
      control.mark("9.0");
      made.push_back(std::move(control));
    }
  }
  std::erase_if(idf.objects, [](const IdfObject& o) { return o.is("WindowProperty:ShadingControl"); });
  std::ranges::move(made, std::back_inserter(idf.objects));
}

/// The first field behind name and load distribution.
constexpr std::size_t first_equipment = 2;

}  // namespace

void run_periods_and_shading(IdfText& idf, std::vector<Refusal>& refused) {
  for (IdfObject* period : idf.all("RunPeriod")) run_period(*period, refused);
  shading_controls(idf, refused);
}

void wider_equipment_lists(IdfText& idf, std::vector<Refusal>& /*refused*/) {
  for (IdfObject* list : idf.all("ZoneHVAC:EquipmentList")) {
    for (std::size_t at = first_equipment + 4; at < list->fields.size(); at += 6) {
      if (list->insert(static_cast<int>(at + 1), 2)) list->mark("9.1");
    }
  }
}

void fractions_and_names(IdfText& idf, std::vector<Refusal>& /*refused*/) {
  int unnamed = 0;
  for (IdfObject* period : idf.all("RunPeriod")) {
    if (!period->name().empty()) continue;
    period->set(1, "Run Period " + std::to_string(++unnamed));
    period->mark("9.2");
  }
  std::vector<IdfObject> schedules;
  for (IdfObject* list : idf.all("ZoneHVAC:EquipmentList")) {
    for (std::size_t at = first_equipment + 4; at < list->fields.size(); ++at) {
      std::string& fraction = list->fields[at];
      if ((at - first_equipment) % 6 < 4 || fraction.empty()) continue;
      const std::string name = list->name() + " Fraction " + std::to_string(at);
      schedules.push_back({"Schedule:Constant", {name, "", fraction}, list->line, {"9.2"}});
      fraction = name;
      list->mark("9.2");
    }
  }
  std::ranges::move(schedules, std::back_inserter(idf.objects));
}

}  // namespace airside::tools::upgrade
