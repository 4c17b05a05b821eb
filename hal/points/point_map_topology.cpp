// Whether a point map has the signals of a site's topology.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "hal/points/point_map.hpp"
#include "hal/points/point_names.hpp"

namespace airside::hal {
namespace {

constexpr std::array<SignalKind, 8> map_kinds = {SignalKind::room_temp,    SignalKind::fcu_temp, SignalKind::vav_on,
                                                 SignalKind::fcu_on,       SignalKind::power,    SignalKind::mau_temp,
                                                 SignalKind::outdoor_temp, SignalKind::rain};

[[noreturn]] void refuse_missing_room(const PointMap& map, SignalId id) {
  if (id.place == 1 && map.find("room_temp_0") != nullptr) {
    throw InputError(map.file(), "no point \"room_temp_1\", and \"room_temp_0\"", "rooms numbered from 1",
                     "number all rows of zones, boxes and meters from 1");
  }
  throw InputError(map.file(), fmt::format("no point \"{}\"", point_name(id)), "a row for it",
                   fmt::format("add the row with its address, type, scale and limits; a zone with several sensors has "
                               "rows {} and {} instead",
                               sensor_name(id.place, 'a'), sensor_name(id.place, 'b')));
}

/// `vav_on_2 to vav_on_12, rain`, of signals in their order.
std::string listed(const std::vector<SignalId>& ids) {
  std::string text;
  for (std::size_t first = 0; first < ids.size();) {
    std::size_t last = first;
    while (last + 1 < ids.size() && ids[last + 1].kind == ids[first].kind && ids[last + 1].place == ids[last].place + 1)
      ++last;
    text += (text.empty() ? "\"" : ", \"") + point_name(ids[first]) + "\"";
    if (last > first) text += " to \"" + point_name(ids[last]) + "\"";
    first = last + 1;
  }
  return text;
}

/// Every signal at once, so that a site is not asked for them one after the other.
[[noreturn]] void refuse_missing(const PointMap& map, const std::vector<SignalId>& ids) {
  std::vector<std::string> lines;
  const bool one = ids.size() == 1;
  for (const SignalId id : ids) {
    const std::string name = one || !has_places(id.kind) ? point_name(id) : text_of(id.kind).name;
    const std::string line = fmt::format("`{} = {:g}`", name, StandIns::plausible(id.kind).usual);
    if (lines.empty() || lines.back() != line) lines.push_back(line);
  }
  throw InputError(
      map.file(), fmt::format("no point {}, and no stand-in for {}", listed(ids), one ? "it" : "them"),
      fmt::format("a row for {}, or a stand-in in the site file", one ? "it" : "each"),
      fmt::format("add the row with its address, type, scale and limits; where the site has no such sensor, add {} to "
                  "[stand_in] of the site file, and `airside check` says what it costs",
                  fmt::join(lines, ", ")));
}

/// A stand-in beside a row would be a second truth.
void refuse_both(const PointMap& map, const StandIns& stand_ins, const SignalCounts& counts) {
  for (const auto& [name, value] : stand_ins.by_name()) {
    const auto kind = StandIns::kind_of(name, counts);
    if (!kind) continue;
    const Point* row = map.find(name);
    if (row == nullptr && has_places(*kind) && name == text_of(*kind).name) {
      bool all = true;  // a stand-in of the kind is for those that have no row
      for (int place = 1; place <= counts.of(*kind); ++place) all = all && map.has({*kind, place});
      if (all) row = map.find(point_name({*kind, 1}));
    }
    if (row == nullptr) continue;
    throw InputError(fmt::format("{}:{}, column name", map.file(), row->line),
                     fmt::format("\"{}\" beside the stand-in `{} = {:g}`", row->name, name, value),
                     "a row or a stand-in, not both",
                     "remove the line from [stand_in] of the site file, or the row if there is no such sensor");
  }
}

void refuse_foreign_places(const PointMap& map, const SignalCounts& counts) {
  for (const Point& p : map.points()) {
    const auto name = placed_name(p.name);
    if (!name) continue;
    const int most = counts.of(name->counted);
    if (name->place >= 1 && name->place <= most) continue;
    throw InputError(fmt::format("{}:{}, column name", map.file(), p.line), "\"" + p.name + "\"",
                     most == 0 ? fmt::format("no {} in a room of {} VAV, {} FCU, {} power meters", name->stem,
                                             counts.vavs, counts.fcus, counts.powers)
                               : fmt::format("{}_1 to {}_{} in a room of {} VAV, {} FCU, {} power meters", name->stem,
                                             name->stem, most, counts.vavs, counts.fcus, counts.powers),
                     "choose the topology that fits the room, or remove the row");
  }
}

void refuse_two_forms(const PointMap& map, int vavs) {
  for (int place = 1; place <= vavs; ++place) {
    const Point* one = map.find(point_name({SignalKind::room_temp, place}));
    const std::vector<const Point*> several = map.sensors(place);
    if (one == nullptr || several.empty()) continue;
    throw InputError(fmt::format("{}:{}, column name", map.file(), several.front()->line),
                     fmt::format("\"{}\" beside \"{}\" (line {})", several.front()->name, one->name, one->line),
                     "one sensor under the name alone, or several with letters",
                     fmt::format("rename the row of line {} to {}", one->line,
                                 sensor_name(place, static_cast<char>(several.back()->name.back() + 1))));
  }
}

}  // namespace

std::vector<const Point*> PointMap::sensors(int place) const {
  std::vector<const Point*> found;
  for (char sensor = first_sensor; sensor <= last_sensor; ++sensor) {
    if (const Point* p = find(sensor_name(place, sensor)); p != nullptr) found.push_back(p);
  }
  return found;
}

bool PointMap::has(SignalId id) const {
  if (find(point_name(id)) != nullptr) return true;
  return id.kind == SignalKind::room_temp && !sensors(id.place).empty();
}

void PointMap::check_topology(int vavs, int fcus, int powers, const StandIns& stand_ins) const {
  const SignalCounts counts{vavs, fcus, powers};
  std::vector<SignalId> missing;
  for (const SignalKind kind : map_kinds) {
    for (int i = 1; i <= counts.of(kind); ++i) {
      const SignalId id{kind, has_places(kind) ? i : 0};
      if (has(id) || stand_ins.of(id)) continue;
      if (kind == SignalKind::room_temp) refuse_missing_room(*this, id);
      missing.push_back(id);
    }
  }
  if (!missing.empty()) refuse_missing(*this, missing);
  if (const Point& setpoint = at("setpoint"); !setpoint.readable() && find("supply_temp") == nullptr) {
    throw InputError(fmt::format("{}:{}, column readback", file_, setpoint.line),
                     "a setpoint that cannot be read back, and no point supply_temp",
                     "one of the two, so that somebody sees whether the AHU follows",
                     "add supply_temp, or name the point that shows the setpoint taken");
  }
  refuse_both(*this, stand_ins, counts);
  refuse_foreign_places(*this, counts);
  refuse_two_forms(*this, vavs);
}

}  // namespace airside::hal
