#include "tools/gap/map/mapping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "hal/text/toml_section.hpp"

namespace airside::tools::gap {

namespace {

constexpr const char* see_formats = "see docs/formats.md, \"Mapping files\"";

const std::vector<std::string> kind_names{
    "room_temperature", "supply_temperature", "preheated_temperature", "outdoor_temperature", "power", "damper"};

constexpr double absolute_zero_degc = -273.15;

const std::vector<MappedUnit>& temperature_units() {
  static const std::vector<MappedUnit> units{
      {"degC", 1, 0, false}, {"degF", 5.0 / 9, -160.0 / 9, false}, {"K", 1, absolute_zero_degc, false}};
  return units;
}

const std::vector<MappedUnit>& power_units() {
  static const std::vector<MappedUnit> units{{"kW", 1, 0, false},           {"W", 1e-3, 0, false},
                                             {"MW", 1e3, 0, false},         {"Btu/h", 2.930711e-4, 0, false},
                                             {"kWh", 1, 0, true},           {"Wh", 1e-3, 0, true},
                                             {"MWh", 1e3, 0, true},         {"J", 1 / 3.6e6, 0, true},
                                             {"MJ", 1 / 3.6, 0, true},      {"GJ", 1e3 / 3.6, 0, true},
                                             {"Btu", 2.930711e-4, 0, true}, {"therm", 29.30711, 0, true}};
  return units;
}

const std::vector<MappedUnit>& fraction_units() {
  static const std::vector<MappedUnit> units{{"1", 1, 0, false}, {"%", 0.01, 0, false}};
  return units;
}

/// Of schedules, whose type nobody knows: 1 first.
std::vector<MappedUnit> command_units() {
  std::vector<MappedUnit> units = fraction_units();
  units.insert(units.end(), temperature_units().begin(), temperature_units().end());
  units.insert(units.end(), power_units().begin(), power_units().begin() + 3);
  return units;
}

MappedUnit unit_in(hal::TomlSection& table, const std::vector<MappedUnit>& units) {
  std::vector<std::string> names;
  for (const MappedUnit& unit : units) names.push_back(unit.name);
  return units[table.choice("unit", names, 0)];
}

bool is_temperature(MappedKind kind) { return kind < MappedKind::power; }

/// The tables [[key]], each with its name for complaints.
class TableList {
 public:
  TableList(const toml::table& root, const std::string& key, const std::string& file) : file_(file) {
    const toml::node* node = root.get(key);
    if (node == nullptr) return;
    const toml::array* list = node->as_array();
    if (list == nullptr || !list->is_array_of_tables()) {
      throw hal::InputError(fmt::format("{}:{}: {}", file, node->source().begin.line, key), "no list of tables",
                            "tables [[" + key + "]]", see_formats);
    }
    for (const toml::node& one : *list)
      sections_.emplace_back(one.as_table(), fmt::format("{}[{}]", key, sections_.size() + 1), file_);
  }
  std::vector<hal::TomlSection>& sections() { return sections_; }

