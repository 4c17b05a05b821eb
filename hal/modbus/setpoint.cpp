#include "hal/modbus/setpoint.hpp"

#include <algorithm>
#include <cmath>

#include "hal/modbus/plant_clock.hpp"
#include "hal/modbus/wire.hpp"
#include "hal/points/register_codec.hpp"

namespace airside::hal {
namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

/// 1 to 4: the device understood and refused. Others come from gateways, or of a device that is not done yet.
bool is_refusal(const LinkResult<void>& sent) {
  return !sent && sent.error().exception >= 1 && sent.error().exception <= 4;
}

/// A write without a clear answer may have been taken all the same.
bool may_have_arrived(const LinkResult<void>& sent) {
  if (sent) return true;
  switch (sent.error().error) {
    case LinkError::backing_off:
    case LinkError::connect_failed:
    case LinkError::bad_request:
    case LinkError::other_connection: return false;
    case LinkError::exception_answer: return !is_refusal(sent);
    default: return true;
  }
}

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

LinkResult<void> ModbusSetpoint::send(ModbusLink& link, std::span<const std::uint16_t> words,
                                      std::uint64_t generation) {
  ++writes_;
  const LinkResult<void> sent = link.write(function_, point_.addr, words, generation);
  // Some devices refuse for the function that they do not like.
  if (!is_refusal(sent) || alternate_tried_ || point_.fc != 3 || point_.width() != 1) return sent;
  alternate_tried_ = true;
  const int other = function_ == 6 ? 16 : 6;
  const LinkResult<void> again = link.write(other, point_.addr, words, generation);
  if (again) function_ = other;
  return again || may_have_arrived(again) ? again : sent;
}

void ModbusSetpoint::saw(double standing) {
  seen_ = std::isfinite(standing);
  if (!seen_) return;
  if (!same(standing, sent_))
    sent_ = no_value;  // an external override, or the device's own value: not for this one to repeat
  unsettled_ = no_value;
}

Expected<double> ModbusSetpoint::write(ModbusLink& link, double value, std::uint64_t generation) {
  const Expected<double> taken = try_to_write(link, value, generation);
  told_ = taken.has_value();
  if (told_) sent_ = same(*taken, last_written_) ? *taken : no_value;
  if (told_) unsettled_ = no_value;
  return taken;
}

WriteCheck ModbusSetpoint::check(ModbusLink& link, double standing, double step, double min, double max,
                                 std::uint64_t generation) {
  WriteCheck check;
  check.before = standing;
  if (!same(standing, sent_)) {
    check.fault = Fault::released;
    return check;
  }
  const double moved_k = std::max(step, 2 * half_step(point_));
  check.sent = standing + moved_k <= max ? standing + moved_k : standing - moved_k;
  if (!(check.sent >= min && check.sent <= max)) {
    check.fault = Fault::out_of_range;
    return check;
  }
  const Expected<double> taken = write(link, check.sent, generation);
  // After a write without an answer too: it may have arrived.
  const Expected<double> restored = write(link, standing, generation);
  if (restored) check.restored = *restored;
  if (!restored) check.fault = restored.error();
  if (restored && !same(*restored, standing)) check.fault = Fault::not_applied;
  if (taken) check.taken = *taken;
  if (taken && !same(*taken, check.sent)) check.fault = Fault::not_applied;
  if (!taken) check.fault = taken.error();
  return check;
}

Expected<double> ModbusSetpoint::try_to_write(ModbusLink& link, double value, std::uint64_t generation) {
  const auto refused = tl::unexpected(Fault::not_applied);
  Expected<Registers> registers = encode(point_, value);
  if (!registers) return refused;
  Expected<double> wish = decode(point_, registers->used());
  if (!wish) return refused;

  const bool known = told_ || seen_;
  const bool on_change = point_.write_policy == WritePolicy::on_change;
  if (has_readback_ && (on_change || !known)) {
    // What stands there now, not what was written once: the device may have restarted or been overridden.
    const Expected<double> standing = read_back(link);
    if (link.connected() && link.generation() != generation) return refused;
    if (standing && (!known || same(*standing, *wish))) return *standing;
    if (!standing && standing.error() == Fault::out_of_range) return tl::unexpected(Fault::out_of_range);
    const bool unread = !standing && standing.error() == Fault::not_applied;
    if (unread && !link.connected()) return refused;
    if (unread && !known && !std::isfinite(unsettled_) && !std::isfinite(sent_)) return refused;
  } else if (on_change && known && last_generation_ == link.generation() && last_written_ == *wish) {
    return *wish;
  }
  const double instead = std::isfinite(unsettled_) ? unsettled_ : sent_;
  if (!known && std::isfinite(instead)) {
    registers = encode(point_, instead);
    if (!registers) return refused;
    wish = instead;
  }
  if (const LinkResult<void> sent = send(link, registers->used(), generation); !sent) {
    last_written_ = no_value;
    if (may_have_arrived(sent)) unsettled_ = *wish;
    return tl::unexpected(is_refusal(sent) ? Fault::write_refused : Fault::not_applied);
  }
  last_written_ = *wish;
  last_generation_ = link.generation();
  return has_readback_ ? confirm(link, *wish) : wish;
}

Expected<double> ModbusSetpoint::confirm(ModbusLink& link, double wish) {
  const std::int64_t settled_ns = monotonic_ns() + to_ns(settle_s_);
  while (true) {
    const Expected<double> taken = read_back(link);
    if (taken && same(*taken, wish)) return taken;
    if (monotonic_ns() >= settled_ns || !link.connected()) {
      if (!taken) unsettled_ = wish;
      const bool impossible = !taken && taken.error() == Fault::out_of_range;
      return taken ? taken : tl::unexpected(impossible ? Fault::out_of_range : Fault::not_applied);
    }
    sleep_until_ns(monotonic_ns() + 20'000'000, {});
  }
}

}  // namespace airside::hal
