#include "hal/points/bacnet_row.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

namespace airside::hal {
namespace {

constexpr int highest_instance = 4194302;  // 4194303 means "any"

struct ObjectType {
  std::string_view name;
  bool takes_setpoint;  ///< a number that may be commanded
  bool takes_beat;      ///< a state or number that may be commanded
};
constexpr std::array<ObjectType, 14> object_types = {{{"analog-input", false, false},
                                                      {"analog-output", true, true},
                                                      {"analog-value", true, true},
                                                      {"binary-input", false, false},
                                                      {"binary-output", false, true},
                                                      {"binary-value", false, true},
                                                      {"multi-state-input", false, false},
                                                      {"multi-state-output", false, true},
                                                      {"multi-state-value", false, true},
                                                      {"accumulator", false, false},
                                                      {"integer-value", true, true},
                                                      {"positive-integer-value", true, true},
                                                      {"large-analog-value", true, true},
                                                      {"loop", false, false}}};
constexpr std::string_view present_value = "present-value";
/// The second two are a loop's.
constexpr std::array<std::string_view, 4> properties = {present_value, "relinquish-default", "setpoint",
                                                        "controlled-variable-value"};

constexpr const char* syntax = "DEVICE:TYPE:INSTANCE, such as 1201:analog-input:3, or gateway";

bool is_written(std::string_view name) { return name == "setpoint" || name == "heartbeat"; }
bool is_held_by_gateway(std::string_view name) { return name == "heartbeat" || name == "map_fingerprint"; }

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(':', at), text.size());
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

bool is_instance(std::string_view text) {
  int value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && value >= 0 && value <= highest_instance &&
         text == std::to_string(value);
}

void check_written(const PointRow& row, const ObjectType& type, std::string_view property) {
  const bool beat = row["name"] == "heartbeat";
  if (property == present_value && (beat ? type.takes_beat : type.takes_setpoint)) return;
  std::vector<std::string_view> fitting;
  for (const ObjectType& t : object_types) {
    if (beat ? t.takes_beat : t.takes_setpoint) fitting.push_back(t.name);
  }
  row.complain(
      "object", cell_text(row["object"]),
      fmt::format("the present-value of one of {}, since {} is written", fmt::join(fitting, ", "), row["name"]),
      beat ? "name an object that the AHU watches, or write gateway" : "name the object that holds the setpoint");
}

std::string object_in_full(const PointRow& row) {
  const std::string& cell = row["object"];
  if (row["name"] == "map_fingerprint" && cell != held_by_gateway) {
    row.complain("object", cell_text(cell), "gateway, which shows the fingerprint of the map that it has read",
                 "write gateway");
  }
  if (cell == held_by_gateway) {
    if (is_held_by_gateway(row["name"])) return cell;
    row.complain("object", "\"gateway\" for " + row["name"], "an object of a device", std::string("write ") + syntax);
  }
  const std::vector<std::string_view> parts = split(cell);
  const auto refuse = [&](std::string found, std::string expected, std::string remedy) {
    row.complain("object", std::move(found), std::move(expected), std::move(remedy));
  };
  if (parts.size() < 3 || parts.size() > 4) {
    refuse(cell_text(cell), syntax, "`airside-bacnet --discover` lists the objects of a device in this form");
  }
  if (!is_instance(parts[0]) || !is_instance(parts[2])) {
    refuse(fmt::format("{} in {}", cell_text(is_instance(parts[0]) ? parts[2] : parts[0]), cell_text(cell)),
           fmt::format("an instance number from 0 to {}", highest_instance),
           "give device and object by their instance numbers");
  }
  const auto type = std::ranges::find(object_types, parts[1], &ObjectType::name);
  if (type == object_types.end()) {
    std::vector<std::string_view> names;
    for (const ObjectType& t : object_types) names.push_back(t.name);
    refuse(fmt::format("{} in {}", cell_text(parts[1]), cell_text(cell)),
           fmt::format("one of {}", fmt::join(names, ", ")), "use one of these types, in lower case");
  }
  const std::string_view property = parts.size() == 4 ? parts[3] : present_value;
  const bool of_loop = property == properties[2] || property == properties[3];
  if (std::ranges::find(properties, property) == properties.end() || (of_loop && type->name != "loop")) {
    refuse(fmt::format("{} in {}", cell_text(property), cell_text(cell)),
           fmt::format("one of {}; the last two of a loop", fmt::join(properties, ", ")),
           "leave the property out for present-value");
  }
  if (is_written(row["name"])) check_written(row, *type, property);
  return fmt::format("{}:{}:{}:{}", parts[0], parts[1], parts[2], property);
}

std::string& cell_of(PointRow& row, std::string_view column) {
  return row.cell[static_cast<std::size_t>(std::ranges::find(point_columns, column) - point_columns.begin())];
}

}  // namespace