 private:
  std::string file_;
  std::vector<hal::TomlSection> sections_;
};

[[noreturn]] void refuse_mapping(const std::string& place, const std::string& found, const std::string& expected,
                                 const std::string& remedy) {
  throw hal::InputError(place, found, expected, remedy);
}

/// A sum of meters is a meter that the model gets.
void read_summed(hal::TomlSection& table, MappedChannel& c) {
  c.summed = table.text_list("meters");
  if (c.summed.empty()) return;
  const std::string place = table.place("meters");
  if (!c.meter.empty())
    refuse_mapping(place, "a meter and a list of meters", "one of both", "put all that are summed into meters");
  for (std::size_t i = 0; i < c.summed.size(); ++i) {
    if (std::count(c.summed.begin(), c.summed.end(), c.summed[i]) > 1)
      refuse_mapping(place, "\"" + c.summed[i] + "\" twice", "each meter of the sum once", "remove one of them");
  }
  c.meter = "airside sum";
}

/// What names the object of a channel, by its kind.
void read_object(hal::TomlSection& table, MappedChannel& c) {
  c.zone = table.text("zone", "");
  c.key = table.text("key", "");
  c.output = table.text("output", "");
  c.meter = table.text("meter", "");
  read_summed(table, c);
  const std::string place = table.place("kind");
  const bool has_zone = c.kind == MappedKind::room_temperature || c.kind == MappedKind::damper;
  if (has_zone && c.zone.empty())
    refuse_mapping(place, "no zone", "the model's zone that the column is of", "add zone = \"Core_ZN\"");
  if (!has_zone && !c.zone.empty())
    refuse_mapping(table.place("zone"), "a zone for " + kind_names[static_cast<std::size_t>(c.kind)],
                   "a zone for room_temperature and damper alone", "remove it");
  const bool by_node = c.kind == MappedKind::supply_temperature || c.kind == MappedKind::preheated_temperature ||
                       c.kind == MappedKind::damper;
  if (by_node && c.key.empty())
    refuse_mapping(place, "no key", c.kind == MappedKind::damper ? "the zone's air terminal" : "a node of the air loop",
                   "add key = \"...\"");
  const bool by_variable = !c.key.empty() && !c.output.empty();
  if (c.kind == MappedKind::power && c.meter.empty() == !by_variable)
    refuse_mapping(place, c.meter.empty() ? "no meter" : "a meter and an output",
                   "a meter, a list of meters, or an output variable with its key",
                   "add meter = \"Electricity:Facility\"");
  if (c.kind != MappedKind::power && !c.meter.empty())
    refuse_mapping(table.place("meter"), "a meter for " + kind_names[static_cast<std::size_t>(c.kind)],
                   "a meter for power alone", "remove it, or make it kind = \"power\"");
  const bool may_have_output = c.kind == MappedKind::power || c.kind == MappedKind::room_temperature;
  if (!c.output.empty() && !may_have_output)
    refuse_mapping(table.place("output"), "an output for " + kind_names[static_cast<std::size_t>(c.kind)],
                   "an output for room_temperature and power alone", "remove it: this kind has its own");
  if (c.kind == MappedKind::room_temperature && c.key.empty()) c.key = c.zone;
}

MappedChannel read_channel(hal::TomlSection& table) {
  MappedChannel c;
  c.place = table.place("");
  c.column = table.required_text("column", "T core");
  c.kind = static_cast<MappedKind>(table.choice("kind", kind_names, 0));
  read_object(table, c);
  const bool power = c.kind == MappedKind::power;
  c.unit = unit_in(table, is_temperature(c.kind) ? temperature_units() : power ? power_units() : fraction_units());
  c.noise_floor = table.number("noise_floor", 0, 0, 1e6, power ? "kW" : "K");
  c.mean = table.flag("mean", power);
  c.counter = table.flag("counter", false);
  if (c.counter && !c.unit.energy)
    refuse_mapping(table.place("counter"), "a counter of " + c.unit.name, "a counter of energy, such as kWh",
                   "give the unit of energy that is counted");
  if (c.unit.energy && !c.mean)
    refuse_mapping(table.place("mean"), "mean = false for energy", "energy of a row, which is its mean power",
                   "remove it");
  table.refuse_unknown_keys();
  return c;
}

MappedCommand read_command(hal::TomlSection& table) {
  MappedCommand c;
  c.place = table.place("");
  c.column = table.required_text("column", "fan on");
  c.schedule = table.required_text("schedule", "HVACOperationSchd");
  c.supply_setpoint = table.choice("kind", {"schedule", "supply_setpoint"}, 0) == 1;
  c.unit = unit_in(table, c.supply_setpoint ? temperature_units() : command_units());
  table.refuse_unknown_keys();
  return c;
}

MappedLog read_log_section(hal::TomlSection table) {
  MappedLog log;
  log.time = table.text("time", log.time);
  log.format = table.text("format", log.format);
  const std::string separator = table.text("separator", ",");
  log.separator = separator == "tab" ? '\t' : separator.empty() ? ',' : separator.front();
  if (separator != "tab" && separator.size() != 1)
    refuse_mapping(table.place("separator"), "\"" + separator + "\"", "one character, or \"tab\"", see_formats);
  log.decimal_comma = table.flag("decimal_comma", false);
  if (log.decimal_comma && log.separator == ',')
    refuse_mapping(table.place("decimal_comma"), "a comma in numbers and between fields", "another separator",
                   "add separator = \";\"");
  if (table.has("utc_offset_h")) log.utc_offset_h = table.number("utc_offset_h", 0, -12, 14, "h");
  log.daylight_saving =
      static_cast<DaylightSaving>(table.choice("daylight_saving", {"none", "european_union", "united_states"}, 0));
  log.step_min = static_cast<int>(table.whole("step_min", log.step_min, 1, 1440));
  if (log.step_min > 30 && (log.step_min % 30 != 0 || 1440 % log.step_min != 0))
    refuse_mapping(table.place("step_min"), std::to_string(log.step_min),
                   "1 to 30, or a multiple of 30 that divides a day", "make means of such a step of the log");
  log.stamped_at_end = table.choice("stamp", {"end", "begin"}, 0) == 0;
  table.refuse_unknown_keys();
  return log;
}

std::string seen_from(const std::string& file, const std::string& text) {
  namespace fs = std::filesystem;
  if (text.empty() || fs::path(text).is_absolute()) return text;
  return (fs::path(file).parent_path() / text).lexically_normal().string();
}

void refuse_twice(const Mapping& m) {
  for (std::size_t i = 0; i < m.channels.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const MappedChannel &a = m.channels[k], &b = m.channels[i];
      const bool alone = a.kind != MappedKind::power && a.zone == b.zone;
      if (a.column == b.column || (a.kind == b.kind && alone))
        refuse_mapping(b.place, a.column == b.column ? "the column \"" + b.column + "\" twice" : "two of one place",
                       "each column once, one temperature a zone or node",
                       "remove one of them; the other is " + a.place);
    }
  }
}

void check_whole(const Mapping& m) {
  const bool compared = std::any_of(m.channels.begin(), m.channels.end(),
                                    [](const MappedChannel& c) { return c.kind != MappedKind::outdoor_temperature; });
  if (!compared)
    refuse_mapping(m.path, "no [[channel]] but the weather's", "one channel or more to compare with the model",
                   "add a temperature or a meter");
  if (m.zones.empty())
    refuse_mapping(m.place, "no zone", "the zones that effects may be in, where no room temperature names them",
                   "add zones = [\"Core_ZN\", ...] to [model]");
  refuse_twice(m);
  constexpr std::size_t most_zones = 32, most_powers = 8;
  const std::size_t powers = m.of(MappedKind::power).size();
  if (m.zones.size() > most_zones || powers > most_powers)
    refuse_mapping(m.place, fmt::format("{} zones and {} meters", m.zones.size(), powers),
                   fmt::format("at most {} and {}", most_zones, most_powers), "leave some out");
  if (std::count_if(m.commands.begin(), m.commands.end(), [](const auto& c) { return c.supply_setpoint; }) > 1)
    refuse_mapping(m.commands.back().place, "a second supply setpoint", "one", "make the other kind = \"schedule\"");
}

}  // namespace

