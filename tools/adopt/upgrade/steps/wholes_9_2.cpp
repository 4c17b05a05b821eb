// What the steps to 9.3, 9.4 and 24.1 change beyond single fields.

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/adopt/upgrade/steps/wholes.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr const char* uncontrolled = "AirTerminal:SingleDuct:Uncontrolled";
constexpr const char* constant_volume = "AirTerminal:SingleDuct:ConstantVolume:NoReheat";

/// Replaces a node in the fields from `first` on, by itself or in a list of nodes, which is then copied.
void rename_node(IdfText& idf, const std::string& type, int first, const std::string& node, const std::string& to) {
  std::vector<IdfObject> lists;
  for (IdfObject* object : idf.all(type)) {
    for (auto at = static_cast<std::size_t>(first - 1); at < object->fields.size(); ++at) {
      std::string& field = object->fields[at];
      if (IdfText::same(field, node)) {
        field = to;
        object->mark("9.3");
        continue;
      }
      const IdfObject* list = field.empty() ? nullptr : idf.find("NodeList", field);
      if (list == nullptr) continue;
      IdfObject copy = *list;
      bool held = false;
      for (std::size_t n = 1; n < copy.fields.size(); ++n) {
        if (!IdfText::same(copy.fields[n], node)) continue;
        copy.fields[n] = to;
        held = true;
      }
      if (!held) continue;
      copy.fields[0] += " ATInlet";
      copy.mark("9.3");
      field = copy.fields[0];
      object->mark("9.3");
      lists.push_back(std::move(copy));
    }
  }
  std::ranges::move(lists, std::back_inserter(idf.objects));
}

void in_equipment_lists(IdfText& idf, const std::string& terminal, const std::string& unit) {
  for (IdfObject* list : idf.all("ZoneHVAC:EquipmentList")) {
    for (std::size_t n = 0; n + 1 < list->fields.size(); ++n) {
      if (!IdfText::same(list->fields[n], uncontrolled) || !IdfText::same(list->fields[n + 1], terminal)) continue;
      list->fields[n] = "ZoneHVAC:AirDistributionUnit";
      list->fields[n + 1] = unit;
      list->mark("9.3");
    }
  }
}

bool in_airflow_network(IdfText& idf, const std::string& node) {
  return std::ranges::any_of(idf.all("AirflowNetwork:Distribution:Node"),
                             [&](const IdfObject* n) { return IdfText::same(n->field(2), node); });
}

IdfObject no_reheat(const IdfObject& old, const std::string& inlet) {
  IdfObject terminal{constant_volume, {}, old.line, old.steps};
  for (int n = 1; n <= 2; ++n) terminal.set(n, old.field(n));
  terminal.set(3, inlet);
  for (int n = 3; n <= 6; ++n) terminal.set(n + 1, old.field(n));
  terminal.mark("9.3");
  return terminal;
}

void uncontrolled_terminals(IdfText& idf, std::vector<Refusal>& refused) {
  std::vector<IdfObject> old;
  for (const IdfObject* terminal : idf.all(uncontrolled)) old.push_back(*terminal);
  std::erase_if(idf.objects, [](const IdfObject& o) { return o.is(uncontrolled); });
  for (const IdfObject& terminal : old) {
    const std::string& node = terminal.field(3);
    if (in_airflow_network(idf, node)) {
      refused.push_back(
          {uncontrolled, terminal.name(), "its node is part of an AirflowNetwork, which needs another", terminal.line});
    }
    const std::string inlet = node + " ATInlet", unit = terminal.name() + " ADU";
    rename_node(idf, "AirLoopHVAC:ZoneSplitter", 3, node, inlet);
    rename_node(idf, "AirLoopHVAC:SupplyPlenum", 5, node, inlet);
    rename_node(idf, "AirLoopHVAC:SupplyPath", 2, node, inlet);
    rename_node(idf, "AirLoopHVAC", 9, node, inlet);
    in_equipment_lists(idf, terminal.name(), unit);
    IdfObject distribution{"ZoneHVAC:AirDistributionUnit",
                           {unit, node, constant_volume, terminal.name(), "", "", terminal.field(7)},
                           terminal.line,
                           {"9.3"}};
    distribution.trim();
    idf.objects.push_back(std::move(distribution));
    idf.objects.push_back(no_reheat(terminal, inlet));
  }
}

