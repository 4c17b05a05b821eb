#include "tools/cli/site/ask/init_answers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <vector>

#include "airside/topology.hpp"
#include "hal/modbus/baud_rates.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_keys.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "hal/text/toml_section.hpp"
#include "hal/text/unknown_key.hpp"

namespace airside::tools {

namespace {

/// Signals whose absence leaves a number in their place; the others are optional points.
std::optional<SignalKind> stand_in_kind(const std::string& name) {
  for (const SignalKind kind : hal::StandIns::kinds()) {
    if (name == airside::text_of(kind).name) return kind;
  }
  return {};
}

[[noreturn]] void refuse_beside(const hal::TomlSection& s, const char* key, const char* beside) {
  throw hal::InputError(s.place(key), s.found(key) + beside, "one of the two", "leave out the one that is wrong");
}

SignalAnswer read_signal(hal::TomlSection s, bool is_bacnet) {
  SignalAnswer a;
  a.is_absent = s.flag("absent", false);
  // Each key is asked for, there or not: what nobody asks for is unknown, and complaints list what was asked for.
  const int addr = static_cast<int>(s.whole("addr", 0, 0, 65535)), fc = static_cast<int>(s.whole("fc", 4, 1, 4));
  const std::string& type = point_types()[s.choice("type", point_types(), 0)];
  const double scale = s.number("scale", 1, -1e6, 1e6, ""), offset = s.number("offset", 0, -1e6, 1e6, "");
  const int apart = static_cast<int>(s.whole("apart", 1, 0, is_bacnet ? 4194302 : 1000));
  const std::vector<std::string> orders = {"big", "little"};
  const std::string& order = orders[s.choice("word_order", orders, 0)];
  const std::string object = s.text("object", "");
  a.devices_apart = static_cast<int>(s.whole("devices_apart", 0, 0, 4194302));
  if (s.has("addr")) a.addr = addr;
  if (s.has("fc")) a.fc = fc;
  if (s.has("type")) a.type = type;
  if (s.has("scale")) a.scale = scale;
  if (s.has("offset")) a.offset = offset;
  if (s.has("apart")) a.apart = apart;
  if (s.has("word_order")) a.word_order = order;
  if (s.has("object")) a.object = object;
  s.refuse_unknown_keys();
  if (s.has("scale") && scale == 0) {
    throw hal::InputError(s.place("scale"), "0", "a number other than 0", "leave it out where there is none");
  }
  const std::vector<const char*> of_modbus = {"addr", "fc", "type", "word_order"},
                                 of_bacnet = {"object", "devices_apart"};
  for (const char* key : is_bacnet ? of_modbus : of_bacnet) {
    if (!s.has(key)) continue;
    refuse_beside(s, key, is_bacnet ? ", beside transport = \"bacnet\"" : ", and no transport = \"bacnet\" in [bus]");
  }
  for (const char* key : {"addr", "fc", "type", "scale", "offset", "word_order", "object"}) {
    if (a.is_absent && s.has(key)) refuse_beside(s, "absent", ", beside where the signal is");
  }
  return a;
}

void read_bus(hal::TomlSection s, InitAnswers& a) {
  hal::ModbusSection& bus = a.modbus;
  const std::size_t transport = s.choice("transport", {"tcp", "rtu", "bacnet"}, 0);
  const bool is_bacnet = transport == 2;
  bus.transport = transport == 1 ? hal::ModbusTransport::rtu : hal::ModbusTransport::tcp;
  bus.host = s.text("host", is_bacnet ? "127.0.0.1" : bus.host);
  bus.port = static_cast<int>(s.whole("port", is_bacnet ? gateway_port : bus.port, 1, 65535));
  bus.device = s.text("device", bus.device);
  bus.baud = s.one_of("baud", bus.baud, hal::baud_rates);
  bus.parity = "NEO"[s.choice("parity", {"N", "E", "O"}, 1)];
  bus.unit_id = static_cast<int>(s.whole("unit_id", bus.unit_id, bus.transport == hal::ModbusTransport::rtu, 247));
  hal::BacnetSection bacnet;
  bacnet.address = s.text("address", "");
  bacnet.port = static_cast<int>(s.whole("udp_port", bacnet.port, 1, 65535));
  bacnet.priority = static_cast<int>(s.whole("priority", bacnet.priority, 8, 16));
  bacnet.devices = s.text_list("devices");
  s.refuse_unknown_keys();
  for (const char* key : {"address", "udp_port", "priority", "devices"}) {
    if (!is_bacnet && s.has(key)) refuse_beside(s, key, ", and no transport = \"bacnet\"");
  }
  if (!is_bacnet) return;
  if (bacnet.address.empty()) {
    throw hal::InputError(s.place("address"), s.found("address"),
                          "this machine's IPv4 address in the network of the devices, with the length of its prefix",
                          "write it as address = \"192.168.1.30/24\"; `ip -4 address` shows it");
  }
  a.bacnet = bacnet;
}

}  // namespace

std::string InitAnswers::topology() const { return fmt::format("{}vav-{}fcu-{}power", vavs, fcus, powers); }

int InitAnswers::count_of(const std::string& signal) const {
  if (signal == "room_temp" || signal == "vav_on" || signal == "damper" || signal.starts_with("zone_")) return vavs;
  if (signal == "fcu_temp" || signal == "fcu_on") return fcus;
  return signal == "power" ? powers : 1;
}

bool InitAnswers::is_absent(const std::string& signal) const {
  const auto said = signals.find(signal);
  if (!bacnet) return said != signals.end() && said->second.is_absent;
  // The gateway watches a heartbeat in any case, if only its own.
  return signal != "heartbeat" && (said == signals.end() || !said->second.object);
}

hal::StandIns InitAnswers::stand_ins() const {
  hal::StandIns out;
  for (const std::string& signal : signal_names()) {
    const auto kind = stand_in_kind(signal);
    if (kind && is_absent(signal) && count_of(signal) > 0) out.set(signal, hal::StandIns::plausible(*kind).usual);
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
  read_bus(root.section("bus"), a);
  hal::TomlSection signals = root.section("signals");
  for (const std::string& name : signal_names()) {
    const hal::TomlSection one = signals.section(name);
    if (signals.has(name)) a.signals[name] = read_signal(one, a.bacnet.has_value());
  }
  signals.refuse_unknown_keys();
  root.refuse_unknown_keys();
  for (const char* needed : {"room_temp", "setpoint"}) {
    if (!a.is_absent(needed)) continue;
    throw hal::InputError(
        signals.place(needed), signals.has(needed) ? "absent = true, or no object" : "nothing",
        "a signal that no site can do without",
        a.bacnet ? "say where it is: object = \"1201:analog-input:3\"" : "say where it is: addr, fc, type, scale");
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
  if (a.bacnet) {
    text += fmt::format("transport = \"bacnet\"\naddress = \"{}\"\nudp_port = {}\npriority = {}\nport = {}\n",
                        a.bacnet->address, a.bacnet->port, a.bacnet->priority, m.port);
    const std::vector<std::string>& devices = a.bacnet->devices;
    if (!devices.empty()) text += fmt::format("devices = [\"{}\"]\n", fmt::join(devices, "\", \""));
  } else {
    text += m.transport == hal::ModbusTransport::tcp
                ? fmt::format("transport = \"tcp\"\nhost = \"{}\"\nport = {}\n", m.host, m.port)
                : fmt::format("transport = \"rtu\"\ndevice = \"{}\"\nbaud = {}\nparity = \"{}\"\n", m.device, m.baud,
                              std::string(1, m.parity));
    text += fmt::format("unit_id = {}\n", m.unit_id);
  }
  for (const std::string& name : signal_names()) {
    const auto found = a.signals.find(name);
    if (found == a.signals.end()) continue;
    const SignalAnswer& s = found->second;
    text += fmt::format("\n[signals.{}]\n", name);
    if (s.is_absent) text += "absent = true\n";
    if (s.addr) text += fmt::format("addr = {}\n", *s.addr);
    if (s.object) text += fmt::format("object = \"{}\"\n", *s.object);
    if (s.apart) text += fmt::format("apart = {}\n", *s.apart);
    if (s.devices_apart > 0) text += fmt::format("devices_apart = {}\n", s.devices_apart);
    if (s.fc) text += fmt::format("fc = {}\n", *s.fc);
    if (s.type) text += fmt::format("type = \"{}\"\n", *s.type);
    if (s.word_order) text += fmt::format("word_order = \"{}\"\n", *s.word_order);
    if (s.scale) text += fmt::format("scale = {}\n", *s.scale);
    if (s.offset) text += fmt::format("offset = {}\n", *s.offset);
  }
  return text;
}

}  // namespace airside::tools
