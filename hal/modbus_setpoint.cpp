#include "hal/modbus_setpoint.hpp"

#include <algorithm>
#include <cmath>

#include "hal/modbus_wire.hpp"
#include "hal/plant_clock.hpp"
#include "hal/register_codec.hpp"

namespace airside::hal {
namespace {

constexpr std::uint8_t device_failure = 4;

double half_step(const Point& p) { return p.type == PointType::float32 ? 1e-6 : 0.5 * std::abs(p.scale); }

}  // namespace

ModbusSetpoint::ModbusSetpoint(const PointMap& map, std::string_view name, double settle_s)
    : point_(map.at(name)), settle_s_(settle_s), function_(point_.fc_write) {
  if (!point_.writable()) {
    throw InputError(map.file() + ": " + point_.name, "a read-only point", "a writable one",
                     "give write_policy and fc_write");
  }
  if (!(settle_s >= 0 && settle_s <= 10)) {
    throw InputError("modbus settle_s", std::to_string(settle_s), "0 to 10 s", "correct it in the site file");
  }
  has_readback_ = point_.readback != "none";
  if (has_readback_) readback_ = point_.readback == "self" ? point_ : map.at(point_.readback);
}

bool ModbusSetpoint::same(double a, double b) const {
  return std::abs(a - b) <= std::max(half_step(point_), has_readback_ ? half_step(readback_) : 0.0);
}

Expected<double> ModbusSetpoint::read_back(ModbusLink& link) const {
  std::array<std::uint16_t, 2> words{};
  const std::span<std::uint16_t> used(words.data(), static_cast<std::size_t>(readback_.width()));
  if (!link.read(readback_.fc, readback_.addr, used)) return tl::unexpected(Fault::not_applied);
  return decode(readback_, used);
}

LinkResult<void> ModbusSetpoint::send(ModbusLink& link, std::span<const std::uint16_t> words) {
  ++writes_;
  LinkResult<void> sent = link.write(function_, point_.addr, words);
  // 1 to 4: the device understood and refused; some do so for the function that they do not like.
  const bool refused = !sent && sent.error().exception >= 1 && sent.error().exception <= device_failure;
  if (!refused || alternate_tried_ || point_.fc != 3 || point_.width() != 1) return sent;
  alternate_tried_ = true;
  const int other = function_ == 6 ? 16 : 6;
  sent = link.write(other, point_.addr, words);
  if (sent) function_ = other;
  return sent;
}

Expected<double> ModbusSetpoint::write(ModbusLink& link, double value, std::uint64_t generation) {
  const Expected<Registers> registers = encode(point_, value);
  if (!registers) return tl::unexpected(Fault::not_applied);
  const Expected<double> wish = decode(point_, registers->used());
  if (!wish) return tl::unexpected(Fault::not_applied);

  if (point_.write_policy == WritePolicy::on_change) {
    if (has_readback_) {
      // What stands there now, not what was written once: the device may have restarted or been overridden.
      const Expected<double> standing = read_back(link);
      if (!standing && !link.connected()) return tl::unexpected(Fault::not_applied);
      if (standing && same(*standing, *wish)) return *standing;
    } else if (last_generation_ == link.generation() && last_written_ == *wish) {
      return *wish;
    }
  }
  if (link.connected() && link.generation() != generation) return tl::unexpected(Fault::not_applied);
  if (const LinkResult<void> sent = send(link, registers->used()); !sent) {
    last_written_ = std::numeric_limits<double>::quiet_NaN();
    const bool answered = sent.error().error == LinkError::exception_answer;
    return tl::unexpected(answered ? Fault::write_refused : Fault::not_applied);
  }
  last_written_ = *wish;
  last_generation_ = link.generation();
  if (!has_readback_) return *wish;

  const std::int64_t settled_ns = monotonic_ns() + to_ns(settle_s_);
  while (true) {
    const Expected<double> taken = read_back(link);
    if (taken && same(*taken, *wish)) return *taken;
    if (monotonic_ns() >= settled_ns || !link.connected()) {
      return taken ? taken : tl::unexpected(Fault::not_applied);
    }
    sleep_until_ns(monotonic_ns() + 20'000'000, {});
  }
}

}  // namespace airside::hal
