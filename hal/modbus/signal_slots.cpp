#include "hal/modbus/signal_slots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/points/point_names.hpp"

namespace airside::hal {
namespace {

constexpr std::size_t most_sensors = last_sensor - first_sensor + 1;

}  // namespace

void SignalSlots::add(const PointMap& map, const StandIns& stand_ins, SignalId id, std::vector<Point>& points) {
  Signal signal;
  signal.first_slot = static_cast<int>(points.size());
  if (const Point* one = map.find(point_name(id)); one != nullptr) {
    points.push_back(*one);
  } else if (id.kind == SignalKind::room_temp) {
    for (const Point* p : map.sensors(id.place)) points.push_back(*p);
  }
  signal.slots = static_cast<int>(points.size()) - signal.first_slot;
  signal.stand_in = stand_ins.of(id).value_or(std::numeric_limits<double>::quiet_NaN());
  signals_.push_back(signal);
}

double SignalSlots::value(int index, const ModbusPoller& poller) const {
  const Signal& signal = signals_[static_cast<std::size_t>(index)];
  if (signal.slots == 0) return signal.stand_in;
  std::array<double, most_sensors> good{};
  std::size_t count = 0;
  for (int slot = signal.first_slot; slot < signal.first_slot + signal.slots; ++slot) {
    if (const double v = poller.value(slot); std::isfinite(v)) good[count++] = v;
  }
  if (count == 0) return std::numeric_limits<double>::quiet_NaN();
  std::sort(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(count));
  return 0.5 * (good[(count - 1) / 2] + good[count / 2]);
}

Fault SignalSlots::fault(int index, const ModbusPoller& poller) const {
  const Signal& signal = signals_[static_cast<std::size_t>(index)];
  if (signal.slots == 0 || std::isfinite(value(index, poller))) return Fault::none;
  return poller.fault(signal.first_slot);
}

}  // namespace airside::hal
