#include "tools/study/method/rows.hpp"

#include <algorithm>
#include <stdexcept>

namespace airside::tools {

namespace {

using Table = MethodTable;
using Start = MethodStart;
using Work = MethodWork;
using Overrides = std::array<MethodOverride, 4>;
using Published = std::array<PublishedFigure, 6>;

constexpr Overrides score_of(double alpha, double beta, double gamma) {
  return {{{"score_alpha", alpha}, {"score_beta", beta}, {"gamma", gamma}}};
}

constexpr Published figures(double me, double dae, double darv) {
  return {{{"me_degc", me}, {"dae_degc", dae}, {"darv_degc", darv}}};
}

constexpr MethodRow scored(const char* name, double alpha, double beta, double gamma, const Published& published) {
  return {.name = name, .table = Table::score, .overrides = score_of(alpha, beta, gamma), .published = published};
}

constexpr MethodRow ablated(const char* name, const Overrides& overrides, const Published& published) {
  return {.name = name, .table = Table::ablation, .overrides = overrides, .published = published};
}

constexpr MethodRow pretrained(const char* name, MethodStart start) {
  return {.name = name, .table = Table::pretraining, .work = Work::pretrain, .start = start};
}

constexpr MethodRow cycled(const char* name, bool is_product, double minutes, const Published& published = {}) {
  return {.name = name,
          .table = Table::cycle,
          .is_product = is_product,
          .overrides = {{{"cycle_min", minutes}}},
          .published = published};
}

constexpr MethodRow deployed(const char* name, MethodTable table, MethodStart start, int days) {
  return {.name = name, .table = table, .start = start, .data_days = days};
}

// Without the long-term branch the setpoint is the one whose short-term forecast is nearest to the target.
constexpr Overrides without_tdb = {{{"long_term", 0}, {"weight_tdb", 0}, {"weight_rc", 0}, {"score_beta", 0}}};

constexpr auto all_rows = std::to_array<MethodRow>({
    {.name = "paper", .table = Table::control, .published = figures(0.2322, 0.0613, 0.3562)},
    {.name = "expert", .table = Table::control, .baseline = "expert"},
    {.name = "pid", .table = Table::control, .baseline = "pid-spec"},
    ablated("without-physics", {{{"weight_gc", 0}, {"weight_rc", 0}}}, figures(0.2656, 0.0961, 0.3463)),
    ablated("without-tdb", without_tdb, figures(0.2448, 0.0558, 0.4110)),
    ablated("without-online", {{{"updates_per_cycle", 0}}}, figures(0.6778, 0.2978, 0.9602)),
    ablated("without-confidence", {{{"confidence_initial", 1}, {"confidence_smoothing", 0}}},
            figures(0.3691, 0.0667, 0.3516)),
    pretrained("source-dynamic", Start::dynamic_twin),
    pretrained("source-static", Start::static_twin),
    pretrained("source-operated", Start::operated_room),
    deployed("dynamic-5", Table::deployment, Start::dynamic_twin, 5),
    deployed("static-5", Table::deployment, Start::static_twin, 5),
    deployed("scratch-5", Table::deployment, Start::scratch, 5),
    deployed("room-to-room", Table::neighbours, Start::operated_room, 5),
    deployed("room-alone", Table::neighbours, Start::scratch, 5),
    scored("a0.50-b0.90-g0.25", 0.5, 0.9, 0.25, figures(0.9175, 0.3433, 0.3151)),
    scored("a0.75-b0.90-g0.25", 0.75, 0.9, 0.25, figures(0.9175, 0.2966, 0.3058)),
    scored("a1.00-b0.90-g0.25", 1.0, 0.9, 0.25, figures(0.2522, 0.0566, 0.3851)),
    scored("a1.10-b0.90-g0.25", 1.1, 0.9, 0.25, figures(0.2522, 0.0558, 0.3954)),
    scored("a1.50-b0.90-g0.25", 1.5, 0.9, 0.25, figures(0.2521, 0.0531, 0.3939)),
    scored("a1.00-b0.50-g0.25", 1.0, 0.5, 0.25, figures(0.2556, 0.0544, 0.4058)),
    scored("a1.00-b0.75-g0.25", 1.0, 0.75, 0.25, figures(0.2526, 0.0573, 0.3880)),
    scored("a1.00-b1.00-g0.25", 1.0, 1.0, 0.25, figures(1.2887, 0.1404, 0.3285)),
    scored("a1.00-b1.10-g0.25", 1.0, 1.1, 0.25, figures(0.9175, 0.2770, 0.3193)),
    scored("a1.00-b0.90-g0.10", 1.0, 0.9, 0.10, figures(0.2360, 0.0546, 0.4041)),
    scored("a1.00-b0.90-g0.75", 1.0, 0.9, 0.75, figures(0.2343, 0.0774, 0.2650)),
    {.name = "physics", .table = Table::physics, .work = Work::physics},
    {.name = "offline", .table = Table::offline, .work = Work::offline},
    deployed("dynamic-1", Table::data, Start::dynamic_twin, 1),
    deployed("scratch-1", Table::data, Start::scratch, 1),
    deployed("dynamic-3", Table::data, Start::dynamic_twin, 3),
    deployed("scratch-3", Table::data, Start::scratch, 3),
    deployed("dynamic-10", Table::data, Start::dynamic_twin, 10),
    deployed("scratch-10", Table::data, Start::scratch, 10),
    deployed("dynamic-20", Table::data, Start::dynamic_twin, 20),
    deployed("scratch-20", Table::data, Start::scratch, 20),
    cycled("paper-6", false, 6),
    cycled("paper-12", false, 12),
    cycled("paper-24", false, 24, {{{"dae_degc", 0.10}, {"darv_degc", 0.28}}}),
    cycled("product-6", true, 6),
    cycled("product-12", true, 12),
    cycled("product-18", true, 18),
    cycled("product-24", true, 24),
});

void set(ControllerSettings& s, const MethodOverride& o) {
  const auto* const entry = std::ranges::find(setting_table, std::string_view(o.name), &SettingEntry::name);
  if (entry == setting_table.end()) throw std::out_of_range(o.name);
  if (entry->real != nullptr)
    s.*(entry->real) = o.value;
  else
    s.*(entry->whole) = static_cast<int>(o.value);
}

}  // namespace

const char* text_of(MethodTable table) {
  constexpr std::array<const char*, method_tables> names = {
      "control", "score", "ablation", "physics", "pretraining", "deployment", "data", "neighbours", "offline", "cycle"};
  return names.at(static_cast<std::size_t>(table));
}

std::span<const MethodRow> method_rows() { return all_rows; }

const MethodRow& method_row(std::string_view name) {
  const auto* const row =
      std::ranges::find(all_rows, name, [](const MethodRow& r) { return std::string_view(r.name); });
  if (row == all_rows.end()) throw std::out_of_range(std::string(name));
  return *row;
}

std::vector<std::string> method_rooms(const MethodRow& row) {
  switch (row.table) {
    case Table::deployment:
    case Table::data:
    case Table::offline: return {"701-real", "702-real"};
    case Table::neighbours: return {"401-real", "402-real"};
    case Table::pretraining:
      return row.start == Start::operated_room ? std::vector<std::string>{"301-real"}
                                               : std::vector<std::string>{"701", "702"};
    default: return {"301-real"};
  }
}

std::string source_room(MethodStart start, const std::string& room) {
  if (start == Start::scratch) return "";
  if (start == Start::operated_room) return "301-real";
  return room.substr(0, room.find('-'));
}

const char* source_row(MethodStart start) {
  switch (start) {
    case Start::dynamic_twin: return "source-dynamic";
    case Start::static_twin: return "source-static";
    case Start::operated_room: return "source-operated";
    case Start::scratch: break;
  }
  return "";
}

ControllerSettings method_settings(ControllerSettings preset, const MethodRow& row) {
  // Bounds of setting_table that no run reaches.
  for (const MethodOverride& none : {MethodOverride{"worse_k", 10},
                                     {"authority_k", 50},
                                     {"supply_ignored_k", 50},
                                     {"drift_k", 50},
                                     {"excitation_k", 0}}) {
    set(preset, none);
  }
  for (const MethodOverride& o : row.overrides) {
    if (o.name != nullptr) set(preset, o);
  }
  return preset;
}

}  // namespace airside::tools
