#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "hal/text/input_error.hpp"
#include "sim/effects/effect.hpp"
#include "sim/effects/effect_section.hpp"
#include "sim/effects/effect_text.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/json/json_file.hpp"

namespace airside::sim {

namespace {

using Json = nlohmann::json;

const std::map<std::string, PlaceKind> place_names{{"floor", PlaceKind::floor}, {"facade", PlaceKind::facade},
                                                   {"zone", PlaceKind::zone},   {"vav", PlaceKind::vav},
                                                   {"fcu", PlaceKind::fcu},     {"vav_pair", PlaceKind::vav_pair}};
const std::map<std::string, PlaceKind> each_names{
    {"zone", PlaceKind::zone}, {"vav", PlaceKind::vav}, {"fcu", PlaceKind::fcu}};
const std::map<std::string, By> by_names{{"multiply", By::multiply}, {"add", By::add},     {"set", By::set},
                                         {"raise", By::raise},       {"lower", By::lower}, {"drift", By::drift},
                                         {"lag", By::lag},           {"jet", By::jet},     {"exchange", By::exchange},
                                         {"divide", By::divide},     {"shift", By::shift}};
const std::map<std::string, Select> select_names{{"model", Select::model},         {"zones", Select::zones},
                                                 {"terminals", Select::terminals}, {"air_loop", Select::air_loop},
                                                 {"windows", Select::windows},     {"walls", Select::walls}};

using On = EffectOp::On;

/// Objects by type and relation, in a model whose names nobody knows.
void read_selected(EffectSection& s, EffectOp& op) {
  op.on = On::selected;
  if (!s.has("select")) s.refuse("select", "nothing", "one of " + keys_of(select_names));
  op.select = s.choice("select", select_names, Select::model);
  op.type = s.text("type");
  op.name = s.text("name", "");
  if (s.has("fields")) {
    const Json& list = s.at("fields");
    if (!list.is_array()) s.refuse("fields", list.dump(), "a list of field names");
    for (const Json& one : list) {
      if (!one.is_string()) s.refuse("fields", one.dump(), "a field's name");
      op.fields.push_back(one.get<std::string>());
    }
  }
  if (s.has("new")) {
    op.object = s.at("new");
    if (!op.object.is_object()) s.refuse("new", op.object.dump(), "an object of fields");
    if (op.select != Select::model && op.select != Select::zones) s.refuse("new", "select", "model or zones with it");
  }
  if (op.fields.empty() && op.object.is_null()) s.refuse("", "no fields and no new", "what is changed or added");
  op.per_area = s.flag("per_area", false);
  if (op.per_area && (op.object.is_null() || op.select != Select::zones))
    s.refuse("per_area", "nothing new in zones", "new, and select zones, with it");
  op.lowest = s.number("lowest", op.lowest);
  op.highest = s.number("highest", op.highest);
}

void read_target(EffectSection& s, EffectOp& op, const std::string& list) {
  const auto one_of = [&](const char* key, On on) {
    if (!s.has(key)) return false;
    op.on = on;
    op.field = s.text(key);
    return true;
  };
  if (list == "rc") {
    op.on = On::room;
    op.field = s.text("field");
    return;
  }
  if (list == "any_model") {
    if (!one_of("loop", On::loop)) return read_selected(s, op);
    op.lowest = s.number("lowest", op.lowest);
    op.highest = s.number("highest", op.highest);
    return;
  }
  if (list == "energyplus") {
    if (!one_of("loop", On::loop)) {
      op.on = On::model;
      op.type = s.text("type");
      op.name = s.text("name");
      op.each = s.choice("each", each_names, PlaceKind::floor);
      if (s.has("new")) {
        op.object = s.at("new");
        if (!op.object.is_object()) s.refuse("new", op.object.dump(), "an object of fields");
        return;
      }
      op.field = s.text("field");
    }
    op.lowest = s.number("lowest", op.lowest);
    op.highest = s.number("highest", op.highest);
    return;
  }
  if (!one_of("command", On::command) && !one_of("clock", On::clock) && !one_of("weather", On::weather) &&
      !one_of("sensor", On::sensor)) {
    s.refuse("", "no target", "one of command, clock, weather, sensor");
  }
}

template <class T>
bool among(const T& x, std::initializer_list<T> list) {
  return std::find(list.begin(), list.end(), x) != list.end();
}

void expect_place(const EffectSection& s, const char* key, const EffectOp& op, const Effect& effect,
                  std::initializer_list<PlaceKind> places) {
  if (among(effect.place, places)) return;
  std::string expected;
  for (const auto& [name, place] : place_names) {
    if (among(place, places)) expected += (expected.empty() ? "place " : " or ") + name;
  }
  s.refuse(key, op.field, expected + " with it");
}

void expect_by(const EffectSection& s, const EffectOp& op, std::initializer_list<By> ways) {
  if (among(op.by, ways)) return;
  std::string found, expected;
  for (const auto& [name, by] : by_names) {
    if (by == op.by) found = name;
    if (among(by, ways)) expected += (expected.empty() ? "one of " : ", ") + name;
  }
  s.refuse("by", found, expected);
}

void check_room_field(const EffectSection& s, const EffectOp& op, const Effect& effect) {
  std::string name = op.field;
  if (effect.place == PlaceKind::facade) effect_text::replace_all(name, "{facade}", "south");
  const RoomField* field = find_room_field(name);
  if (field == nullptr) s.refuse("field", op.field, "a field of the RC room");
  using P = PlaceKind;
  switch (field->repeats) {
    case Repeats::once:
      // Else every place would do the same.
      if (name == op.field)
        expect_place(s, "field", op, effect, {P::floor});
      else
        expect_place(s, "field", op, effect, {P::facade});
      break;
    case Repeats::zone: expect_place(s, "field", op, effect, {P::floor, P::zone, P::vav, P::fcu}); break;
    case Repeats::vav: expect_place(s, "field", op, effect, {P::floor, P::vav}); break;
    case Repeats::fcu: expect_place(s, "field", op, effect, {P::floor, P::fcu}); break;
  }
}

/// Placeholders that nothing would fill in.
void check_placeholders(const EffectSection& s, const EffectOp& op, const Effect& effect) {
  const PlaceKind at = op.each == PlaceKind::floor ? effect.place : op.each;
  const bool zones = among(at, {PlaceKind::zone, PlaceKind::vav, PlaceKind::fcu});
  const std::string texts = op.type + op.name + op.field + op.object.dump();
  const auto contains = [&texts](const char* mark) { return texts.find(mark) != std::string::npos; };
  if (contains("{zone}") && !zones) s.refuse("name", "{zone}", "place or each: zone, vav or fcu");
  if (contains("{n}") && at == PlaceKind::floor) s.refuse("name", "{n}", "a place, or each");
  if ((contains("{facade}") || contains("{Facade}")) && effect.place != PlaceKind::facade)
    s.refuse("name", "{facade}", "place facade with it");
  if (!op.object.is_null() && !contains("{m}") && op.factor != 1)
    s.refuse("factor", "no {m} in new", "one to stand for");
}

/// Of a model with controls of its own nothing else is beside the engine.
bool is_own_loop(const std::string& field) { return field == "supply_bias_k" || field == "supply_lag_s"; }

void check_selected(const EffectSection& s, const EffectOp& op, const Effect& effect) {
  expect_by(s, op, {By::multiply, By::add, By::set, By::raise, By::lower, By::divide, By::shift});
  const std::string object = op.object.dump();
  using P = PlaceKind;
  if (object.find("{zone}") != std::string::npos && op.select != Select::zones)
    s.refuse("new", "{zone}", "select zones with it");
  if (effect.place == P::facade && op.select != Select::windows)
    s.refuse("select", "no windows", "windows at a facade");
  if (effect.place == P::vav_pair) s.refuse("any_model", "place vav_pair", "another place");
}

void check_target(const EffectSection& s, const EffectOp& op, const Effect& effect) {
  const auto known = [&](const char* key, std::initializer_list<const char*> names) {
    if (std::find(names.begin(), names.end(), op.field) == names.end())
      s.refuse(key, op.field, fmt::format("one of {}", fmt::join(names, ", ")));
  };
  const auto plain = {By::multiply, By::add, By::set, By::raise, By::lower};
  using P = PlaceKind;
  RoomLoopOptions loops;
  switch (op.on) {
    case On::room:
      check_room_field(s, op, effect);
      expect_by(s, op, plain);
      break;
    case On::loop:
      if (op.field != "damper" && effect_text::loop_field(loops, op.field) == nullptr) {
        s.refuse("loop", op.field,
                 "one of damper, occupancy_scale, occupancy_shift_min, supply_bias_k, supply_lag_s, fcu_setpoint_degc");
      }
      if (op.field == "damper")
        expect_place(s, "loop", op, effect, {P::floor, P::vav});
      else
        expect_place(s, "loop", op, effect, {P::floor});
      expect_by(s, op, plain);
      break;
    case On::model:
      check_placeholders(s, op, effect);
      expect_by(s, op, plain);
      break;
    case On::selected: check_selected(s, op, effect); break;
    case On::command:
      known("command", {"setpoint", "vav_on", "fcu_on"});
      if (op.field == "setpoint") {
        expect_place(s, "command", op, effect, {P::floor});
        expect_by(s, op, {By::multiply, By::add, By::set, By::raise, By::lower, By::lag});
      } else {
        expect_place(s, "command", op, effect, {P::floor, op.field == "vav_on" ? P::vav : P::fcu});
        expect_by(s, op, plain);
      }
      break;
    case On::clock:
      known("clock", {"hours"});
      expect_place(s, "clock", op, effect, {P::floor});
      expect_by(s, op, {By::add});
      break;
    case On::weather:
      known("weather", {"solar", "humidity", "outdoor_temp"});
      expect_place(s, "weather", op, effect, {P::floor});
      expect_by(s, op, {By::multiply, By::add});
      break;
    case On::sensor:
      known("sensor", {"room_temp", "fcu_temp", "mau_temp", "supply_temp", "power"});
      if (op.by == By::exchange)
        expect_place(s, "by", op, effect, {P::vav_pair});
      else if (op.field == "room_temp")
        expect_place(s, "sensor", op, effect, {P::floor, P::vav});
      else if (op.field == "fcu_temp")
        expect_place(s, "sensor", op, effect, {P::floor, P::fcu});
      else
        expect_place(s, "sensor", op, effect, {P::floor});
      if (op.by == By::exchange && op.field != "room_temp") s.refuse("by", "exchange", "sensor room_temp with it");
      break;
  }
}

std::vector<EffectOp> read_ops(EffectSection& file, const char* list, const Effect& effect) {
  std::vector<EffectOp> ops;
  if (!file.has(list)) return ops;
  const Json& array = file.at(list);
  if (!array.is_array()) file.refuse(list, array.dump(), "a list of changes");
  for (std::size_t i = 0; i < array.size(); ++i) {
    EffectSection s(array[i], fmt::format("{}: {}[{}]", file.place(), list, i));
    EffectOp op;
    read_target(s, op, list);
    op.by = s.choice("by", by_names, By::add);
    op.factor = s.number("factor", 1);
    op.offset = s.number("offset", 0);
    s.nothing_else();
    check_target(s, op, effect);
    ops.push_back(std::move(op));
  }
  return ops;
}

Effect read_effect(const std::filesystem::path& path) {
  const Json json = read_json(path);
  EffectSection s(json, path.string());
  Effect e;
  e.file = path.string();
  e.name = path.stem().string();
  if (e.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos)
    s.refuse("", "the name " + e.name, "small letters, digits and _ alone: it becomes part of ids");
  e.title = s.text("title");
  e.unit = s.text("unit");
  e.place = s.choice("place", place_names, PlaceKind::floor);
  e.null_value = s.number("null");
  e.low = s.number("low");
  e.high = s.number("high");
  e.least = s.number("least", e.null_value);
  e.prior_sd = s.number("prior_sd", 0);
  e.prior_on_energyplus = s.flag("prior_on_energyplus", true);
  e.candidate = s.flag("candidate", true);
  e.looks_like = s.text("looks_like", "");
  e.confirm = s.text("confirm", "");
  e.rc = read_ops(s, "rc", e);
  e.energyplus = read_ops(s, "energyplus", e);
  e.common = read_ops(s, "common", e);
  e.any_model = read_ops(s, "any_model", e);
  for (const EffectOp& op : e.any_model) {
    if (op.on == On::loop && !is_own_loop(op.field))
      s.refuse("any_model", op.field, "supply_bias_k or supply_lag_s: there are no other loops beside such a model");
  }
  e.on_rc = !s.is_null("rc") && !(e.rc.empty() && e.common.empty());
  e.on_energyplus = !s.is_null("energyplus") && !(e.energyplus.empty() && e.common.empty());
  // Nobody commands the boxes and fan coils of such a model.
  const bool commanded = std::any_of(e.common.begin(), e.common.end(),
                                     [](const EffectOp& op) { return op.on == On::command && op.field != "setpoint"; });
  const bool plain = e.energyplus.empty() && e.on_energyplus && !e.common.empty();
  e.on_any_model = !s.is_null("any_model") && !commanded && (plain || !e.any_model.empty());
  if (!s.has("probe") || !s.at("probe").is_array() || s.at("probe").size() != 2 || !s.at("probe")[0].is_number() ||
      !s.at("probe")[1].is_number()) {
    s.refuse("probe", json.value("probe", Json()).dump(), "two magnitudes");
  }
  e.probe = {s.at("probe")[0].get<double>(), s.at("probe")[1].get<double>()};
  s.nothing_else();
  const auto within = [&](const char* key, double x) {
    if (!(x >= e.low && x <= e.high)) s.refuse(key, fmt::format("{}", x), fmt::format("{} to {}", e.low, e.high));
  };
  within("null", e.null_value);
  within("least", e.least);
  for (const double probe : e.probe) {
    within("probe", probe);
    if (probe == e.null_value) s.refuse("probe", fmt::format("{}", probe), "another magnitude than null");
  }
  if (e.probe[0] == e.probe[1]) s.refuse("probe", "the same magnitude twice", "two different ones");
  if (e.prior_sd < 0) s.refuse("prior_sd", fmt::format("{}", e.prior_sd), "0 or more");
  within("prior_sd", e.null_value + e.prior_sd);
  if (!e.on_rc && !e.on_energyplus) s.refuse("", "no change", "rc, energyplus or common");
  if (e.candidate && (e.looks_like.empty() || e.confirm.empty())) {
    s.refuse("", "no looks_like or confirm", "both: people will read them");
  }
  return e;
}

}  // namespace

std::vector<Effect> with_sun_on_site(std::vector<Effect> effects) {
  std::erase_if(effects, [](const Effect& effect) { return effect.name == "sun_differs"; });
  return effects;
}

std::vector<Effect> load_effects(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(folder, failed)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  if (failed || files.empty()) {
    throw hal::InputError(folder.string(), failed ? failed.message() : "no .json file", "a folder of effect files",
                          "name the folder with --effects, or leave it out");
  }
  std::sort(files.begin(), files.end());
  std::vector<Effect> effects;
  for (const auto& file : files) effects.push_back(read_effect(file));
  return effects;
}

std::filesystem::path find_effects() { return find_models().parent_path() / "effects" / "library"; }

}  // namespace airside::sim
