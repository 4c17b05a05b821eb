#include "hal/modbus/poller.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "hal/points/register_codec.hpp"
#include "hal/points/word_order.hpp"

namespace airside::hal {
namespace {

constexpr std::uint8_t illegal_address = 2, illegal_value = 3, device_busy = 6;

int most_in_a_request(int fc) { return fc <= 2 ? MODBUS_MAX_READ_BITS : MODBUS_MAX_READ_REGISTERS; }

}  // namespace

ModbusPoller::ModbusPoller(const std::vector<Point>& points)
    : points_(points),
      value_(points.size()),
      fault_(points.size()),
      order_doubt_(points.size()),
      words_(MODBUS_MAX_READ_BITS) {
  std::vector<int> order(points_.size());
  std::iota(order.begin(), order.end(), 0);
  const auto point = [&](int slot) -> const Point& { return points_[static_cast<std::size_t>(slot)]; };
  std::ranges::sort(order, [&](int a, int b) {
    return std::pair{point(a).fc, point(a).addr} < std::pair{point(b).fc, point(b).addr};
  });
  for (const int slot : order) {
    const Point& p = point(slot);
    const int limit = most_in_a_request(p.fc);
    const bool follows = !groups_.empty() && groups_.back().fc == p.fc &&
                         groups_.back().addr + groups_.back().count == p.addr &&
                         groups_.back().count + p.width() <= limit;
    if (!follows) groups_.push_back({p.fc, p.addr, 0, {}, limit});
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
  const Point& p = points_[i];
  const Expected<double> decoded = decode(p, words);
  value_[i] = decoded.value_or(std::numeric_limits<double>::quiet_NaN());
  fault_[i] = decoded ? Fault::none : decoded.error();
  if (p.width() < 2) return;
  // Exchanged words often look like a number in range, only a tiny one, so one reading says little either way.
  std::uint8_t& doubt = order_doubt_[i];
  if (fits_other_order_only(p, words)) {
    doubt = std::min<std::uint8_t>(static_cast<std::uint8_t>(doubt + 2), order_doubt_limit);
  } else if (doubt > 0 && decoded) {
    --doubt;
  }
  if (doubt < order_is_doubted || !decoded) return;
  value_[i] = std::numeric_limits<double>::quiet_NaN();
  fault_[i] = Fault::out_of_range;
}

const Point* ModbusPoller::order_doubted() const {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (order_doubt_[i] >= order_is_doubted) return &points_[i];
  }
  return nullptr;
}

void ModbusPoller::take_exception(std::uint8_t code) {
  last_exception_ = code;
  map_refused_ = map_refused_ || (code >= 1 && code <= illegal_value);
  gateway_failed_ = gateway_failed_ || code == 0 || code > device_busy;
}

LinkResult<void> ModbusPoller::read_group(ModbusLink& link, Group& group) {
  const auto point = [&](std::size_t i) -> const Point& { return points_[static_cast<std::size_t>(group.slots[i])]; };
  std::size_t next = 0;
  while (next < group.slots.size()) {
    std::size_t end = next;
    int count = 0;
    while (end < group.slots.size() && (end == next || count + point(end).width() <= group.at_most)) {
      count += point(end).width();
      ++end;
    }
    const int addr = point(next).addr;
    const std::span<std::uint16_t> words(words_.data(), static_cast<std::size_t>(count));
    const LinkResult<void> got = link.read(group.fc, addr, words);
    if (!got && got.error().error != LinkError::exception_answer) return got;
    if (got) {
      for (std::size_t i = next; i < end; ++i) {
        take(group.slots[i], words.subspan(static_cast<std::size_t>(point(i).addr - addr)));
      }
      next = end;
      continue;
    }
    take_exception(got.error().exception);
    const bool divisible = end - next > 1;
    if (divisible && last_exception_ == illegal_address) {
      group.at_most = 1;
    } else if (divisible && last_exception_ == illegal_value) {
      group.at_most = std::max(1, count / 2);
    } else {
      next = end;
    }
  }
  return {};
}

LinkResult<void> ModbusPoller::poll(ModbusLink& link) {
  invalidate(Fault::no_reading);
  last_exception_ = 0;
  map_refused_ = gateway_failed_ = false;
  LinkResult<void> read;
  for (Group& group : groups_) {
    read = read_group(link, group);
    if (!read) break;
  }
  if (!read && read.error().error == LinkError::backing_off && last_exception_ != 0) read = {};
  if (!read) invalidate(Fault::no_reading);
  if (generation_ != 0 && generation_ != link.generation()) {  // perhaps another device, which takes whole groups
    for (Group& group : groups_) group.at_most = most_in_a_request(group.fc);
  }
  generation_ = link.generation();
  return read;
}

}  // namespace airside::hal
