// Whether a point map has the signals of a site's topology.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "hal/points/point_map.hpp"
#include "hal/points/point_names.hpp"
#include "hal/points/point_row.hpp"
#include "hal/text/toml_section.hpp"

namespace airside::hal {
namespace {

constexpr std::array<SignalKind, 8> map_kinds = {SignalKind::room_temp,    SignalKind::fcu_temp, SignalKind::vav_on,
                                                 SignalKind::fcu_on,       SignalKind::power,    SignalKind::mau_temp,
                                                 SignalKind::outdoor_temp, SignalKind::rain};

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

using Complaints = std::vector<InputError>;

void miss_rooms(const PointMap& map, const std::vector<SignalId>& ids, Complaints& complaints) {
  if (ids.empty()) return;
  if (ids.front().place == 1 && map.find("room_temp_0") != nullptr) {
    complaints.emplace_back(map.file(), "no point \"room_temp_1\", and \"room_temp_0\"", "rooms numbered from 1",
                            "number all rows of zones, boxes and meters from 1");
    return;
  }
  const int place = ids.front().place;
  complaints.emplace_back(
      map.file(), fmt::format("no point {}", listed(ids)), ids.size() == 1 ? "a row for it" : "a row for each",
      fmt::format("{}add the row with its address, type, scale and limits; a zone with several "
                  "sensors has rows {} and {} instead",
                  named_alike(map, point_name(ids.front())), sensor_name(place, 'a'), sensor_name(place, 'b')));
}

/// Every signal at once, so that a site is not asked for them one after the other.
void miss_signals(const PointMap& map, const std::vector<SignalId>& ids, Complaints& complaints) {
  if (ids.empty()) return;
  std::vector<std::string> lines;
  const bool one = ids.size() == 1;
  for (const SignalId id : ids) {
    const std::string name = one || !has_places(id.kind) ? point_name(id) : text_of(id.kind).name;
    const std::string line = fmt::format("`{} = {:g}`", name, StandIns::plausible(id.kind).usual);
    if (lines.empty() || lines.back() != line) lines.push_back(line);
  }
  complaints.emplace_back(
      map.file(), fmt::format("no point {}, and no stand-in for {}", listed(ids), one ? "it" : "them"),
      fmt::format("a row for {}, or a stand-in in the site file", one ? "it" : "each"),
      fmt::format("{}add the row with its address, type, scale and limits; where the site has no such sensor, add {} "
                  "to [stand_in] of the site file, and `airside check` says what it costs",
                  named_alike(map, point_name(ids.front())), fmt::join(lines, ", ")));
}

/// A stand-in beside a row would be a second truth.
void check_stand_ins(const PointMap& map, const StandIns& stand_ins, const SignalCounts& counts,
                     Complaints& complaints) {
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
    complaints.emplace_back(fmt::format("{}:{}, column name", map.file(), row->line),
                            fmt::format("\"{}\" beside the stand-in `{} = {:g}`", row->name, name, value),
                            "a row or a stand-in, not both",
                            "remove the line from [stand_in] of the site file, or the row if there is no such sensor");
  }
}

void check_places(const PointMap& map, const SignalCounts& counts, Complaints& complaints) {
  for (const Point& p : map.points()) {
    const auto name = placed_name(p.name);
    if (!name) continue;
    const int most = counts.of(name->counted);
    if (name->place >= 1 && name->place <= most) continue;
    complaints.emplace_back(fmt::format("{}:{}, column name", map.file(), p.line), "\"" + p.name + "\"",
                            most == 0
                                ? fmt::format("no {} in a room of {} VAV, {} FCU, {} power meters", name->stem,
                                              counts.vavs, counts.fcus, counts.powers)
                                : fmt::format("{}_1 to {}_{} in a room of {} VAV, {} FCU, {} power meters", name->stem,
                                              name->stem, most, counts.vavs, counts.fcus, counts.powers),
                            "choose the topology that fits the room, or remove the row");
  }
}

void check_forms(const PointMap& map, int vavs, Complaints& complaints) {
  for (int place = 1; place <= vavs; ++place) {
    const Point* one = map.find(point_name({SignalKind::room_temp, place}));
    const std::vector<const Point*> several = map.sensors(place);
    if (one == nullptr || several.empty()) continue;
    complaints.emplace_back(fmt::format("{}:{}, column name", map.file(), several.front()->line),
                            fmt::format("\"{}\" beside \"{}\" (line {})", several.front()->name, one->name, one->line),
                            "one sensor under the name alone, or several with letters",
                            fmt::format("rename the row of line {} to {}", one->line,
                                        sensor_name(place, static_cast<char>(several.back()->name.back() + 1))));
  }
}

}  // namespace

std::string named_alike(const PointMap& map, std::string_view name) {
  const std::string near = nearest_name(name, map.extras());
  if (near.empty()) return {};
  return fmt::format("line {} has \"{}\": correct its name if it is that; otherwise ", map.at(near).line, near);
}

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

std::vector<InputError> PointMap::topology_complaints(int vavs, int fcus, int powers, const StandIns& stand_ins) const {
  const SignalCounts counts{vavs, fcus, powers};
  Complaints complaints;
  std::vector<SignalId> rooms, others;
  for (const SignalKind kind : map_kinds) {
    for (int i = 1; i <= counts.of(kind); ++i) {
      const SignalId id{kind, has_places(kind) ? i : 0};
      if (has(id) || stand_ins.of(id)) continue;
      (kind == SignalKind::room_temp ? rooms : others).push_back(id);
    }
  }
  miss_rooms(*this, rooms, complaints);
  miss_signals(*this, others, complaints);
  keeps_complaint(complaints, [&] {
    const Point& setpoint = at("setpoint");
    if (setpoint.readable() || find("supply_temp") != nullptr) return;
    throw InputError(fmt::format("{}:{}, column readback", file_, setpoint.line),
                     "a setpoint that cannot be read back, and no point supply_temp",
                     "one of the two, so that somebody sees whether the AHU follows",
                     "add supply_temp, or name the point that shows the setpoint taken");
  });
  check_stand_ins(*this, stand_ins, counts, complaints);
  check_places(*this, counts, complaints);
  check_forms(*this, vavs, complaints);
  return complaints;
}

void PointMap::check_topology(int vavs, int fcus, int powers, const StandIns& stand_ins) const {
  const Complaints complaints = topology_complaints(vavs, fcus, powers, stand_ins);
  if (!complaints.empty()) throw InputError(complaints.front());
}

}  // namespace airside::hal