void shadow_calculation(IdfObject& old) {
  const auto is = [&](int field, const char* word) { return IdfText::same(old.field(field), word); };
  IdfObject shadows = old;
  shadows.fields.clear();
  shadows.set(1, is(6, "ScheduledShading") ? "Scheduled" : is(6, "ImportedShading") ? "Imported" : "PolygonClipping");
  shadows.set(2, is(1, "TimestepFrequency") ? "Timestep" : "Periodic");
  for (int n = 2; n <= 4; ++n) shadows.set(n + 1, old.field(n));
  shadows.set(7, old.field(5));
  for (int n = 7; n <= static_cast<int>(old.fields.size()); ++n) shadows.set(n + 1, old.field(n));
  shadows.mark("9.3");
  old = std::move(shadows);
}

struct Effectiveness {
  int full, part;  ///< fields at 100 and at 75 % of flow
};
constexpr std::array effectivenesses = {Effectiveness{4, 6}, Effectiveness{5, 7}, Effectiveness{8, 10},
                                        Effectiveness{9, 11}};
constexpr const char* flow_ratio = "Heat Exchanger Flow Ratio";
constexpr const char* flow_ratios = "Heat Exchanger Flow Ratios";

/// Whether the old exchanger changes its effectiveness between the two flows; then the table is added.
std::string table_of(const IdfObject& old, std::size_t which, std::vector<IdfObject>& tables) {
  const std::string& full = old.field(effectivenesses[which].full);
  const std::string& part = old.field(effectivenesses[which].part);
  const double at_full = old.number(effectivenesses[which].full);
  if (at_full == 0 || part.empty() || std::abs(old.number(effectivenesses[which].part) - at_full) < 1e-9) return {};
  const std::string name = old.name() + " Effectiveness " + std::to_string(which + 1);
  tables.push_back({"Table:Lookup",
                    {name, flow_ratios, "DivisorOnly", full, "0", "10", "Dimensionless", "", "", "", part, full},
                    old.line,
                    {"24.1"}});
  return name;
}

void heat_exchanger(IdfObject& old, std::vector<IdfObject>& tables) {
  std::array<std::string, effectivenesses.size()> names;
  for (std::size_t n = 0; n < names.size(); ++n) names[n] = table_of(old, n, tables);
  for (const int field : {11, 10, 7, 6}) old.remove(field);
  for (std::size_t n = 0; n < names.size(); ++n) old.set(20 + static_cast<int>(n), names[n]);
  old.mark("24.1");
}

}  // namespace

void terminals_and_shadows(IdfText& idf, std::vector<Refusal>& refused) {
  uncontrolled_terminals(idf, refused);
  for (IdfObject* shadows : idf.all("ShadowCalculation")) shadow_calculation(*shadows);
}

void one_diagnostics(IdfText& idf, std::vector<Refusal>& /*refused*/) {
  const std::vector<IdfObject*> all = idf.all("Output:Diagnostics");
  if (all.size() < 2) return;
  for (std::size_t n = 1; n < all.size(); ++n) {
    std::ranges::copy(all[n]->fields, std::back_inserter(all[0]->fields));
    all[n]->type.clear();
  }
  all[0]->mark("9.4");
  std::erase_if(idf.objects, [](const IdfObject& o) { return o.type.empty(); });
}

void heat_recovery_tables(IdfText& idf, std::vector<Refusal>& /*refused*/) {
  std::vector<IdfObject> tables;
  for (IdfObject* exchanger : idf.all("HeatExchanger:AirToAir:SensibleAndLatent")) heat_exchanger(*exchanger, tables);
  if (tables.empty()) return;
  tables.push_back({"Table:IndependentVariableList", {flow_ratios, flow_ratio}, 0, {"24.1"}});
  tables.push_back({"Table:IndependentVariable",
                    {flow_ratio, "Linear", "Linear", "0", "10", "", "Dimensionless", "", "", "", "0.75", "1"},
                    0,
                    {"24.1"}});
  std::ranges::move(tables, std::back_inserter(idf.objects));
}

}  // namespace airside::tools::upgrade
