// The site file and the point map that follow from answers.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <set>
#include <vector>

#include "hal/points/point_map.hpp"
#include "hal/points/point_row.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "tools/cli/site/ask/init_answers.hpp"
#include "tools/cli/site/ask/questions.hpp"

namespace airside::tools {

namespace {

constexpr std::size_t scope_bytes = 32;

constexpr int width_of(std::string_view type) { return type.ends_with("32") ? 2 : 1; }

/// `room_temp_3` is a `room_temp`.
std::string stem_of(const std::string& name) {
  const std::size_t end = name.find_last_not_of("0123456789");
  return end + 1 < name.size() && name[end] == '_' ? name.substr(0, end) : name;
}

int place_of(const std::string& name) {
  const std::string stem = stem_of(name);
  return stem == name ? 1 : std::stoi(name.substr(stem.size() + 1));
}

/// A line of the point map that becomes one of the site's.
struct InitRow {
  std::vector<std::string> cells;
  bool is_said = false;

  /// By the name of its column.
  std::string& operator[](std::string_view column) {
    const auto at = std::ranges::find(hal::point_columns, column);
    return cells.at(static_cast<std::size_t>(at - std::begin(hal::point_columns)));
  }
  int number(std::string_view column) { return std::stoi((*this)[column]); }
};

void place_signal(InitRow& row, const SignalAnswer& a) {
  std::string& type = row["type"];
  const bool is_written = !row["write_policy"].empty();
  const bool is_bit = a.fc && *a.fc <= 2;
  const std::string said = a.type ? *a.type : !is_bit ? type : *a.fc == 1 ? "coil" : "discrete";
  if (said != type) {
    type = said;
    row["sentinel"] = type == "int16" ? "0x8000" : type == "uint16" ? "0xFFFF" : "";
    if (is_written) row["fc_write"] = type == "coil" ? "5" : width_of(type) == 2 ? "16" : "6";
  }
  if (a.fc) row["fc"] = std::to_string(*a.fc);
  if (a.scale) row["scale"] = fmt::format("{}", *a.scale);
  if (a.offset) row["offset"] = fmt::format("{}", *a.offset);
  if (a.word_order && width_of(type) == 2) row["word_order"] = *a.word_order;
  if (!a.addr) return;
  const int apart = a.apart.value_or(0) > 0 ? *a.apart : width_of(type);
  row["addr"] = std::to_string(*a.addr + apart * (place_of(row["name"]) - 1));
  row.is_said = true;
}

/// The limits of the setpoint's row hold each setpoint that the site writes.
void widen_setpoint(InitRow& row, const InitAnswers& a) {
  const auto [least, most] = std::minmax({a.min_degc, a.max_degc, a.schedule_work_degc, a.schedule_off_degc});
  row["min"] = fmt::format("{}", std::min(std::stod(row["min"]), least));
  row["max"] = fmt::format("{}", std::max(std::stod(row["max"]), most));
}

/// Rows of the signals that the site has, without those of a simulated AHU.
std::vector<InitRow> rows_of_answers(const InitAnswers& a) {
  const std::string all =
      hal::default_point_map(a.vavs, a.fcus, a.powers, a.stand_ins(), a.objective == Objective::band);
  std::vector<InitRow> rows;
  for (const std::string& line : parts_of(all, '\n')) {
    if (line.empty() || line.starts_with('#') || line.starts_with("name,")) continue;
    InitRow row{parts_of(line, ',')};
    const std::string& name = row["name"];
    if (name == "clock_s" || name == "clock_advance_s" || name == "map_fingerprint") continue;
    if (a.is_absent(stem_of(name))) continue;
    if (name == "setpoint") widen_setpoint(row, a);
    if (const auto found = a.signals.find(stem_of(name)); found != a.signals.end()) place_signal(row, found->second);
    rows.push_back(std::move(row));
  }
  return rows;
}

/// TakenRegisters that are taken, by function.
class TakenRegisters {
 public:
  bool are_free(int fc, int addr, int width) const {
    return !taken_.contains({fc, addr}) && !taken_.contains({fc, addr + width - 1});
  }
  void take(InitRow& row) {
    const int addr = row.number("addr");
    for (int i = 0; i < width_of(row["type"]); ++i) taken_.emplace(row.number("fc"), addr + i);
  }

