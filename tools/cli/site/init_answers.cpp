#include "tools/cli/site/init_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "airside/topology.hpp"
#include "hal/points/point_map.hpp"
#include "hal/points/point_row.hpp"
#include "hal/site/site_keys.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "hal/text/toml_section.hpp"
#include "hal/text/unknown_key.hpp"

namespace airside::tools {

namespace {

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

/// Signals whose absence leaves a number in their place; the others are optional points.
std::optional<SignalKind> stand_in_kind(const std::string& name) {
  for (const SignalKind kind : hal::StandIns::kinds()) {
    if (name == airside::text_of(kind).name) return kind;
  }
  return {};
}

SignalAnswer read_signal(hal::TomlSection s) {
  SignalAnswer a;
  a.is_absent = s.flag("absent", false);
  // Each key is asked for, there or not: what nobody asks for is unknown, and complaints list what was asked for.
  const int addr = static_cast<int>(s.whole("addr", 0, 0, 65535)), fc = static_cast<int>(s.whole("fc", 4, 1, 4));
  const std::string& type = point_types()[s.choice("type", point_types(), 0)];
  const double scale = s.number("scale", 1, -1e6, 1e6, "");
  a.apart = static_cast<int>(s.whole("apart", 0, 0, 1000));
  if (s.has("addr")) a.addr = addr;
  if (s.has("fc")) a.fc = fc;
  if (s.has("type")) a.type = type;
  if (s.has("scale")) a.scale = scale;
  s.refuse_unknown_keys();
  if (a.is_absent && (a.addr || a.fc || a.type || a.scale)) {
    throw hal::InputError(s.place("absent"), "true, beside where the signal is", "one of the two",
                          "leave out the one that is wrong");
  }
  return a;
}

void read_bus(hal::TomlSection s, hal::ModbusSection& bus) {
  bus.transport = static_cast<hal::ModbusTransport>(s.choice("transport", {"tcp", "rtu"}, 0));
  bus.host = s.text("host", bus.host);
  bus.port = static_cast<int>(s.whole("port", bus.port, 1, 65535));
  bus.device = s.text("device", bus.device);
  bus.baud = static_cast<int>(s.whole("baud", bus.baud, 300, 921600));
  bus.parity = "NEO"[s.choice("parity", {"N", "E", "O"}, 1)];
  bus.unit_id = static_cast<int>(s.whole("unit_id", bus.unit_id, 0, 247));
  s.refuse_unknown_keys();
}

/// One field of a line of the point map, by the name of its column.
std::string& field(std::vector<std::string>& fields, std::string_view column) {
  const auto at = std::ranges::find(hal::point_columns, column);
  return fields.at(static_cast<std::size_t>(at - std::begin(hal::point_columns)));
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

void place(std::vector<std::string>& fields, const SignalAnswer& a) {
  std::string& type = field(fields, "type");
  const bool is_written = !field(fields, "write_policy").empty();
  if (a.type && *a.type != type) {
    type = *a.type;
    field(fields, "sentinel") = type == "int16" ? "0x8000" : type == "uint16" ? "0xFFFF" : "";
    if (is_written) field(fields, "fc_write") = type == "coil" ? "5" : width_of(type) == 2 ? "16" : "6";
  }
  if (a.fc) field(fields, "fc") = std::to_string(*a.fc);
  if (a.scale) field(fields, "scale") = fmt::format("{:g}", *a.scale);
  if (a.addr) {
    const int apart = a.apart > 0 ? a.apart : width_of(type);
    field(fields, "addr") = std::to_string(*a.addr + apart * (place_of(field(fields, "name")) - 1));
  }
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

}  // namespace

std::string InitAnswers::topology() const { return fmt::format("{}vav-{}fcu-{}power", vavs, fcus, powers); }

hal::StandIns InitAnswers::stand_ins() const {
  hal::StandIns out;
  for (const auto& [stem, signal] : signals) {
    const auto kind = stand_in_kind(stem);
    if (signal.is_absent && kind) out.set(stem, hal::StandIns::plausible(*kind).usual);
  }
  return out;
}

const std::vector<std::string>& point_types() {
  static const std::vector<std::string> types = {"int16", "uint16", "int32", "uint32", "float32", "coil", "discrete"};
  return types;
}

const std::vector<std::string>& signal_names() {
  static const std::vector<std::string> names = {
      "room_temp",   "setpoint",     "heartbeat", "vav_on", "fcu_temp", "fcu_on",        "power",
      "supply_temp", "outdoor_temp", "mau_temp",  "rain",   "damper",   "zone_setpoint", "zone_heating_setpoint",
      "occupied",    "supply_flow",  "ahu_on"};
  return names;
}

namespace {

/// Says where a key belongs, and takes a site file for what it is.
[[noreturn]] void explain(const hal::UnknownKey& unknown) {
  const std::array<std::string_view, 5> of_site = {"name", "vavs", "fcus", "powers", "objective"};
  const bool misplaced = unknown.section().empty() && std::ranges::find(of_site, unknown.key()) != of_site.end();
  const bool site_file = !misplaced && !hal::sections_of_site_key(unknown.key()).empty();
  if (!misplaced && !site_file) throw unknown;
  throw hal::InputError(unknown.place(), unknown.found(), unknown.expected(),
                        misplaced ? "move it below [site]"
                                  : "give answers, such as `airside init --ask` leaves; this looks like a site file");
}

InitAnswers read_table(const toml::table& table, const std::string& path) {
  InitAnswers a;
  hal::TomlSection root(&table, "", path);
  hal::TomlSection site = root.section("site"), room = root.section("room");
  a.name = site.text("name", a.name);
  a.vavs = static_cast<int>(site.whole("vavs", a.vavs, 1, 32));
  a.fcus = static_cast<int>(site.whole("fcus", a.fcus, 0, 32));
  a.powers = static_cast<int>(site.whole("powers", a.powers, 0, 8));
  a.objective = site.choice("objective", {"mean", "band"}, 0) == 0 ? Objective::mean : Objective::band;
  site.refuse_unknown_keys();
  const bool band = a.objective == Objective::band;
  a.target_degc = room.number("target_degc", a.target_degc, 10, 35, "degC");
  a.work_start_s = room.time_of_day("work_start", a.work_start_s);
  a.work_end_s = room.time_of_day("work_end", a.work_end_s);
  a.min_degc = room.number("setpoint_min_degc", band ? 12 : a.min_degc, 5, 40, "degC");
  a.max_degc = room.number("setpoint_max_degc", band ? 18 : a.max_degc, 5, 40, "degC");
  a.schedule_work_degc = room.number("schedule_work_degc", band ? 14 : a.schedule_work_degc, 5, 40, "degC");
  a.schedule_off_degc = room.number("schedule_off_degc", band ? 14 : a.schedule_off_degc, 5, 40, "degC");
  room.refuse_unknown_keys();
  read_bus(root.section("bus"), a.modbus);
  hal::TomlSection signals = root.section("signals");
  for (const std::string& name : signal_names()) {
    const hal::TomlSection one = signals.section(name);
    if (signals.has(name)) a.signals[name] = read_signal(one);
  }
  signals.refuse_unknown_keys();
  root.refuse_unknown_keys();
  for (const char* needed : {"room_temp", "setpoint"}) {
    if (a.signals.contains(needed) && a.signals[needed].is_absent) {
      throw hal::InputError(signals.place(needed), "absent = true", "a signal that no site can do without",
                            "say where it is: addr, fc, type, scale");
    }
  }
  return a;
}

}  // namespace

InitAnswers read_answers(const std::string& path) {
  const std::string text = hal::read_text_file(path, "answers in TOML");
  const toml::table table = hal::parse_toml(text, path);
  try {
    return read_table(table, path);
  } catch (const hal::UnknownKey& unknown) {
    explain(unknown);
  }
}

std::string text_of(const InitAnswers& a) {
  const hal::ModbusSection& m = a.modbus;
  std::string text = fmt::format(
      "# Answers to `airside init`; `airside init FOLDER --answers` of this file makes the same site.\n[site]\n"
      "name = \"{}\"\nvavs = {}\nfcus = {}\npowers = {}\nobjective = \"{}\"\n\n[room]\ntarget_degc = {:g}\n"
      "work_start = \"{}\"\nwork_end = \"{}\"\nsetpoint_min_degc = {:g}\nsetpoint_max_degc = {:g}\n"
      "schedule_work_degc = {:g}\nschedule_off_degc = {:g}\n\n[bus]\n",
      a.name, a.vavs, a.fcus, a.powers, a.objective == Objective::band ? "band" : "mean", a.target_degc,
      hal::clock_text(a.work_start_s), hal::clock_text(a.work_end_s), a.min_degc, a.max_degc, a.schedule_work_degc,
      a.schedule_off_degc);
  text += m.transport == hal::ModbusTransport::tcp
              ? fmt::format("transport = \"tcp\"\nhost = \"{}\"\nport = {}\n", m.host, m.port)
              : fmt::format("transport = \"rtu\"\ndevice = \"{}\"\nbaud = {}\nparity = \"{}\"\n", m.device, m.baud,
                            std::string(1, m.parity));
  text += fmt::format("unit_id = {}\n", m.unit_id);
  for (const std::string& name : signal_names()) {
    const auto found = a.signals.find(name);
    if (found == a.signals.end()) continue;
    const SignalAnswer& s = found->second;
    text += fmt::format("\n[signals.{}]\n", name);
    if (s.is_absent) text += "absent = true\n";
    if (s.addr) text += fmt::format("addr = {}\n", *s.addr);
    if (s.apart > 0) text += fmt::format("apart = {}\n", s.apart);
    if (s.fc) text += fmt::format("fc = {}\n", *s.fc);
    if (s.type) text += fmt::format("type = \"{}\"\n", *s.type);
    if (s.scale) text += fmt::format("scale = {:g}\n", *s.scale);
  }
  return text;
}

std::string site_text_of(const InitAnswers& a) {
  if (a.name.empty() || a.name.find_first_of("\"\\\n\r") != std::string::npos) {
    throw hal::InputError("name", "'" + a.name + "'", "a name without quotes, backslashes and line ends",
                          "use letters, digits, spaces and - . , _ / ( )");
  }
  const hal::ModbusSection& m = a.modbus;
  for (const std::string& word : {m.host, m.device}) {
    if (word.find_first_of("\"\\\n\r") == std::string::npos) continue;
    throw hal::InputError("bus: host, device", "'" + word + "'", "no quotes, backslashes and line ends",
                          "correct the answer");
  }
  std::string text = hal::example_site_text(a.topology(), a.objective);
  const bool tcp = m.transport == hal::ModbusTransport::tcp;
  set(text, "site", "name", in_quotes(a.name));
  set(text, "site", "scope", in_quotes(a.name));
  set(text, "target", "room_temp_degc", fmt::format("{:g}", a.target_degc));
  set(text, "target", "work_start", in_quotes(hal::clock_text(a.work_start_s)));
  set(text, "target", "work_end", in_quotes(hal::clock_text(a.work_end_s)));
  set(text, "setpoint", "min_degc", fmt::format("{:.6g}", a.min_degc));
  set(text, "setpoint", "max_degc", fmt::format("{:.6g}", a.max_degc));
  set(text, "expert", "work_degc", fmt::format("{:g}", a.schedule_work_degc));
  set(text, "expert", "off_degc", fmt::format("{:g}", a.schedule_off_degc));
  set(text, "modbus", "transport", tcp ? "\"tcp\"" : "\"rtu\"");
  if (!m.host.empty()) set(text, "modbus", "host", in_quotes(m.host));
  set(text, "modbus", "port", std::to_string(m.port));
  if (!m.device.empty()) set(text, "modbus", "device", in_quotes(m.device));
  set(text, "modbus", "baud", std::to_string(m.baud));
  set(text, "modbus", "parity", in_quotes(std::string(1, m.parity)));
  set(text, "modbus", "unit_id", std::to_string(m.unit_id));
  if (const hal::StandIns absent = a.stand_ins(); !absent.empty()) {
    text += "\n[stand_in]               # numbers in the place of sensors that the site lacks\n";
    for (const auto& [name, value] : absent.by_name()) text += fmt::format("{} = {:g}\n", name, value);
  }
  return text;
}

std::string points_text_of(const InitAnswers& a) {
  const bool band = a.objective == Objective::band;
  const std::string all = hal::default_point_map(a.vavs, a.fcus, a.powers, a.stand_ins(), band);
  std::string out;
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t end = all.find('\n', begin);
    const std::string line = all.substr(begin, end - begin);
    begin = end + 1;
    if (line.starts_with("# clock_s") || line.starts_with("# map_fingerprint")) continue;
    if (line.starts_with('#') || line.starts_with("name,")) {
      out += line + '\n';
      continue;
    }
    std::vector<std::string> fields = split(line);
    const std::string& name = field(fields, "name");
    if (name == "clock_s" || name == "clock_advance_s" || name == "map_fingerprint") continue;  // of a simulated AHU
    if (const auto found = a.signals.find(stem_of(name)); found != a.signals.end()) {
      if (found->second.is_absent) continue;
      place(fields, found->second);
    }
    out += fmt::format("{}\n", fmt::join(fields, ","));
  }
  return out;
}

}  // namespace airside::tools
