#pragma once
// An AHU and its rooms behind Modbus, as lib's Plant: the same loop drives it and a simulation.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <variant>

#include "airside/command.hpp"
#include "airside/plant.hpp"
#include "airside/reading.hpp"
#include "airside/signals.hpp"
#include "hal/modbus/link.hpp"
#include "hal/modbus/plant_clock.hpp"
#include "hal/modbus/poller.hpp"
#include "hal/modbus/setpoint.hpp"
#include "hal/modbus/signal_slots.hpp"
#include "hal/points/point_map.hpp"
#include "hal/points/register_codec.hpp"

namespace airside::hal {

struct ModbusPlantOptions {
  double settle_s = 0.0;  ///< how long the setpoint's read-back may lag behind the write, s
  /// Local standard time, s east of UTC, where the map has no clock_s; without it the machine's time zone.
  std::optional<int> utc_offset_s;
  StandIns stand_ins{};  ///< read in the place of signals that the map lacks
};

/// The age of readings as the device's own heartbeat tells it.
class HeartbeatAge {
 public:
  /// s since `beat` last changed. NaN beats count as unchanged.
  double update(CivilTime now, double beat) {
    if (beat == beat && beat != last_) {
      last_ = beat;
      changed_ = now;
    }
    return changed_ ? static_cast<double>((now.seconds - changed_->seconds)) : 0.0;
  }

 private:
  double last_ = std::numeric_limits<double>::quiet_NaN();
  std::optional<CivilTime> changed_;
};

template <Topology T>
class ModbusPlant {
 public:
  /// Keeps `link`, which must outlive it.
  /// Errors: InputError where the map does not fit the topology.
  ModbusPlant(const PointMap& map, ModbusLink& link, const ModbusPlantOptions& options = {},
              const Shape& site = capacity_of<T>())
      : link_(&link),
        site_(site),
        setpoint_(map, "setpoint", options.settle_s),
        clock_({}, options.utc_offset_s),
        poller_(points_to_read(map, options.stand_ins)),
        fingerprint_(map.fingerprint()) {
    if (const Point* beat = map.find("heartbeat"); beat != nullptr && beat->writable()) {
      heartbeat_.emplace(map, "heartbeat");
    }
    if (const Point* identity = map.find("map_fingerprint"); identity != nullptr) {
      identity_ = *identity;
      identity_value_ = map.told_fingerprint();
    }
  }

  /// Readings are of this clock's time, where the map has no clock_s.
  void follow(const SystemClock& clock) { clock_ = clock; }

  /// All signals now; one that the device refuses, or that is a sentinel or out of its limits, is NaN.
  /// Errors: no_reading where the link failed; other_device where the map's fingerprint is not the device's.
  /// Cost: one exchange a block of registers, one more after a new connection; no heap.
  Expected<Reading<T>> sense() {
    setpoint_.saw(std::numeric_limits<double>::quiet_NaN());
    const LinkResult<void> polled = poller_.poll(*link_);
    last_fault_ = polled ? std::nullopt : std::optional(polled.error());
    if (!polled) {
      ++lost_polls_;
      return tl::unexpected(Fault::no_reading);
    }
    if (!identified()) return tl::unexpected(other_device_ ? Fault::other_device : Fault::no_reading);
    Reading<T> reading;
    reading.contact = link_->generation() + lost_polls_;
    for (int i = 0; i < Layout<T>::signals; ++i) reading.value[i] = signals_.value(i, poller_);
    if (setpoint_slot_ >= 0) reading.setpoint_degc = poller_.value(setpoint_slot_);
    setpoint_.saw(reading.setpoint_degc);
    if (supply_slot_ >= 0) reading.supply_temp_degc = poller_.value(supply_slot_);
    if (flow_slot_ >= 0) reading.flows = poller_.value(flow_slot_);
    if (occupied_slot_ >= 0) reading.occupied = poller_.value(occupied_slot_);
    if (supply_flow_slot_ >= 0) reading.supply_flow_m3s = poller_.value(supply_flow_slot_);
    for (std::size_t i = 0; i < damper_slots_.size(); ++i) {
      const auto room = static_cast<Eigen::Index>(i);
      if (damper_slots_[i] >= 0) reading.damper(room) = poller_.value(damper_slots_[i]);
      if (zone_setpoint_slots_[i] >= 0) reading.zone_setpoint_degc(room) = poller_.value(zone_setpoint_slots_[i]);
      if (zone_heating_slots_[i] >= 0) reading.zone_heating_setpoint_degc(room) = poller_.value(zone_heating_slots_[i]);
    }
    reading.time = clock_.now();
    if (clock_slot_ >= 0) {
      if (poller_.fault(clock_slot_) != Fault::none) return tl::unexpected(Fault::no_reading);
      reading.time.seconds = clock_epoch.seconds + static_cast<std::int64_t>(poller_.value(clock_slot_));
    }
    if (beat_slot_ >= 0) reading.age_s.setConstant(age_.update(reading.time, poller_.value(beat_slot_)));
    return reading;
  }

