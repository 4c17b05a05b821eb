#include "hal/points/word_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/points/register_codec.hpp"

namespace airside::hal {
namespace {

/// A reading so much smaller than what the point may hold is a float of exchanged words, not a measurement.
constexpr double least_share = 1e-9;

}  // namespace

bool makes_sense(const Point& point, std::span<const std::uint16_t> registers) {
  const Expected<double> value = decode(point, registers);
  if (!value) return false;
  if (point.type != PointType::float32) return true;
  const double raw = (*value - point.offset) / point.scale;
  const double most = std::max(std::abs(point.min), std::abs(point.max)) / std::abs(point.scale);
  return raw == 0.0 || std::abs(raw) >= least_share * std::min(most, 1e6);
}

OrderGuesses other_orders(const Point& point, std::span<const std::uint16_t> registers) {
  OrderGuesses found;
  if (point.is_bit()) return found;
  for (const Endian bytes : {Endian::big, Endian::little}) {
    for (const Endian words : {Endian::big, Endian::little}) {
      if (point.width() == 1 && words != point.word_order) continue;
      if (bytes == point.byte_order && words == point.word_order) continue;
      Point other = point;
      other.byte_order = bytes;
      other.word_order = words;
      const bool sane = makes_sense(other, registers);
      found.guess[static_cast<std::size_t>(found.count++)] = {
          bytes, words, sane ? *decode(other, registers) : std::numeric_limits<double>::quiet_NaN()};
    }
  }
  return found;
}

bool fits_other_order_only(const Point& point, std::span<const std::uint16_t> registers) {
  if (makes_sense(point, registers)) return false;
  const Expected<double> value = decode(point, registers);
  if (!value && value.error() == Fault::not_finite) return false;
  // Nor does what devices show for "no value" where the map names no sentinel.
  Point plain = point;
  plain.sentinels = 0;
  const Registers none = invalid_registers(plain);
  const auto used = registers.first(static_cast<std::size_t>(none.count));
  if (std::ranges::equal(used, none.used())) return false;
  if (std::ranges::all_of(used, [](std::uint16_t word) { return word == 0xFFFF; })) return false;
  const OrderGuesses others = other_orders(point, registers);
  return std::any_of(others.guess.begin(), others.guess.begin() + others.count,
                     [](const OrderGuess& g) { return std::isfinite(g.value); });
}

const char* order_text(const Point& point, Endian byte_order, Endian word_order) {
  const bool big = byte_order == Endian::big;
  if (point.is_bit()) return "bit";
  if (point.width() == 1) return big ? "AB" : "BA";
  if (word_order == Endian::big) return big ? "ABCD" : "BADC";
  return big ? "CDAB" : "DCBA";
}

}  // namespace airside::hal
