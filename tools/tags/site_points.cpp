#include "tools/tags/site_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hal/points/bacnet_row.hpp"
#include "hal/points/point_names.hpp"

namespace airside::tools {

namespace {

constexpr auto point_kinds = std::to_array<PointKind>({
    {"room_temp", Owner::zone, "air temperature", "Zone_Air_Temperature_Sensor", "DEG_C", "zone air temp sensor", "°C",
     false},
    {"zone_setpoint", Owner::zone, "cooling setpoint", "Cooling_Zone_Air_Temperature_Setpoint", "DEG_C",
     "zone air temp cooling sp", "°C", false},
    {"zone_heating_setpoint", Owner::zone, "heating setpoint", "Heating_Zone_Air_Temperature_Setpoint", "DEG_C",
     "zone air temp heating sp", "°C", false},
    {"vav_on", Owner::vav, "on", "On_Off_Status", "", "run sensor", "", true},
    {"damper", Owner::vav, "damper position", "Damper_Position_Sensor", "UNITLESS", "damper sensor", "", false},
    {"fcu_temp", Owner::fcu, "return air temperature", "Return_Air_Temperature_Sensor", "DEG_C",
     "return air temp sensor", "°C", false},
    {"fcu_on", Owner::fcu, "on", "On_Off_Status", "", "run sensor", "", true},
    {"power", Owner::meter, "power", "Electric_Power_Sensor", "KiloW", "elec active power sensor", "kW", false},
    {"mau_temp", Owner::mau, "outlet air temperature", "Supply_Air_Temperature_Sensor", "DEG_C",
     "discharge air temp sensor", "°C", false},
    {"outdoor_temp", Owner::ahu, "outdoor air temperature", "Outside_Air_Temperature_Sensor", "DEG_C",
     "outside air temp sensor", "°C", false},
    {"rain", Owner::ahu, "rain", "Status", "", "outside precipitation sensor", "", true},
    {"setpoint", Owner::ahu, "supply air temperature setpoint", "Supply_Air_Temperature_Setpoint", "DEG_C",
     "discharge air temp sp", "°C", false},
    {"supply_temp", Owner::ahu, "supply air temperature", "Supply_Air_Temperature_Sensor", "DEG_C",
     "discharge air temp sensor", "°C", false},
    {"supply_flow", Owner::ahu, "supply air flow", "Supply_Air_Flow_Sensor", "M3-PER-SEC", "discharge air flow sensor",
     "m³/s", false},
    {"occupied", Owner::ahu, "occupied", "Occupancy_Status", "", "occupied sensor", "", true},
    {"ahu_on", Owner::fan, "on", "Fan_On_Off_Status", "", "run sensor", "", true},
});

struct OwnerWords {
  const char* id;
  const char* label;
};
/// In the order of Owner.
constexpr std::array<OwnerWords, 7> owner_words = {{{"ahu", "AHU"},
                                                    {"fan", "supply fan"},
                                                    {"mau", "make-up air unit"},
                                                    {"vav", "VAV box"},
                                                    {"zone", "zone"},
                                                    {"fcu", "fan coil unit"},
                                                    {"meter", "power meter"}}};

const PointKind* kind_of(std::string_view stem) {
  const auto found = std::ranges::find(point_kinds, stem, &PointKind::stem);
  return found == point_kinds.end() ? nullptr : &*found;
}

/// As log files name it; the unit of the point map is that of the log.
std::string column_of_point(const hal::Point& row) {
  if (row.unit.empty()) return row.name;
  return row.name + "_" + (row.unit == "m3/s" ? "m3s" : row.unit);
}

}  // namespace

std::string owner_id(Owner owner, int place) {
  const char* id = owner_words[static_cast<std::size_t>(owner)].id;
  return place == 0 ? id : fmt::format("{}_{}", id, place);
}

std::string owner_label(Owner owner, int place) {
  const char* label = owner_words[static_cast<std::size_t>(owner)].label;
  return place == 0 ? label : fmt::format("{} {}", label, place);
}

std::vector<SitePoint> site_points(const Site& site) {
  std::vector<SitePoint> out;
  for (const hal::Point& row : site.points.points()) {
    const auto placed = hal::placed_name(row.name);
    const PointKind* kind = kind_of(placed ? placed->stem : std::string_view(row.name));
    if (kind == nullptr) continue;
    const int place = placed ? placed->place : 0;
    const bool one_of_several = placed && placed->sensor != 0;
    std::string label = owner_label(kind->owner, place) + ' ' + kind->label;
    if (one_of_several) label += fmt::format(", sensor {}", placed->sensor);
    out.push_back({&row, kind, place, std::move(label), one_of_several ? std::string() : column_of_point(row)});
  }
  return out;
}

int owners(const Site& site, const std::vector<SitePoint>& points, Owner owner) {
  switch (owner) {
    case Owner::vav:
    case Owner::zone: return site.counts.vavs;
    case Owner::fcu: return site.counts.fcus;
    case Owner::meter: return site.counts.powers;
    case Owner::ahu: return 1;
    default: break;
  }
  return std::ranges::any_of(points, [owner](const SitePoint& p) { return p.kind->owner == owner; }) ? 1 : 0;
}

std::optional<BacnetObject> bacnet_object(const hal::Point& row) {
  if (row.protocol != hal::Protocol::bacnet || row.object == hal::held_by_gateway) return {};
  std::array<std::string_view, 4> part;
  std::string_view rest = row.object;
  for (std::string_view& one : part) {
    one = rest.substr(0, rest.find(':'));
    rest.remove_prefix(std::min(one.size() + 1, rest.size()));
  }
  return BacnetObject{part[0], part[1], part[2], part[3]};
}

const std::string& log_folder(const Site& site) { return site.file.log_dir; }

}  // namespace airside::tools
