#include "hal/site/site_file.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <span>

#include "airside/civil_time.hpp"
#include "airside/crc32c.hpp"
#include "airside/topology.hpp"
#include "hal/modbus/baud_rates.hpp"
#include "hal/site/site_keys.hpp"
#include "hal/site/site_stand_ins.hpp"
#include "hal/text/foreign_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "hal/text/toml_section.hpp"
#include "hal/text/unknown_key.hpp"

namespace airside::hal {
namespace {

/// Settings that have a key of their own; an override of them would be a second truth.
struct OwnKey {
  const char* setting;
  const char* key;
};
constexpr OwnKey own_keys[] = {
    {"cycle_min", "cycle_min in [controller]"},
    {"target_degc", "room_temp_degc in [target]"},
    {"work_start_h", "work_start in [target]"},
    {"work_end_h", "work_end in [target]"},
    {"weekday_only", "weekday_only in [target]"},
    {"fan_start_h", "fan_start in [ahu]"},
    {"fan_end_h", "fan_end in [ahu]"},
    {"fan_weekday_only", "weekday_only in [ahu]"},
    {"daylight_saving", "daylight_saving in [clock]"},
    {"utc_offset_h", "utc_offset_h in [clock]"},
    {"action_min_degc", "min_degc in [setpoint]"},
    {"action_max_degc", "max_degc in [setpoint]"},
    {"action_step_k", "step_k in [setpoint]"},
    {"limit_change_k", "max_change_k in [setpoint]"},
    {"round_k", "round_k in [setpoint]"},
    {"outside_jump", "outside in [setpoint]"},
    {"expert_work_degc", "work_degc in [expert]"},
    {"expert_off_degc", "off_degc in [expert]"},
};

/// `path` as seen from the folder of the site file.
std::string resolved(const std::string& path, const std::string& site_path) {
  if (path.empty()) return path;
  const std::filesystem::path p(path);
  if (p.is_absolute()) return path;
  return (std::filesystem::path(site_path).parent_path() / p).lexically_normal().string();
}

[[noreturn]] void refuse_topology(const TomlSection& site, const std::string& name, const SiteRules& rules) {
  std::string examples;
  for (const std::string& topology : rules.topologies) examples += (examples.empty() ? "" : ", ") + topology;
  const bool counts = name.find("vav-") != std::string::npos && name.ends_with("power");
  const std::string near = counts ? "" : nearest_name(name, rules.topologies);
  const bool shape = parse_shape(name.c_str()).valid();
  throw InputError(site.place("topology"), site.found("topology"),
                   "counts of 1 to 32 VAV boxes, 0 to 32 fan coil units and 0 to 8 power meters, such as " + examples,
                   shape          ? "this build holds fewer; build with UpTo32 in AIRSIDE_TOPOLOGIES"
                   : near.empty() ? "write it like 6vav-2fcu-1power"
                                  : "did you mean \"" + near + "\"?");
}

/// A name as a scope: one that is too long keeps its beginning and becomes its own by a checksum of the whole.
std::string short_scope(const std::string& name, std::size_t most) {
  if (name.size() <= most) return name;
  return fmt::format("{}-{:08x}", name.substr(0, most - 9), crc32c(std::as_bytes(std::span(name))));
}

void read_site(TomlSection root, SiteFile& out, const SiteRules& rules) {
  if (!root.present()) {
    throw InputError(out.path + ": site", "nothing", "a table [site] with name and topology",
                     "start from the file that `airside init` writes");
  }
  out.name = root.required_text("name", "Room 301");
  root.refuse_unfit_name("name", out.name);
  out.topology = root.required_text("topology", rules.topologies.empty() ? "5vav-5fcu-2power" : rules.topologies[0]);
  const bool known = parse_shape(out.topology.c_str()).valid() && (!rules.holds || rules.holds(out.topology));
  if (!known) refuse_topology(root, out.topology, rules);
  out.meters = root.text_list("meters");
  for (const std::string& meter : out.meters) root.refuse_unfit_name("meters", meter);
  const auto powers = static_cast<std::size_t>(parse_shape(out.topology.c_str()).powers);
  if (root.has("meters") && out.meters.size() != powers) {
    root.refuse("meters", fmt::format("{} names, one a power meter of {}", powers, out.topology),
                "list one in the order of power_1, power_2, such as meters = [\"fans\", \"chiller\"], or leave it out");
  }
  constexpr std::size_t scope_bytes = 32;  // as a blob's header has them
  out.scope = root.text("scope", short_scope(out.name, scope_bytes));
  if (out.scope.size() > scope_bytes) {
    throw InputError(root.place("scope"), std::to_string(out.scope.size()) + " bytes",
                     "at most " + std::to_string(scope_bytes), "shorten the scope");
  }
  root.refuse_unknown_keys();
}

/// Which value of the rooms is held.
void read_hold(TomlSection& root, SiteFile& out) {
  out.held.rule = static_cast<HoldRule>(root.choice("hold", {"mean", "weighted", "middle"}, 0));
  const std::vector<double> weights = root.number_list("weights", 0, 1000);
  const auto rooms = static_cast<std::size_t>(parse_shape(out.topology.c_str()).vavs);
  const std::string wanted = fmt::format("{} weights, one a VAV box of {}", rooms, out.topology);
  if (out.held.rule != HoldRule::weighted) {
    if (!root.has("weights")) return;
    throw InputError(root.place("weights"), fmt::format("weights beside hold = \"{}\"", text_of(out.held.rule)),
                     "weights only where hold = \"weighted\"", "set hold = \"weighted\", or take weights out");
  }
  if (weights.size() != rooms) {
    throw InputError(root.place("weights"), root.has("weights") ? fmt::format("{} of them", weights.size()) : "nothing",
                     wanted, "list one in the order of the boxes, such as weights = [1, 1, 2]");
  }
  if (std::ranges::none_of(weights, [](double w) { return w > 0; })) {
    throw InputError(root.place("weights"), "weights that are all 0", wanted + ", one of them above 0",
                     "give the rooms that count a weight, or set hold = \"mean\"");
  }
  std::ranges::copy(weights, out.held.weights.begin());
}

void read_target(TomlSection root, SiteFile& out) {
  out.room_temp_degc = root.number("room_temp_degc", out.room_temp_degc, 10, 40, "degC");
  read_hold(root, out);
  out.work_start_s = root.time_of_day("work_start", out.work_start_s);
  out.work_end_s = root.time_of_day("work_end", out.work_end_s);
  out.weekday_only = root.flag("weekday_only", out.weekday_only);
  if (out.work_start_s >= out.work_end_s) {
    const char* key = root.has("work_end") ? "work_end" : "work_start";
    root.refuse(key, "work_start before work_end on the same day", "exchange them, or split a night shift at midnight");
  }
  root.refuse_unknown_keys();
}

void read_ahu(TomlSection root, SiteFile& out) {
  out.fan_start_s = root.time_of_day("fan_start", out.fan_start_s);
  out.fan_end_s = root.time_of_day("fan_end", out.fan_end_s);
  out.fan_weekday_only = root.flag("weekday_only", out.fan_weekday_only);
  if (out.fan_start_s >= out.fan_end_s) {
    const char* key = root.has("fan_end") ? "fan_end" : "fan_start";
    throw InputError(root.place(key), root.found(key), "fan_start before fan_end on the same day",
                     "exchange the two; a fan that also runs over midnight is shown by a point ahu_on");
  }
  root.refuse_unknown_keys();
}

void read_setpoint(TomlSection root, SiteFile& out) {
  out.setpoint_min_degc = root.number("min_degc", out.setpoint_min_degc, 5, 40, "degC");
  out.setpoint_max_degc = root.number("max_degc", out.setpoint_max_degc, 5, 40, "degC");
  out.setpoint_step_k = root.number("step_k", out.setpoint_step_k, 0.05, 2, "K");
  out.setpoint_max_change_k = root.number("max_change_k", out.setpoint_max_change_k, 0.01, 20, "K");
  out.setpoint_round_k = root.number("round_k", out.setpoint_round_k, 0.001, 1, "K");
  out.setpoint_outside_jump = root.choice("outside", {"step", "jump"}, 0) == 1;
  if (out.setpoint_min_degc >= out.setpoint_max_degc) {
    const char* key = root.has("max_degc") ? "max_degc" : "min_degc";
    throw InputError(root.place(key), root.found(key), "min_degc below max_degc", "exchange the two values");
  }
  root.refuse_unknown_keys();
}

void read_expert(TomlSection root, SiteFile& out) {
  out.expert_work_degc = root.number("work_degc", out.expert_work_degc, 5, 40, "degC");
  out.expert_off_degc = root.number("off_degc", out.expert_off_degc, 5, 40, "degC");
  root.refuse_unknown_keys();
}

/// After the objective: not every one has every cycle.
void read_cycle(TomlSection& root, SiteFile& out) {
  out.cycle_min = static_cast<int>(root.whole("cycle_min", out.cycle_min, 6, most_rows_per_cycle * row_s / 60));
  if (!is_cycle_min(out.cycle_min)) {
    throw InputError(root.place("cycle_min"), root.found("cycle_min"), "6, 12, 18 or 24 min",
                     "give whole rows of 6 min; 18 where nothing speaks for another");
  }
  if (fits_objective(out.objective, out.cycle_min)) return;
  throw InputError(root.place("cycle_min"), root.found("cycle_min") + " beside objective = \"band\"",
                   std::to_string(band_cycle.minutes()) + ": what band learns and costs is of cycles of that length",
                   "leave cycle_min out, or take objective = \"mean\"");
}

void read_controller(TomlSection root, SiteFile& out, const SiteRules& rules) {
  out.preset = static_cast<ControllerPreset>(root.choice("preset", preset_names(), 0));
  out.objective = static_cast<Objective>(root.choice("objective", {"mean", "band"}, 0));
  if (out.objective == Objective::band && out.held.rule != HoldRule::mean) {
    throw InputError(
        root.place("objective"), fmt::format("\"band\" beside hold = \"{}\" in [target]", text_of(out.held.rule)),
        "hold = \"mean\", since band keeps every zone in its own band", "take hold and weights out of [target]");
  }
  read_cycle(root, out);
  out.seed = static_cast<std::uint64_t>(root.whole("seed", 1, 0, std::numeric_limits<std::int64_t>::max()));
  TomlSection override_table = root.section("override");
  std::vector<std::string> names;
  for (const SettingRule& rule : rules.settings) names.push_back(rule.name);
  for (const std::string& key : override_table.take_all_keys()) {
    for (const OwnKey& own : own_keys) {
      if (key != own.setting) continue;
      throw InputError(override_table.place(key), "an override of `" + key + "`",
                       std::string("only settings without a key of their own"), std::string("set ") + own.key);
    }
    const SettingRule* rule = nullptr;
    for (const SettingRule& r : rules.settings) {
      if (r.name == key) rule = &r;
    }
    if (rule == nullptr && !rules.settings.empty()) {
      const std::string near = nearest_name(key, names);
      throw InputError(override_table.place(key), "an unknown setting `" + key + "`", "a setting of the controller",
                       near.empty() ? "remove it" : "did you mean `" + near + "`?");
    }
    constexpr double huge = std::numeric_limits<double>::max();
    out.overrides[key] = override_table.number(key, rule ? rule->default_value : 0, rule ? rule->min : -huge,
                                               rule ? rule->max : huge, "");
  }
  root.refuse_unknown_keys();
}

enum class Address : std::uint8_t { none, loopback, other };

Address kind_of_address(const std::string& text) {
  in_addr four{};
  in6_addr six{};
  if (::inet_pton(AF_INET, text.c_str(), &four) == 1) {
    return ntohl(four.s_addr) >> 24 == 127 ? Address::loopback : Address::other;
  }
  if (::inet_pton(AF_INET6, text.c_str(), &six) != 1) return Address::none;
  return IN6_IS_ADDR_LOOPBACK(&six) ? Address::loopback : Address::other;
}

bool is_host_name(const std::string& text) {
  const bool letters = std::ranges::all_of(
      text, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.'; });
  return !text.empty() && text.size() <= 253 && letters && text.front() != '.' && text.back() != '.';
}

/// Whether a device may be called so: an address, or a name that is no number with points.
bool is_address(const std::string& text) {
  if (kind_of_address(text) != Address::none) return true;
  std::string small(text);
  for (char& c : small) c = c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return is_host_name(small) && small.find_first_not_of("0123456789.") != std::string::npos;
}

void read_modbus(TomlSection root, SiteFile& out) {
  if (!root.present()) return;
  ModbusSection m;
  m.transport = static_cast<ModbusTransport>(root.choice("transport", {"tcp", "rtu"}, 0));
  const bool tcp = m.transport == ModbusTransport::tcp;
  if (tcp && root.has("host") && root.text("host", "").empty()) {
    throw InputError(root.place("host"), "an empty text", "the address of the AHU's controller, or a host name",
                     "write it as host = \"192.168.1.20\": it is in the controller's network settings; where the AHU "
                     "speaks BACnet, host = \"127.0.0.1\"; for a room that is only simulated take [modbus] out");
  }
  m.host = tcp ? root.required_text("host", "192.168.1.20") : root.text("host", "");
  m.host_place = root.place("host");
  if (tcp && !is_address(m.host)) {
    throw InputError(root.place("host"), root.found("host"), "an address such as 192.168.1.20, or a host name",
                     "leave scheme, path and port out; the port goes to port");
  }
  m.port = static_cast<int>(root.whole("port", m.port, 1, 65535));
  m.device = tcp ? root.text("device", "") : root.required_text("device", "/dev/ttyUSB0");
  m.baud = root.one_of("baud", m.baud, baud_rates);
  m.parity = "NEO"[root.choice("parity", {"N", "E", "O"}, 1)];
  m.unit_id = static_cast<int>(root.whole("unit_id", m.unit_id, tcp ? 0 : 1, 247));  // 0 is broadcast there
  m.deadline_s = root.number("deadline_s", m.deadline_s, 0.1, 10, "s");
  m.heartbeat_s = root.number("heartbeat_s", m.heartbeat_s, 5, 360, "s");
  m.points = resolved(root.text("points", "points.csv"), out.path);
  root.refuse_unknown_keys();
  out.modbus = m;
}

void read_twin(TomlSection root, SiteFile& out) {
  if (!root.present()) return;
  TwinSection twin = read_twin_section(std::move(root), out.topology);
  if (twin.model != "rc") twin.model = resolved(twin.model, out.path);
  for (std::string& patch : twin.patches) patch = resolved(patch, out.path);
  twin.weather = resolved(twin.weather, out.path);
  out.twin = std::move(twin);
}

void read_mqtt(TomlSection root, SiteFile& out) {
  if (!root.present()) return;
  MqttSection mqtt = read_mqtt_section(std::move(root), out.name);
  mqtt.tls_ca = resolved(mqtt.tls_ca, out.path);
  mqtt.password_file = resolved(mqtt.password_file, out.path);
  out.mqtt = std::move(mqtt);
}

void read_folders(TomlSection& root, SiteFile& out) {
  TomlSection clock = root.section("clock");
  out.clock = static_cast<ClockSource>(clock.choice("source", {"system", "plant"}, 0));
  out.daylight_saving = static_cast<int>(clock.choice("daylight_saving", {"none", "eu", "us"}, 0));
  out.utc_offset_h = clock.number("utc_offset_h", out.utc_offset_h, -12, 14, "h");
  clock.refuse_unknown_keys();
  TomlSection state = root.section("state");
  out.state_dir = resolved(state.text("dir", "state"), out.path);
  state.refuse_unknown_keys();
  TomlSection log = root.section("log");
  out.log_dir = resolved(log.text("dir", "log"), out.path);
  out.log_max_files = static_cast<int>(log.whole("max_files", out.log_max_files, 2, 4000));
  out.log_max_file_mb = log.number("max_file_mb", out.log_max_file_mb, 0.1, 1000, "MB");
  log.refuse_unknown_keys();
  TomlSection history = root.section("history");
  out.history_log = resolved(history.text("log", ""), out.path);
  history.refuse_unknown_keys();
  TomlSection weights = root.section("weights");
  out.weights_blob = resolved(weights.text("blob", ""), out.path);
  out.keys_dir = resolved(weights.text("keys", "keys"), out.path);
  weights.refuse_unknown_keys();
  TomlSection inbox = root.section("inbox");
  out.inbox_dir = resolved(inbox.text("dir", "inbox"), out.path);
  inbox.refuse_unknown_keys();
  if (out.inbox_dir == out.state_dir && !out.state_dir.empty()) {  // where weights.blob is given out, not pushed
    throw InputError(inbox.place("dir"), inbox.found("dir") + ", which is [state] dir", "a folder of its own",
                     "name another");
  }
}

void read_page(TomlSection root, SiteFile& out) {
  PageSection& page = out.page;
  page.listen = root.text("listen", page.listen);
  const Address kind = kind_of_address(page.listen);
  if (kind == Address::none) {
    throw InputError(root.place("listen"), root.found("listen"), "a numeric address such as 127.0.0.1 or 192.168.1.30",
                     "give the address of the network card that people reach, or leave it out");
  }
  page.port = static_cast<int>(root.whole("port", page.port, 0, 65535));
  page.names = root.text_list("names");
  for (const std::string& name : page.names) {
    if (is_host_name(name)) continue;
    throw InputError(root.place("names"), "\"" + name.substr(0, 40) + "\"",
                     "host names in small letters, such as \"ahu-3.example.org\"", "leave scheme and port out");
  }
  page.tls_cert = resolved(root.text("tls_cert", ""), out.path);
  page.tls_key = resolved(root.text("tls_key", ""), out.path);
  if (page.tls_cert.empty() != page.tls_key.empty()) {
    const char* missing = page.tls_cert.empty() ? "tls_cert" : "tls_key";
    throw InputError(root.place(missing), "nothing", "certificate and key together", "name both PEM files, or none");
  }
  if (kind == Address::other && page.tls_cert.empty()) {
    throw InputError(root.place("listen"), root.found("listen"),
                     "a loopback address, since without tls_cert and tls_key everybody on the way reads along",
                     "name both PEM files, or listen on 127.0.0.1 and come by ssh -L");
  }
  page.dir = resolved(root.text("dir", "page"), out.path);
  if (page.dir.empty() || page.dir == out.state_dir || page.dir == out.inbox_dir) {
    throw InputError(root.place("dir"), root.found("dir"), "a folder of the page's own, beside [state] and [inbox] dir",
                     "name another");
  }
  root.refuse_unknown_keys();
}

void read_sections(TomlSection root, SiteFile& out, const SiteRules& rules) {
  read_site(root.section("site"), out, rules);
  read_target(root.section("target"), out);
  read_ahu(root.section("ahu"), out);
  read_setpoint(root.section("setpoint"), out);
  read_expert(root.section("expert"), out);
  read_controller(root.section("controller"), out, rules);
  out.stand_ins = read_stand_ins(root.section("stand_in"), out.topology);
  read_modbus(root.section("modbus"), out);
  out.bacnet = read_bacnet_section(root.section("bacnet"));
  read_folders(root, out);
  read_page(root.section("page"), out);
  read_twin(root.section("twin"), out);
  read_mqtt(root.section("mqtt"), out);
  root.refuse_unknown_keys();
}

}  // namespace

SiteFile parse_site_text(std::string_view text, const std::string& path, const SiteRules& rules) {
  refuse_foreign_text(text, path + ":1:1", "a site file in TOML");
  if (text.find('\0') != std::string_view::npos) {
    throw InputError(path + ":1:1", "bytes that are not text", "a site file in TOML", "give the site's .toml file");
  }
  const toml::table table = parse_toml(text, path);
  SiteFile out;
  out.path = path;
  try {
    read_sections(TomlSection(&table, "", path), out, rules);
  } catch (const UnknownKey& unknown) {
    const std::string sections = sections_of_site_key(unknown.key());
    if (sections.empty() || sections == "[" + unknown.section() + "]") throw;
    throw InputError(unknown.place(), unknown.found(), unknown.expected(), "move it below " + sections);
  }
  return out;
}

SiteFile read_site_file(const std::string& path, const SiteRules& rules) {
  return parse_site_text(read_text_file(path, "a site file in TOML"), path, rules);
}

}  // namespace airside::hal
