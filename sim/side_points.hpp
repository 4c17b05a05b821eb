#pragma once
// The signals of a simulated room that are no inputs of the network: dampers, zone setpoints (of cooling and heating),
// people, supply flow, and whether the AHU's fan runs. Each passes through its register, as on the bus.

#include <array>
#include <cmath>
#include <string>

#include "airside/reading.hpp"
#include "hal/points/point_map.hpp"
#include "hal/points/register_codec.hpp"
#include "sim/plant_model.hpp"

namespace airside::sim {

template <Topology T>
class SidePoints {
 public:
  /// `points` must outlive this.
  explicit SidePoints(const hal::PointMap& points)
      : occupied_(points.find("occupied")), supply_flow_(points.find("supply_flow")), ahu_on_(points.find("ahu_on")) {
    for (std::size_t i = 0; i < rooms; ++i) {
      damper_[i] = points.find("damper_" + std::to_string(i + 1));
      zone_setpoint_[i] = points.find("zone_setpoint_" + std::to_string(i + 1));
      zone_heating_[i] = points.find("zone_heating_setpoint_" + std::to_string(i + 1));
    }
  }

  void fill(const Sensors& sensors, Reading<T>& reading) const {
    for (std::size_t i = 0; i < rooms; ++i) {
      const auto place = static_cast<Eigen::Index>(i);
      reading.damper(place) = shown(damper_[i], at(sensors.damper, i));
      reading.zone_setpoint_degc(place) = shown(zone_setpoint_[i], at(sensors.zone_setpoint_degc, i));
      reading.zone_heating_setpoint_degc(place) = shown(zone_heating_[i], at(sensors.heating_setpoint_degc, i));
    }
    reading.occupied = shown(occupied_, sensors.occupied);
    reading.supply_flow_m3s = shown(supply_flow_, sensors.supply_flow_m3s);
    reading.flows = shown(ahu_on_, sensors.ahu_on);
  }

 private:
  static constexpr auto rooms = static_cast<std::size_t>(Layout<T>::rooms);

  static double at(const std::vector<double>& values, std::size_t i) {
    return i < values.size() ? values[i] : not_shown;
  }
  /// What a client reads: the value, or where the plant offers none, the register's first content.
  static double shown(const hal::Point* point, double value) {
    if (point == nullptr) return not_shown;
    const auto registers = hal::encode(*point, std::isnan(value) ? point->default_value : value);
    return hal::decode(*point, (registers ? *registers : hal::invalid_registers(*point)).used()).value_or(not_shown);
  }

  std::array<const hal::Point*, rooms> damper_{}, zone_setpoint_{}, zone_heating_{};
  const hal::Point *occupied_, *supply_flow_, *ahu_on_;
};

}  // namespace airside::sim