 private:
  std::set<std::pair<int, int>> taken_;
};

/// A made-up register gives way to one that somebody has said.
void move_made_up(std::vector<InitRow>& rows) {
  TakenRegisters taken;
  for (InitRow& row : rows) {
    if (row.is_said) taken.take(row);
  }
  std::vector<InitRow*> displaced;
  for (InitRow& row : rows) {
    if (row.is_said) continue;
    if (taken.are_free(row.number("fc"), row.number("addr"), width_of(row["type"]))) {
      taken.take(row);
    } else {
      displaced.push_back(&row);
    }
  }
  for (InitRow* row : displaced) {
    const int fc = row->number("fc"), width = width_of((*row)["type"]);
    int addr = 0;
    while (addr < 65536 - width && !taken.are_free(fc, addr, width)) ++addr;
    (*row)["addr"] = std::to_string(addr);
    taken.take(*row);
  }
}

std::string text_of_modbus_rows(std::vector<InitRow>& rows) {
  std::string out = hal::modbus_header() + "\n";
  for (const InitRow& row : rows) out += fmt::format("{}\n", fmt::join(row.cells, ","));
  return out;
}

/// Object of place `n`: device and instance go on from those of the first.
std::string object_of(const SignalAnswer& a, int place) {
  std::vector<std::string> parts = parts_of(*a.object, ':');
  const auto add = [&](std::size_t part, int step) {
    int number = 0;
    const std::string& text = parts[part];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc{} && end == text.data() + text.size()) {
      parts[part] = std::to_string(number + step * (place - 1));
    }
  };
  if (parts.size() >= 3) {  // else the map's own complaint says what an object is
    add(0, a.devices_apart);
    add(2, a.apart.value_or(1));
  }
  return fmt::format("{}", fmt::join(parts, ":"));
}

std::string text_of_bacnet_rows(const InitAnswers& a, std::vector<InitRow>& rows) {
  std::string out = "name,unit,protocol,object,min,max,scale,offset,max_rate,stale_s\n";
  const auto add = [&](InitRow& row, const std::string& object, const SignalAnswer& said) {
    std::string &min = row["min"], &max = row["max"];
    if (row["name"] == "heartbeat" && object.find(":binary-") != std::string::npos) max = "1";
    if (row["name"] == "heartbeat" && object.find(":multi-state-") != std::string::npos) min = "1", max = "2";
    out += fmt::format("{},{},bacnet,{},{},{},{},{},{},{}\n", row["name"], row["unit"], object, min, max,
                       said.scale.value_or(1), said.offset.value_or(0), row["max_rate"], row["stale_s"]);
  };
  for (InitRow& row : rows) {
    const auto found = a.signals.find(stem_of(row["name"]));
    if (found != a.signals.end() && found->second.object) {
      add(row, object_of(found->second, place_of(row["name"])), found->second);
    } else if (row["name"] == "heartbeat") {
      add(row, "gateway", {});
    }
  }
  return out + "map_fingerprint,,bacnet,gateway,0,4294967295,1,0,,\n";
}

/// Replaces the value of `key` in its section of a site file, comment and all else kept.
void set(std::string& text, const std::string& section, const std::string& key, const std::string& value) {
  const std::size_t from = text.find("\n[" + section + "]"), at = text.find("\n" + key + " = ", from) + 1;
  const std::size_t begin = at + key.size() + 3, line_end = text.find('\n', begin);
  const std::size_t comment = text.find(" #", begin);
  std::size_t end = std::min(line_end, comment);
  while (end > begin && text[end - 1] == ' ') --end;
  text.replace(begin, end - begin, value);
}

std::string in_quotes(const std::string& text) { return '"' + text + '"'; }

void set_bus(std::string& text, const InitAnswers& a) {
  const hal::ModbusSection& m = a.modbus;
  const bool tcp = m.transport == hal::ModbusTransport::tcp;
  set(text, "modbus", "transport", tcp ? "\"tcp\"" : "\"rtu\"");
  if (!m.host.empty()) set(text, "modbus", "host", in_quotes(m.host));
  set(text, "modbus", "port", std::to_string(m.port));
  if (!m.device.empty()) set(text, "modbus", "device", in_quotes(m.device));
  set(text, "modbus", "baud", std::to_string(m.baud));
  set(text, "modbus", "parity", in_quotes(std::string(1, m.parity)));
  set(text, "modbus", "unit_id", std::to_string(m.unit_id));
  if (!a.bacnet) return;
  const hal::BacnetSection& b = *a.bacnet;
  text += fmt::format(
      "\n[bacnet]                 # how airside-bacnet reaches the devices\n"
      "address = \"{}\"  # of this machine, in their network\nport = {}             # UDP\n"
      "priority = {}            # at which the setpoint is commanded, 8 to 16\n",
      b.address, b.port, b.priority);
  if (!b.devices.empty()) {
    text += fmt::format("devices = [\"{}\"]  # not found by Who-Is\n", fmt::join(b.devices, "\", \""));
  }
}

}  // namespace