  /// Writes the setpoint as its write_policy says and reads it back: a device that clamps shows in Applied.
  /// Errors: as ModbusSetpoint::write(); other_device, and not_applied on a connection whose registers have not been
  /// read yet: nothing is written before. Cost: at most 4 exchanges; no heap.
  Expected<Applied> actuate(const Command& command) {
    if (other_device_) return tl::unexpected(Fault::other_device);
    if (identified_generation_ != link_->generation()) return tl::unexpected(Fault::not_applied);
    const Expected<double> taken = setpoint_.write(*link_, command.setpoint_degc(), identified_generation_);
    if (!taken) return tl::unexpected(taken.error());
    return Applied{*taken};
  }

  /// For the checkout of points: the setpoint one step aside of its current value, and back, each read back.
  /// Errors: in the result: as sense() and ModbusSetpoint::check().  Cost: sense(), and at most 8 exchanges; no heap.
  WriteCheck check_write(double step, double min, double max) {
    const Expected<Reading<T>> sensed = sense();
    if (!sensed) return {.fault = sensed.error()};
    return setpoint_.check(*link_, sensed->setpoint_degc, step, min, max, identified_generation_);
  }

  /// Counts the heartbeat up where the map has a writable one; without it the AHU takes over by itself.
  /// False: it could not be written. Cost: at most 3 exchanges.
  bool beat() {
    if (!heartbeat_) return true;
    if (other_device_ || identified_generation_ != link_->generation()) return false;
    heartbeat_->saw(beat_value_);  // its steps need no care
    const double next = beat_value_ >= heartbeat_->point().max ? heartbeat_->point().min : beat_value_ + 1;
    if (!heartbeat_->write(*link_, next, identified_generation_)) return false;
    beat_value_ = next;
    return true;
  }

  /// Where no heartbeat does it: one read, so that a device that ends idle connections keeps this one. On a new one
  /// nobody knows who has written, and a person's setpoint would pass unseen. Cost: an exchange; on a serial line none.
  void keep_alive() {
    const Point* shown = setpoint_.readback();
    if (heartbeat_ || shown == nullptr || !in_touch() || !std::holds_alternative<TcpAddress>(link_->settings().address))
      return;
    std::array<std::uint16_t, 2> words{};
    (void)link_->read(shown->fc, shown->addr, {words.data(), static_cast<std::size_t>(shown->width())});
  }

  /// Whether the connection stands on which the registers were read and the device identified.
  bool in_touch() const { return link_->connected() && identified_generation_ == link_->generation(); }
  /// Why signal `index` of the last reading is NaN; none where it is not.
  Fault signal_fault(int index) const { return signals_.fault(index, poller_); }
  /// Why the last sense() failed.
  const std::optional<LinkFault>& last_fault() const { return last_fault_; }
  std::uint8_t last_exception() const { return poller_.last_exception(); }
  /// What the last sense() found wrong, as ModbusPoller tells it: alarms for whoever made the map or keeps the bus.
  bool map_refused() const { return poller_.map_refused(); }
  bool gateway_failed() const { return poller_.gateway_failed(); }
  const Point* order_doubted() const { return poller_.order_doubted(); }
  std::uint64_t setpoint_writes() const { return setpoint_.writes(); }
  std::uint64_t map_fingerprint() const { return fingerprint_; }
  /// Whether the device at the other end tells another fingerprint than the point map's.
  bool other_device() const { return other_device_; }
  const ModbusLink& link() const { return *link_; }

