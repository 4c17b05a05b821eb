#pragma once
// A simulated room as lib's Plant and Clock. Every number passes through the point map's registers, as it would on
// the bus, so that a run in one process and a run over Modbus see the same bits.

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "airside/plant.hpp"
#include "hal/points/point_map.hpp"
#include "hal/points/register_codec.hpp"
#include "sim/plant_model.hpp"
#include "sim/side_points.hpp"

namespace airside::sim {

/// Value of a signal as the sensors show it.
double sensor_value(const Sensors& sensors, SignalId id);
/// Value of a point as the sensors show it; nothing for a point that no sensor has, or beside the network's inputs
/// (damper_n, zone_setpoint_n, zone_heating_setpoint_n, occupied, supply_flow, ahu_on) one that the plant does not
/// offer.
std::optional<double> point_value(const Sensors& sensors, std::string_view point);

/// Wraps a PlantModel.  Model and points must outlive it.
template <Topology T>
class SimulatedPlant {
 public:
  /// Of a site of this shape. A signal that the map lacks reads as its stand-in; of a zone's several sensors, which
  /// would all show the same, one is read.
  SimulatedPlant(PlantModel& model, const hal::PointMap& points, const Shape& site = capacity_of<T>(),
                 const hal::StandIns& stand_ins = {})
      : model_(model), sides_(points) {
    for (int i = 0; i < Layout<T>::signals; ++i) {
      if (!is_present<T>(site, i)) continue;
      const SignalId id = signal_id<T>(i);
      Signal& signal = signals_[static_cast<std::size_t>(i)];
      signal.stand_in = stand_ins.of(id).value_or(signal.stand_in);
      signal.point = points.find(hal::point_name(id));
      if (signal.point != nullptr || id.kind != SignalKind::room_temp) continue;
      const std::vector<const hal::Point*> several = points.sensors(id.place);
      if (!several.empty()) signal.point = several.front();
    }
    setpoint_ = &points.at("setpoint");
    supply_temp_ = points.find("supply_temp");
  }

  Expected<Reading<T>> sense() {
    const Sensors& sensors = model_.sensors();
    Reading<T> reading;
    reading.time = model_.time();
    for (int i = 0; i < Layout<T>::signals; ++i) {
      const Signal& signal = signals_[static_cast<std::size_t>(i)];
      reading.value(i) = signal.point == nullptr ? signal.stand_in
                                                 : hal::rounded(*signal.point, sensor_value(sensors, signal_id<T>(i)));
    }
    reading.setpoint_degc = hal::rounded(*setpoint_, sensors.setpoint_degc);
    if (supply_temp_ != nullptr) reading.supply_temp_degc = hal::rounded(*supply_temp_, sensors.supply_temp_degc);
    sides_.fill(sensors, reading);
    return reading;
  }

  Expected<Applied> actuate(const Command& command) {
    const double taken = hal::rounded(*setpoint_, command.setpoint_degc());
    if (!std::isfinite(taken)) return tl::unexpected(Fault::not_applied);
    model_.set_setpoint(taken);
    return Applied{taken};
  }

 private:
  struct Signal {
    const hal::Point* point = nullptr;
    double stand_in = std::numeric_limits<double>::quiet_NaN();  ///< where there is no point
  };
  PlantModel& model_;
  SidePoints<T> sides_;
  std::array<Signal, static_cast<std::size_t>(Layout<T>::signals)> signals_{};
  const hal::Point* setpoint_;
  const hal::Point* supply_temp_;
};

/// The simulation's own time: sleeping until t makes the model reach t.
class SimulatedClock {
 public:
  explicit SimulatedClock(PlantModel& model) : model_(model) {}
  CivilTime now() { return model_.time(); }
  bool sleep_until(CivilTime t) {
    if (model_.time() < t) model_.advance_to(t);
    return true;
  }
  CivilTime woke() { return model_.time(); }

 private:
  PlantModel& model_;
};

}  // namespace airside::sim