std::string site_text_of(const InitAnswers& a) {
  if (a.name.empty() || a.name.find_first_of("\"\\\n\r") != std::string::npos) {
    throw hal::InputError("name", "'" + a.name + "'", "a name without quotes, backslashes and line ends",
                          "use letters, digits, spaces and - . , _ / ( )");
  }
  std::vector<std::string> words = {a.modbus.host, a.modbus.device};
  if (a.bacnet) {
    words.push_back(a.bacnet->address);
    words.insert(words.end(), a.bacnet->devices.begin(), a.bacnet->devices.end());
  }
  for (const std::string& word : words) {
    if (word.find_first_of("\"\\\n\r") == std::string::npos) continue;
    throw hal::InputError(a.bacnet ? "bus: address, devices" : "bus: host, device", "'" + word + "'",
                          "no quotes, backslashes and line ends", "correct the answer");
  }
  std::string text = hal::example_site_text(a.topology(), a.objective);
  set(text, "site", "name", in_quotes(a.name));
  set(text, "site", "scope", in_quotes(a.name));
  if (a.name.size() > scope_bytes) {  // too long for one: without the key the site makes one of it
    const std::size_t at = text.find("\nscope = ");
    text.erase(at, text.find('\n', at + 1) - at);
  }
  set(text, "target", "room_temp_degc", fmt::format("{:g}", a.target_degc));
  set(text, "target", "work_start", in_quotes(hal::clock_text(a.work_start_s)));
  set(text, "target", "work_end", in_quotes(hal::clock_text(a.work_end_s)));
  set(text, "setpoint", "min_degc", fmt::format("{:.6g}", a.min_degc));
  set(text, "setpoint", "max_degc", fmt::format("{:.6g}", a.max_degc));
  set(text, "expert", "work_degc", fmt::format("{:g}", a.schedule_work_degc));
  set(text, "expert", "off_degc", fmt::format("{:g}", a.schedule_off_degc));
  set_bus(text, a);
  if (const hal::StandIns absent = a.stand_ins(); !absent.empty()) {
    text += "\n[stand_in]               # numbers in the place of sensors that the site lacks\n";
    for (const auto& [name, value] : absent.by_name()) text += fmt::format("{} = {:g}\n", name, value);
  }
  return text;
}

std::string points_text_of(const InitAnswers& a) {
  std::vector<InitRow> rows = rows_of_answers(a);
  if (a.bacnet) {
    return "# A row without an object is none; scale and offset turn the object's number into the unit.\n" +
           text_of_bacnet_rows(a, rows);
  }
  move_made_up(rows);
  const std::string all = hal::default_point_map(1, 0, 0);
  std::string comments;
  for (const std::string& line : parts_of(all, '\n')) {
    if (line.starts_with('#') && !line.starts_with("# clock_s") && !line.starts_with("# map_fingerprint")) {
      comments += line + '\n';
    }
  }
  return comments + text_of_modbus_rows(rows);
}