 private:
  /// Compares the device's fingerprint with the map's, once a connection. A map without the point has nothing to
  /// compare.
  bool identified() {
    if (identified_generation_ == link_->generation()) return !other_device_;
    if (identity_) {
      std::array<std::uint16_t, 2> words{};
      const std::span<std::uint16_t> used(words.data(), static_cast<std::size_t>(identity_->width()));
      const LinkResult<void> read = link_->read(identity_->fc, identity_->addr, used);
      // 1 to 3: it has no such register. Whatever else came in the place of an answer, it is asked again next time.
      const bool has_none = !read && read.error().exception >= 1 && read.error().exception <= 3;
      if (!read && !has_none) return false;
      const Expected<double> identity = read ? decode(*identity_, used) : tl::unexpected(Fault::no_reading);
      other_device_ = !identity || *identity != identity_value_;
    }
    identified_generation_ = link_->generation();
    return !other_device_;
  }

  /// Sensors of the signals in the order of Layout<T>, then whatever else the map has of setpoint, supply_temp, side
  /// signals, clock, heartbeat.
  std::vector<Point> points_to_read(const PointMap& map, const StandIns& stand_ins) {
    map.check_topology(site_.vavs, site_.fcus, site_.powers, stand_ins);
    std::vector<Point> points;
    for (int i = 0; i < Layout<T>::signals; ++i) {
      signals_.add(map, is_present<T>(site_, i) ? stand_ins : StandIns{}, signal_id<T>(i), points);
    }
    const auto add = [&](const Point* point) {
      if (point == nullptr) return -1;
      points.push_back(*point);
      return static_cast<int>(points.size()) - 1;
    };
    setpoint_slot_ = add(setpoint_.readback());
    supply_slot_ = add(map.find("supply_temp"));
    flow_slot_ = add(map.find("ahu_on"));
    occupied_slot_ = add(map.find("occupied"));
    supply_flow_slot_ = add(map.find("supply_flow"));
    for (std::size_t i = 0; i < damper_slots_.size(); ++i) {
      damper_slots_[i] = add(map.find("damper_" + std::to_string(i + 1)));
      zone_setpoint_slots_[i] = add(map.find("zone_setpoint_" + std::to_string(i + 1)));
      zone_heating_slots_[i] = add(map.find("zone_heating_setpoint_" + std::to_string(i + 1)));
    }
    clock_slot_ = add(map.find("clock_s"));
    const Point* beat = map.find("device_heartbeat");
    const Point* only_read = map.find("heartbeat");
    if (beat == nullptr && only_read != nullptr && !only_read->writable()) beat = only_read;
    beat_slot_ = add(beat);
    return points;
  }

  ModbusLink* link_;
  Shape site_;
  int setpoint_slot_ = -1, supply_slot_ = -1, flow_slot_ = -1, clock_slot_ = -1, beat_slot_ = -1;
  int occupied_slot_ = -1, supply_flow_slot_ = -1;
  std::array<int, static_cast<std::size_t>(Layout<T>::rooms)> damper_slots_{}, zone_setpoint_slots_{},
      zone_heating_slots_{};
  SignalSlots signals_;
  ModbusSetpoint setpoint_;
  SystemClock clock_;
  ModbusPoller poller_;
  std::uint64_t fingerprint_;
  std::optional<ModbusSetpoint> heartbeat_;
  HeartbeatAge age_;
  double beat_value_ = 0;
  std::optional<LinkFault> last_fault_;
  std::optional<Point> identity_;
  double identity_value_ = 0;
  bool other_device_ = false;
  std::uint64_t identified_generation_ = 0;
  std::uint64_t lost_polls_ = 0;
};

static_assert(Plant<ModbusPlant<FiveZone>, FiveZone>);

}  // namespace airside::hal
