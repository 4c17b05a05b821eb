#include "sim/simulated_plant.hpp"

#include <charconv>
#include <cmath>
#include <limits>

namespace airside::sim {
namespace {

double at_place(const std::vector<double>& values, int place) {
  const std::size_t k = static_cast<std::size_t>(place - 1);
  return k < values.size() ? values[k] : std::numeric_limits<double>::quiet_NaN();
}

struct ManyPoints {
  std::string_view stem;
  std::vector<double> Sensors::*values;
  bool input = true;  ///< of the network
};
constexpr std::string_view room_temp_stem = "room_temp_";  ///< a zone's sensors may have letters: room_temp_3a
constexpr ManyPoints many_points[] = {{room_temp_stem, &Sensors::room_temp_degc},
                                      {"fcu_temp_", &Sensors::fcu_temp_degc},
                                      {"vav_on_", &Sensors::vav_on},
                                      {"fcu_on_", &Sensors::fcu_on},
                                      {"power_", &Sensors::power_kw},
                                      {"damper_", &Sensors::damper, false},
                                      {"zone_setpoint_", &Sensors::zone_setpoint_degc, false},
                                      {"zone_heating_setpoint_", &Sensors::heating_setpoint_degc, false}};

struct SinglePoint {
  std::string_view name;
  double Sensors::*value;
  bool input = true;
};
constexpr SinglePoint single_points_shown[] = {{"mau_temp", &Sensors::mau_temp_degc},
                                               {"outdoor_temp", &Sensors::outdoor_temp_degc},
                                               {"rain", &Sensors::rain},
                                               {"supply_temp", &Sensors::supply_temp_degc},
                                               {"setpoint", &Sensors::setpoint_degc},
                                               {"occupied", &Sensors::occupied, false},
                                               {"supply_flow", &Sensors::supply_flow_m3s, false},
                                               {"ahu_on", &Sensors::ahu_on, false}};

/// An input that is not a number is a broken sensor, anything else that is none is not there.
std::optional<double> offered(double value, bool input) {
  return input || !std::isnan(value) ? std::optional(value) : std::nullopt;
}

}  // namespace

std::optional<double> point_value(const Sensors& sensors, std::string_view point) {
  for (const SinglePoint& one : single_points_shown) {
    if (point == one.name) return offered(sensors.*one.value, one.input);
  }
  for (const ManyPoints& many : many_points) {
    if (!point.starts_with(many.stem)) continue;
    const std::string_view digits = point.substr(many.stem.size());
    int place = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), place);
    const std::string_view rest(end, static_cast<std::size_t>(digits.data() + digits.size() - end));
    const bool one_of_several = many.stem == room_temp_stem && rest.size() == 1 && rest[0] >= 'a' && rest[0] <= 'z';
    if (error == std::errc{} && (rest.empty() || one_of_several))
      return offered(at_place(sensors.*many.values, place), many.input);
  }
  return std::nullopt;
}

double sensor_value(const Sensors& s, SignalId id) {
  const auto at = [&id](const std::vector<double>& values) { return at_place(values, id.place); };
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
