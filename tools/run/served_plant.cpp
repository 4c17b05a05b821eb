#include "tools/run/served_plant.hpp"

#include <algorithm>

#include "hal/modbus/wire.hpp"
#include "hal/points/register_codec.hpp"
#include "sim/simulated_plant.hpp"

namespace airside::tools {

ServedPlant::ServedPlant(sim::PlantModel& model, hal::ModbusServer& server, double speed, CivilTime end)
    : model_(model), server_(server), speed_(speed), end_(end), began_(model.time()), began_ns_(hal::monotonic_ns()) {
  server_.on_write([this](const hal::Point& point, double value) { return write(point, value); });
  publish();
}

void ServedPlant::step() {
  CivilTime t = wanted_;
  if (speed_ > 0) {
    const double real_s = static_cast<double>(hal::monotonic_ns() - began_ns_) * 1e-9;
    t.seconds = began_.seconds + static_cast<std::int64_t>(real_s * speed_);
  }
  const std::int64_t step_s = model_.step_s();
  t.seconds = std::min(t.seconds, end_.seconds);
  const CivilTime reach{model_.time().seconds + (t.seconds - model_.time().seconds) / step_s * step_s};
  if (reach > model_.time()) {
    model_.advance_to(reach);
    publish();
  }
}

double ServedPlant::write(const hal::Point& point, double value) {
  const double taken = std::clamp(value, point.min, point.max);
  if (point.name == "setpoint") {
    model_.set_setpoint(hal::rounded(point, taken));
    return model_.sensors().setpoint_degc;
  }
  if (point.name == "clock_advance_s") {
    wanted_.seconds = std::max(wanted_.seconds, hal::clock_epoch.seconds + static_cast<std::int64_t>(taken));
    if (speed_ <= 0) step();
  }
  return taken;
}

void ServedPlant::publish() {
  const sim::Sensors& s = model_.sensors();
  for (const hal::Point& point : server_.map().points()) {
    // A point that the plant does not offer keeps what the site names as its first value.
    if (const auto value = sim::point_value(s, point.name)) server_.set(point.name, *value);
  }
  if (server_.map().find("clock_s") != nullptr) {
    server_.set("clock_s", static_cast<double>(model_.time().seconds - hal::clock_epoch.seconds));
  }
}

}  // namespace airside::tools
