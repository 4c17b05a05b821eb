#include "tools/run/twin_options.hpp"

#include "sim/json/json_file.hpp"

namespace airside::tools {

namespace {

template <class Given>
void take(Given& into, const Given& given) {
  if (!given.empty()) into = given;
}

}  // namespace

sim::ModelNames external_names(const hal::TwinSection& twin) {
  sim::ModelNames names;
  if (!twin.names) return names;
  const hal::TwinNames& given = *twin.names;
  take(names.interior_zones, given.interior_zones);
  take(names.perimeter_zones, given.perimeter_zones);
  take(names.supply_setpoint_schedule, given.supply_setpoint_schedule);
  take(names.vav_on_schedule, given.vav_on_schedule);
  take(names.vav_damper_schedule, given.vav_damper_schedule);
  take(names.fcu_on_schedule, given.fcu_on_schedule);
  take(names.interior_occupancy_schedule, given.interior_occupancy_schedule);
  take(names.perimeter_occupancy_schedule, given.perimeter_occupancy_schedule);
  take(names.supply_air_node, given.supply_air_node);
  take(names.mau_outlet_node, given.mau_outlet_node);
  take(names.powers, given.powers);
  return names;
}

sim::OwnNames own_names(const hal::TwinNames& names) {
  sim::OwnNames own;
  own.supply_setpoint_schedule = names.supply_setpoint_schedule;
  own.supply_air_node = names.supply_air_node;
  own.mau_outlet_node = names.mau_outlet_node;
  own.zones = names.zones;
  own.terminals = names.terminals;
  own.fcu_zones = names.fcu_zones;
  own.supply_fan = names.supply_fan;
  own.powers = names.powers;
  own.occupancy = names.occupancy;
  return own;
}

bool shape_fits(const std::optional<hal::TwinSection>& twin, const hal::TopologyCounts& counts) {
  if (twin && twin->control == hal::TwinControl::own) return true;
  const sim::ModelNames names = twin ? external_names(*twin) : sim::ModelNames{};
  return counts.vavs == static_cast<int>(names.interior_zones.size()) &&
         counts.fcus == static_cast<int>(names.perimeter_zones.size()) &&
         counts.powers == static_cast<int>(names.powers.size());
}

sim::EnergyPlusOptions twin_options(const hal::TwinSection& twin) {
  sim::EnergyPlusOptions options = sim::energyplus_room("twin");
  options.model = twin.model;
  for (const std::string& path : twin.patches) options.patches.push_back({path, sim::read_json(path)});
  options.weather = twin.weather;
  if (twin.step_min != 0) options.step_min = twin.step_min;
  if (twin.control == hal::TwinControl::own) {
    options.own = own_names(*twin.names);
    options.rooms.supply_lag_s = twin.supply_lag_s;
    return options;
  }
  options.names = external_names(twin);
  std::vector<double>& dampers = options.rooms.dampers;
  const std::vector<double> usual = dampers;
  dampers.resize(options.names.interior_zones.size());
  for (std::size_t i = 0; i < dampers.size(); ++i) dampers[i] = usual[i % usual.size()];
  return options;
}

}  // namespace airside::tools