std::vector<std::string> unsaid_signals(const InitAnswers& a) {
  InitAnswers modbus = a;
  modbus.bacnet.reset();
  std::set<std::string> stems;
  for (InitRow& row : rows_of_answers(modbus)) stems.insert(stem_of(row["name"]));
  std::vector<std::string> names;
  for (const std::string& name : signal_names()) {
    const auto said = a.signals.find(name);
    if (stems.contains(name) && (said == a.signals.end() || !said->second.is_said())) names.push_back(name);
  }
  return names;
}

std::string complaint_of_site(const InitAnswers& a) {
  try {
    InitAnswers without_signals = a;
    without_signals.signals.clear();
    const hal::SiteFile site = hal::parse_site_text(site_text_of(without_signals), "site.toml", hal::site_rules());
    static_cast<void>(hal::controller_settings(site));
    return {};
  } catch (const hal::InputError& e) {
    return fmt::format("found {}; expected {}; {}", e.found(), e.expected(), e.remedy());
  }
}

SignalAnswer whole_answer(const InitAnswers& a, const std::string& signal) {
  const auto said = a.signals.find(signal);
  SignalAnswer whole = said == a.signals.end() ? SignalAnswer{} : said->second;
  for (InitRow& row : rows_of_answers(a)) {
    if (stem_of(row["name"]) != signal || place_of(row["name"]) != 1) continue;
    whole.fc = row.number("fc");
    whole.addr = row.number("addr");
    whole.type = row["type"];
    whole.scale = std::stod(row["scale"]);
    whole.offset = std::stod(row["offset"]);
    whole.word_order = row["word_order"];
  }
  return whole;
}

namespace {

/// The point of a line of a point map, the header's being the first.
std::string name_on_line(const std::string& text, int number) {
  const std::vector<std::string> lines = parts_of(text, '\n');
  const auto at = static_cast<std::size_t>(number - 1);
  return number > 1 && at < lines.size() ? parts_of(lines[at], ',')[0] : "";
}

/// The whole number that begins there; 0 where none does.
int number_at(const std::string& text, std::size_t at) {
  int number = 0;
  std::from_chars(text.data() + std::min(at, text.size()), text.data() + text.size(), number);
  return number;
}

}  // namespace

std::string complaint_of_rows(const InitAnswers& a, const std::string& latest) {
  std::vector<InitRow> rows = rows_of_answers(a);
  if (!a.bacnet) std::erase_if(rows, [](const InitRow& row) { return !row.is_said; });
  // Of two rows that overlap the map complains of the second.
  std::stable_partition(rows.begin(), rows.end(), [&](InitRow& row) { return stem_of(row["name"]) != latest; });
  if (rows.empty()) return {};
  const std::string text = a.bacnet ? text_of_bacnet_rows(a, rows) : text_of_modbus_rows(rows);
  std::vector<hal::InputError> complaints;
  try {
    const hal::PointMap map = hal::PointMap::parse(text, "points.csv", complaints);
    if (!a.bacnet && complaints.empty()) {
      hal::SiteFile site = hal::parse_site_text(site_text_of(a), "site.toml", hal::site_rules());
      site.objective = Objective::mean;  // of the other, signals may still be to come
      hal::refuse_contradiction(site, map);
    }
  } catch (const hal::InputError& e) {
    complaints.push_back(e);
  }
  for (const hal::InputError& e : complaints) {
    const std::size_t comma = e.place().find(", "), line = e.found().find(" (line ");
    if (!e.place().starts_with("points.csv:")) continue;  // of what is still to come
    const std::string name = name_on_line(text, number_at(e.place(), std::strlen("points.csv:")));
    const std::string column = comma == std::string::npos ? "" : e.place().substr(comma + 2);
    std::string found = e.found().substr(0, line);
    constexpr std::string_view before = "first on line ";
    if (const std::size_t at = found.find(before); at != std::string::npos) {
      found = found.substr(0, at) + "first of " + name_on_line(text, number_at(found, at + before.size()));
    }
    return fmt::format("{}{}{}{}found {}; expected {}; {}", name, name.empty() || column.empty() ? "" : ", ", column,
                       name.empty() && column.empty() ? "" : ": ", found, e.expected(), e.remedy());
  }
  return {};
}

}  // namespace airside::tools