std::string take_bacnet_row(PointRow& row, std::size_t index) {
  static constexpr std::array<const char*, 7> decided = {"fc",         "addr",     "type",    "byte_order",
                                                         "word_order", "sentinel", "fc_write"};
  if (row["name"] == "clock_s" || row["name"] == "clock_advance_s") {
    row.complain("name", cell_text(row["name"]) + " of BACnet", "no clock, which only simulated plants on Modbus have",
                 "remove the row, and set source = \"system\" in [clock] of the site file");
  }
  for (const char* column : decided) {
    if (row[column].empty()) continue;
    row.complain(column, cell_text(row[column]),
                 "an empty cell, since the place of a row of BACnet decides its registers",
                 "clear the cell, or leave the column out");
  }
  const std::string object = object_in_full(row);
  const bool written = is_written(row["name"]);
  if (!written && !row["write_policy"].empty()) {
    row.complain("write_policy", cell_text(row["write_policy"]),
                 "an empty cell, since only setpoint and heartbeat are written", "clear the cell");
  }
  cell_of(row, "fc") = written ? "3" : "4";
  cell_of(row, "addr") = std::to_string(2 * index);
  cell_of(row, "type") = row["name"] == "map_fingerprint" ? "uint32" : "float32";
  if (written) {
    cell_of(row, "fc_write") = "16";
    // A command that is not repeated would leave the value at the mercy of whoever else held the same one.
    if (row["write_policy"].empty()) cell_of(row, "write_policy") = "refresh";
  }
  return object;
}

std::string refuse_object(const PointRow& row) {
  if (!row["object"].empty()) {
    row.complain("object", cell_text(row["object"]), "an empty cell in a row of Modbus",
                 "write bacnet into the column protocol, or clear the cell");
  }
  return {};
}

void check_protocols(const PointMap& map, const std::vector<bool>& is_sound, std::vector<InputError>& complaints) {
  const auto text = [](Protocol p) { return p == Protocol::bacnet ? "bacnet" : "modbus"; };
  const std::vector<Point>& points = map.points();
  const auto first = std::ranges::find(is_sound, true);
  if (first == is_sound.end()) return;
  const Point& front = points[static_cast<std::size_t>(first - is_sound.begin())];
  bool is_mixed = false;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    if (!is_sound[i]) continue;
    if (p.protocol != front.protocol && !is_mixed) {
      is_mixed = true;  // said once: it is one decision, for all rows
      complaints.emplace_back(
          fmt::format("{}:{}, column protocol", map.file(), p.line),
          fmt::format("{}, while line {} has {}", text(p.protocol), front.line, text(front.protocol)),
          "one protocol for all rows, since a controller has one link: [modbus] of the site file",
          "read all of them by BACnet or all by Modbus; give stand-ins for what is left ([stand_in] of the "
          "site file)");
    }
    if (p.object.empty() || p.object == held_by_gateway) continue;
    for (std::size_t j = 0; j < i; ++j) {
      if (!is_sound[j] || p.object != points[j].object) continue;
      complaints.emplace_back(fmt::format("{}:{}, column object", map.file(), p.line),
                              fmt::format("\"{}\" again, first on line {}", p.object, points[j].line),
                              "each object once", "correct one of the two rows");
      break;
    }
  }
  if (front.protocol != Protocol::bacnet) return;
  for (const char* name : {"heartbeat", "map_fingerprint"}) {
    if (map.find(name) != nullptr) continue;
    const bool beat = std::string_view(name) == "heartbeat";
    complaints.emplace_back(
        map.file(), fmt::format("no point \"{}\" in a map of BACnet", name),
        beat ? "a row for it: without new values of it the gateway gives the setpoint back"
             : "a row for it: it shows that gateway and controller read the same map",
        beat ? "add a row with name heartbeat, object gateway (or an object that the AHU watches), min 0 and "
               "max 65535"
             : "add a row with name map_fingerprint, object gateway, min 0 and max 4294967295");
  }
}

}  // namespace airside::hal
