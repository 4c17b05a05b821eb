// What a mapping says, for the report and its readers.

#include <fmt/format.h>

#include "tools/gap/map/mapping.hpp"

namespace airside::tools::gap {

namespace {

constexpr const char* channel_words[] = {"room {}",  "supply air", "preheated outdoor air", "outdoor temperature",
                                         "power {}", "damper {}"};

std::string object_text(const MappedChannel& c) {
  if (!c.summed.empty()) return fmt::format("meters {}", fmt::join(c.summed, " + "));
  if (!c.meter.empty()) return "meter " + c.meter;
  if (c.kind == MappedKind::outdoor_temperature) return "the weather";
  const std::string at = !c.zone.empty() && c.key == c.zone ? "" : c.key;
  std::string text = c.zone.empty() ? "" : "zone " + c.zone;
  if (!at.empty()) text += (text.empty() ? "" : ", ") + at;
  return c.output.empty() ? text : text + ", " + c.output;
}

}  // namespace

nlohmann::json json_of(const Mapping& m) {
  nlohmann::json channels = nlohmann::json::array(), commands = nlohmann::json::array();
  for (const MappedChannel& c : m.channels) {
    channels.push_back(
        {{"channel", fmt::format(fmt::runtime(channel_words[static_cast<int>(c.kind)]), m.place_of(c) + 1)},
         {"column", c.column},
         {"object", object_text(c)},
         {"unit", c.unit.name},
         {"step_min", m.log.step_min},
         {"mean", c.mean}});
  }
  for (const MappedCommand& c : m.commands)
    commands.push_back({{"column", c.column}, {"schedule", c.schedule}, {"unit", c.unit.name}});
  return {{"file", m.path}, {"channels", channels}, {"commands", commands}};
}

std::vector<std::string> lines_of(const Mapping& m) {
  std::vector<std::string> lines;
  for (const MappedChannel& c : m.channels) {
    lines.push_back(fmt::format("{}: column \"{}\", {}",
                                fmt::format(fmt::runtime(channel_words[static_cast<int>(c.kind)]), m.place_of(c) + 1),
                                c.column, object_text(c)));
  }
  for (const MappedCommand& c : m.commands)
    lines.push_back(fmt::format("command: column \"{}\", schedule {}", c.column, c.schedule));
  return lines;
}

}  // namespace airside::tools::gap
