#include "hal/site/site_log.hpp"

#include <array>
#include <string>

namespace airside::hal {

TopologyCounts counts_of(TopologyCounts counts, const PointMap& map, const StandIns& stand_ins) {
  counts.stand_ins.clear();
  counts.sides.clear();
  if (!stand_ins.empty()) {
    for (int i = 0; i < counts.signals(); ++i) {
      const SignalId id = counts.signal(i);
      counts.stand_ins.push_back(map.has(id) ? std::nullopt : stand_ins.of(id));
    }
  }
  struct Named {
    const char* name;
    SideSignal signal;
  };
  constexpr std::array<Named, 3> placed = {{{"damper_", SideSignal::damper},
                                            {"zone_setpoint_", SideSignal::zone_setpoint},
                                            {"zone_heating_setpoint_", SideSignal::zone_heating_setpoint}}};
  for (const Named& side : placed) {
    for (int place = 1; place <= counts.vavs; ++place) {
      if (map.find(side.name + std::to_string(place)) != nullptr) counts.sides.push_back({side.signal, place});
    }
  }
  constexpr std::array<Named, 3> single = {
      {{"occupied", SideSignal::occupied}, {"supply_flow", SideSignal::supply_flow}, {"ahu_on", SideSignal::ahu_on}}};
  for (const Named& side : single) {
    if (map.find(side.name) != nullptr) counts.sides.push_back({side.signal, 0});
  }
  return counts;
}

}  // namespace airside::hal
