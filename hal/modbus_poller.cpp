#include "hal/modbus_poller.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "hal/register_codec.hpp"

namespace airside::hal {
namespace {

constexpr std::uint8_t illegal_address = 2, illegal_value = 3;

}  // namespace

ModbusPoller::ModbusPoller(const std::vector<Point>& points)
    : points_(points), value_(points.size()), fault_(points.size()), words_(MODBUS_MAX_READ_BITS) {
  std::vector<int> order(points_.size());
  std::iota(order.begin(), order.end(), 0);
  const auto point = [&](int slot) -> const Point& { return points_[static_cast<std::size_t>(slot)]; };
  std::ranges::sort(order, [&](int a, int b) {
    return std::pair{point(a).fc, point(a).addr} < std::pair{point(b).fc, point(b).addr};
  });
  for (const int slot : order) {
    const Point& p = point(slot);
    const int limit = p.is_bit() ? MODBUS_MAX_READ_BITS : MODBUS_MAX_READ_REGISTERS;
    const bool follows = !groups_.empty() && groups_.back().fc == p.fc &&
                         groups_.back().addr + groups_.back().count == p.addr &&
                         groups_.back().count + p.width() <= limit;
    if (!follows) groups_.push_back({p.fc, p.addr, 0, {}});
    groups_.back().count += p.width();
    groups_.back().slots.push_back(slot);
  }
  invalidate(Fault::no_reading);
}

void ModbusPoller::invalidate(Fault fault) {
  std::ranges::fill(value_, std::numeric_limits<double>::quiet_NaN());
  std::ranges::fill(fault_, fault);
}

void ModbusPoller::take(int slot, std::span<const std::uint16_t> words) {
  const auto i = static_cast<std::size_t>(slot);
  const Expected<double> decoded = decode(points_[i], words);
  value_[i] = decoded.value_or(std::numeric_limits<double>::quiet_NaN());
  fault_[i] = decoded ? Fault::none : decoded.error();
}

LinkResult<void> ModbusPoller::read_alone(ModbusLink& link, int slot) {
  const Point& p = points_[static_cast<std::size_t>(slot)];
  const std::span<std::uint16_t> words(words_.data(), static_cast<std::size_t>(p.width()));
  const LinkResult<void> got = link.read(p.fc, p.addr, words);
  if (got)
    take(slot, words);
  else if (got.error().error == LinkError::exception_answer)
    last_exception_ = got.error().exception;
  return got;
}

LinkResult<void> ModbusPoller::read_group(ModbusLink& link, Group& group) {
  if (!group.split) {
    const std::span<std::uint16_t> words(words_.data(), static_cast<std::size_t>(group.count));
    const LinkResult<void> got = link.read(group.fc, group.addr, words);
    if (got) {
      for (const int slot : group.slots) {
        take(slot, words.subspan(static_cast<std::size_t>(points_[static_cast<std::size_t>(slot)].addr - group.addr)));
      }
      return {};
    }
    if (got.error().error != LinkError::exception_answer) return got;
    last_exception_ = got.error().exception;
    const bool divisible = group.slots.size() > 1;
    group.split = divisible && (last_exception_ == illegal_address || last_exception_ == illegal_value);
    if (!group.split || last_exception_ == illegal_value) return {};
  }
  for (const int slot : group.slots) {
    const LinkResult<void> got = read_alone(link, slot);
    if (!got && got.error().error != LinkError::exception_answer) return got;
  }
  return {};
}

LinkResult<void> ModbusPoller::poll(ModbusLink& link) {
  invalidate(Fault::no_reading);
  last_exception_ = 0;
  if (generation_ != link.generation()) {  // perhaps another device, which takes whole groups
    generation_ = link.generation();
    for (Group& group : groups_) group.split = false;
  }
  for (Group& group : groups_) {
    const LinkResult<void> read = read_group(link, group);
    if (!read && read.error().error == LinkError::backing_off && last_exception_ != 0) return {};
    if (!read) {
      invalidate(Fault::no_reading);
      return read;
    }
  }
  return {};
}

}  // namespace airside::hal
