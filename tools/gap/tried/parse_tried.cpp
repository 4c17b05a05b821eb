#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "hal/text/input_error.hpp"
#include "hal/text/toml_section.hpp"
#include "tools/gap/tried/tried_effect.hpp"

namespace airside::tools::gap {

namespace {

constexpr const char* where_effects_are = "airside gap effects lists names, places and bounds";

double magnitude_of(const std::string& place, const std::string& text, std::size_t mark) {
  double magnitude = 0;
  const char* end = text.data() + text.size();
  const char* number = mark == std::string::npos ? end : text.data() + mark + 1;
  if (const auto read = std::from_chars(number, end, magnitude);
      read.ec != std::errc{} || read.ptr != end || number == end) {
    throw hal::InputError(place, mark == std::string::npos ? "no =" : "no number after =",
                          "EFFECT=MAGNITUDE or EFFECT@PLACE=MAGNITUDE such as vav_flow@2=0.5", where_effects_are);
  }
  return magnitude;
}

std::string choice(const std::vector<std::string>& known, const std::string& name) {
  const std::string near = hal::nearest_name(name, known);
  return near.empty() ? where_effects_are : fmt::format("did you mean {}? {}", near, where_effects_are);
}

const sim::Effect& effect_of(const std::string& place, const std::string& name, const std::vector<sim::Effect>& effects,
                             const Engine& engine) {
  std::vector<std::string> known;
  for (const sim::Effect& effect : effects) {
    if (effect.candidate && engine.can(effect)) known.push_back(effect.name);
  }
  const auto found = std::find_if(effects.begin(), effects.end(), [&](const auto& e) { return e.name == name; });
  if (found == effects.end()) {
    throw hal::InputError(place, fmt::format("no effect \"{}\"", name),
                          fmt::format("one of the {} effects of {}", known.size(), engine.description()),
                          choice(known, name));
  }
  if (!found->candidate || !engine.can(*found)) {
    throw hal::InputError(place,
                          found->candidate ? fmt::format("an effect that {} cannot have", engine.description())
                                           : "a parameter, which the reference period decides and no log is asked of",
                          fmt::format("one of the {} effects of {}", known.size(), engine.description()),
                          where_effects_are);
  }
  return *found;
}

sim::EffectAt place_of(const std::string& place, const std::string& id, const sim::Effect& effect,
                       const Engine& engine) {
  std::vector<std::string> ids;
  for (const sim::EffectAt& at : sim::places_of(effect, engine.channels(), engine.has_facade())) {
    if (at.id() == id) return at;
    ids.push_back(at.id());
  }
  const std::string found = id == effect.name ? "no place" : fmt::format("place \"{}\"", id.substr(id.find('@') + 1));
  if (ids.empty()) throw hal::InputError(place, found, "an effect that has a place in this model", where_effects_are);
  const std::string expected =
      ids.size() > 6 ? fmt::format("{} to {}", ids.front(), ids.back()) : fmt::format("{}", fmt::join(ids, ", "));
  throw hal::InputError(place, found, expected, choice(ids, id));
}

}  // namespace

sim::EffectChange parse_tried(const std::string& text, const std::vector<sim::Effect>& effects, const Engine& engine) {
  const std::string place = "--try " + text;
  const std::size_t mark = text.find('=');
  const double magnitude = magnitude_of(place, text, mark);
  const std::string id = text.substr(0, mark);
  const sim::Effect& effect = effect_of(place, id.substr(0, id.find('@')), effects, engine);
  const sim::EffectAt at = place_of(place, id, effect, engine);
  const std::string bounds = fmt::format("{:g} to {:g} {}, but not {:g}, at which nothing is changed", effect.low,
                                         effect.high, effect.unit, effect.null_value);
  if (!(magnitude >= effect.low && magnitude <= effect.high))
    throw hal::InputError(place, fmt::format("{:g}", magnitude), bounds, "stay within bounds");
  if (magnitude == effect.null_value)
    throw hal::InputError(place, fmt::format("{:g}, which changes nothing", magnitude), bounds,
                          "give the size that you suspect");
  return {at, magnitude};
}

}  // namespace airside::tools::gap
