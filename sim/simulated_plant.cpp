#include "sim/simulated_plant.hpp"

#include <limits>

namespace airside::sim {

double sensor_value(const Sensors& s, SignalId id) {
  const auto at = [&id](const std::vector<double>& values) {
    const std::size_t k = static_cast<std::size_t>(id.place - 1);
    return k < values.size() ? values[k] : std::numeric_limits<double>::quiet_NaN();
  };
  switch (id.kind) {
    case SignalKind::room_temp: return at(s.room_temp_degc);
    case SignalKind::fcu_temp: return at(s.fcu_temp_degc);
    case SignalKind::vav_on: return at(s.vav_on);
    case SignalKind::fcu_on: return at(s.fcu_on);
    case SignalKind::power: return at(s.power_kw);
    case SignalKind::mau_temp: return s.mau_temp_degc;
    case SignalKind::outdoor_temp: return s.outdoor_temp_degc;
    case SignalKind::rain: return s.rain;
    case SignalKind::setpoint: return s.setpoint_degc;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace airside::sim
