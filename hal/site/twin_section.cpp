#include "hal/site/twin_section.hpp"

#include <set>
#include <utility>

#include "airside/topology.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/toml_section.hpp"

namespace airside::hal {
namespace {

enum class Blanks : std::uint8_t { refused, mean_none };

/// A list with one name for each of `count` places, or an empty one where it is not given.
std::vector<std::string> names(TomlSection& table, const char* key, int count, const char* what, Blanks blanks) {
  std::vector<std::string> list = table.text_list(key);
  const std::string expected = std::to_string(count) + " names, one for each " + what;
  if (table.has(key) && static_cast<int>(list.size()) != count) {
    throw InputError(table.place(key), "a list of " + std::to_string(list.size()), expected,
                     "give as many as `topology` in [site] says, or correct that");
  }
  std::set<std::string> seen;
  for (const std::string& name : list) {
    if (name.empty() && blanks == Blanks::mean_none) continue;
    if (!name.empty() && seen.insert(name).second) continue;
    throw InputError(table.place(key), name.empty() ? "an empty text" : "\"" + name + "\" twice",
                     expected + ", each once", "correct the list");
  }
  return list;
}

void read_own(TomlSection& table, const Shape& shape, TwinNames& out) {
  out.supply_setpoint_schedule = table.required_text("supply_setpoint_schedule", "airside supply setpoint");
  out.supply_air_node = table.required_text("supply_air_node", "VAV_1 Supply Equipment Outlet Node");
  out.mau_outlet_node = table.text("mau_outlet_node", "");
  out.zones = names(table, "zones", shape.vavs, "room_temp point", Blanks::refused);
  if (out.zones.empty()) {
    throw InputError(table.place("zones"), "nothing", "the model's zones, one for each room_temp point",
                     "add zones = [\"Core_ZN\", ...] to [twin.names]");
  }
  out.terminals =
      names(table, "terminals", shape.vavs, "room_temp point, \"\" where the kind shows no damper", Blanks::mean_none);
  out.fcu_zones = names(table, "fcu_zones", shape.fcus, "fcu_temp point", Blanks::refused);
  out.supply_fan = table.text("supply_fan", "");
  out.powers = names(table, "powers", shape.powers, "power point, \"\" where no meter shows it", Blanks::mean_none);
  out.occupancy = table.text_list("occupancy");
}

void read_external(TomlSection& table, const Shape& shape, TwinNames& out) {
  if (table.has("zones")) {
    throw InputError(table.place("zones"), "`zones` with control = \"external\", which is the default",
                     "zones for control = \"own\", interior_zones and perimeter_zones for \"external\"",
                     "add control = \"own\" to [twin] where the model's own thermostats run");
  }
  out.interior_zones = names(table, "interior_zones", shape.vavs, "VAV box", Blanks::refused);
  out.perimeter_zones = names(table, "perimeter_zones", shape.fcus, "fan coil", Blanks::refused);
  out.powers = names(table, "powers", shape.powers, "power point", Blanks::refused);
  struct {
    const char* key;
    std::string& text;
  } const texts[] = {{"supply_setpoint_schedule", out.supply_setpoint_schedule},
                     {"vav_on_schedule", out.vav_on_schedule},
                     {"vav_damper_schedule", out.vav_damper_schedule},
                     {"fcu_on_schedule", out.fcu_on_schedule},
                     {"interior_occupancy_schedule", out.interior_occupancy_schedule},
                     {"perimeter_occupancy_schedule", out.perimeter_occupancy_schedule},
                     {"supply_air_node", out.supply_air_node},
                     {"mau_outlet_node", out.mau_outlet_node}};
  for (const auto& one : texts) one.text = table.text(one.key, "");
}

}  // namespace

TwinSection read_twin_section(TomlSection root, const std::string& topology) {
  TwinSection twin;
  twin.model = root.required_text("model", "twin.epJSON");
  twin.patches = root.text_list("patches");
  twin.weather = root.text("weather", "");
  twin.control = static_cast<TwinControl>(root.choice("control", {"external", "own"}, 0));
  twin.step_min = static_cast<int>(root.whole("step_min", 0, 3, 6));
  if (twin.step_min != 0 && twin.step_min != 3 && twin.step_min != 6) {
    throw InputError(root.place("step_min"), root.found("step_min"), "3 or 6, in minutes",
                     "6 is the faster one; both divide the controller's rows");
  }
  const bool own = twin.control == TwinControl::own;
  if (own) twin.supply_lag_s = root.number("supply_lag_s", 0, 0, 7200, "s");
  TomlSection table = root.section("names");
  for (const char* key : {"control", "names"}) {
    if (twin.model != "rc" || !root.has(key)) continue;
    throw InputError(root.place(key), "`" + std::string(key) + "` for the model \"rc\"", "an epJSON model",
                     "leave it out, or name the model");
  }
  if (own && !table.present()) {
    throw InputError(root.place("control"), "control = \"own\" and no [twin.names]",
                     "the names by which the model offers setpoint, node and zones",
                     "`airside adopt` writes them; docs/formats.md lists the keys");
  }
  if (table.present()) {
    const Shape shape = parse_shape(topology.c_str());
    TwinNames read;
    if (own) {
      read_own(table, shape, read);
    } else {
      read_external(table, shape, read);
    }
    table.refuse_unknown_keys();
    twin.names = std::move(read);
  }
  root.refuse_unknown_keys();
  return twin;
}

}  // namespace airside::hal