std::vector<const MappedChannel*> Mapping::of(MappedKind kind) const {
  std::vector<const MappedChannel*> list;
  for (const MappedChannel& c : channels) {
    if (c.kind == kind) list.push_back(&c);
  }
  return list;
}

std::size_t Mapping::place_of(const MappedChannel& channel) const {
  if (channel.zone.empty()) {
    const auto list = of(channel.kind);
    return static_cast<std::size_t>(std::find(list.begin(), list.end(), &channel) - list.begin());
  }
  return static_cast<std::size_t>(std::find(zones.begin(), zones.end(), channel.zone) - zones.begin());
}

const MappedCommand* Mapping::supply_setpoint() const {
  const auto found = std::find_if(commands.begin(), commands.end(), [](const auto& c) { return c.supply_setpoint; });
  return found == commands.end() ? nullptr : &*found;
}

std::vector<const MappedCommand*> Mapping::further_commands() const {
  std::vector<const MappedCommand*> list;
  for (const MappedCommand& c : commands) {
    if (!c.supply_setpoint) list.push_back(&c);
  }
  return list;
}

Mapping read_mapping(const std::string& path) {
  return parse_mapping(hal::read_text_file(path, "a mapping file in TOML"), path);
}

Mapping parse_mapping(std::string_view text, const std::string& path) {
  const toml::table table = hal::parse_toml(text, path);
  Mapping m;
  m.path = path;
  hal::TomlSection root(&table, "", path);
  hal::TomlSection model = root.section("model");
  m.place = model.place("");
  m.model = seen_from(path, model.required_text("file", "office.idf"));
  for (const std::string& patch : model.text_list("patches")) m.patches.push_back(seen_from(path, patch));
  const std::vector<std::string> further = model.text_list("zones");
  m.air_loops = model.text_list("air_loops");
  m.step_min = static_cast<int>(model.whole("step_min", 6, 3, 6));
  if (m.step_min != 3 && m.step_min != 6)
    refuse_mapping(model.place("step_min"), std::to_string(m.step_min), "3 or 6 min", "6 is the faster one");
  model.refuse_unknown_keys();
  hal::TomlSection weather = root.section("weather");
  m.weather = seen_from(path, weather.required_text("file", "site.epw"));
  weather.refuse_unknown_keys();
  m.log = read_log_section(root.section("log"));
  TableList channels(table, "channel", path), commands(table, "command", path);
  for (hal::TomlSection& one : channels.sections()) {
    m.channels.push_back(read_channel(one));
    if (!m.channels.back().summed.empty()) m.channels.back().meter += fmt::format(" {}", m.channels.size());
  }
  for (hal::TomlSection& one : commands.sections()) m.commands.push_back(read_command(one));
  const std::vector<std::string> tables{"model", "weather", "log", "channel", "command"};
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (std::find(tables.begin(), tables.end(), name) != tables.end()) continue;
    const std::string near = hal::nearest_name(name, tables);
    refuse_mapping(root.place(name), "an unknown table `" + name + "`",
                   fmt::format("one of {}", fmt::join(tables, ", ")),
                   near.empty() ? "remove it" : "did you mean `" + near + "`?");
  }
  const auto add_zone = [&m](const std::string& zone) {
    if (std::find(m.zones.begin(), m.zones.end(), zone) == m.zones.end()) m.zones.push_back(zone);
  };
  for (const MappedChannel* room : m.of(MappedKind::room_temperature)) add_zone(room->zone);
  for (const MappedChannel* damper : m.of(MappedKind::damper)) add_zone(damper->zone);
  for (const std::string& zone : further) add_zone(zone);
  check_whole(m);
  return m;
}

hal::TopologyCounts counts_of(const Mapping& m) {
  hal::TopologyCounts counts;
  counts.vavs = static_cast<int>(m.zones.size());
  counts.powers = static_cast<int>(m.of(MappedKind::power).size());
  counts.name = fmt::format("{}vav-0fcu-{}power", counts.vavs, counts.powers);
  counts.stand_ins.resize(static_cast<std::size_t>(counts.signals()));
  for (int i = 0; i < counts.signals(); ++i) {
    if (counts.signal(i).kind == SignalKind::vav_on) counts.stand_ins[static_cast<std::size_t>(i)] = 1;
  }
  for (const MappedChannel* damper : m.of(MappedKind::damper))
    counts.sides.push_back({hal::SideSignal::damper, static_cast<int>(m.place_of(*damper)) + 1});
  return counts;
}

}  // namespace airside::tools::gap
