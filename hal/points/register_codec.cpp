#include "hal/points/register_codec.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace airside::hal {
namespace {

std::uint16_t swapped(std::uint16_t word) { return static_cast<std::uint16_t>((word << 8) | (word >> 8)); }

std::uint16_t in_byte_order(const Point& point, std::uint16_t word) {
  return point.byte_order == Endian::big ? word : swapped(word);
}

Registers pack(const Point& point, std::uint32_t bits) {
  Registers r;
  r.count = point.width();
  if (r.count == 1) {
    const auto word = static_cast<std::uint16_t>(bits & 0xFFFFU);
    r.word[0] = point.is_bit() ? word : in_byte_order(point, word);
    return r;
  }
  const auto high = in_byte_order(point, static_cast<std::uint16_t>(bits >> 16));
  const auto low = in_byte_order(point, static_cast<std::uint16_t>(bits & 0xFFFFU));
  r.word = point.word_order == Endian::big ? std::array{high, low} : std::array{low, high};
  return r;
}

std::uint32_t unpack(const Point& point, std::span<const std::uint16_t> words) {
  if (point.is_bit()) return words[0];
  if (point.width() == 1) return in_byte_order(point, words[0]);
  const bool big = point.word_order == Endian::big;
  const std::uint32_t high = in_byte_order(point, words[big ? 0 : 1]);
  const std::uint32_t low = in_byte_order(point, words[big ? 1 : 0]);
  return high << 16 | low;
}

bool is_sentinel(const Point& point, std::uint32_t bits) {
  for (int i = 0; i < point.sentinels; ++i) {
    if (point.sentinel[static_cast<std::size_t>(i)] == bits) return true;
  }
  return false;
}

/// Bits of an integer `raw`, or out_of_range.
template <class Integer>
Expected<std::uint32_t> integer_bits(double raw) {
  using Limits = std::numeric_limits<Integer>;
  if (raw < static_cast<double>(Limits::min()) || raw > static_cast<double>(Limits::max())) {
    return tl::unexpected(Fault::out_of_range);
  }
  using Unsigned = std::make_unsigned_t<Integer>;
  return static_cast<Unsigned>(static_cast<Integer>(raw));
}

Expected<std::uint32_t> raw_bits(PointType type, double raw) {
  switch (type) {
    case PointType::coil:
    case PointType::discrete:
      if (std::round(raw) != 0.0 && std::round(raw) != 1.0) return tl::unexpected(Fault::out_of_range);
      return std::round(raw) == 1.0 ? 1U : 0U;
    case PointType::int16: return integer_bits<std::int16_t>(std::round(raw));
    case PointType::uint16: return integer_bits<std::uint16_t>(std::round(raw));
    case PointType::int32: return integer_bits<std::int32_t>(std::round(raw));
    case PointType::uint32: return integer_bits<std::uint32_t>(std::round(raw));
    case PointType::float32:
      if (std::abs(raw) > static_cast<double>(std::numeric_limits<float>::max())) {
        return tl::unexpected(Fault::out_of_range);
      }
      return std::bit_cast<std::uint32_t>(static_cast<float>(raw));
  }
  return tl::unexpected(Fault::out_of_range);
}

double raw_value(PointType type, std::uint32_t bits) {
  switch (type) {
    case PointType::coil:
    case PointType::discrete: return bits != 0 ? 1.0 : 0.0;
    case PointType::int16: return std::bit_cast<std::int16_t>(static_cast<std::uint16_t>(bits));
    case PointType::uint16:
    case PointType::uint32: return bits;
    case PointType::int32: return std::bit_cast<std::int32_t>(bits);
    case PointType::float32: return static_cast<double>(std::bit_cast<float>(bits));
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// The value as a person would write it, 22.4 and not 22.400000000000002 or 2.2200000286: to the millionth, which no
/// sensor has. What is tinier or larger than any signal stays.
double decimal(double value) {
  constexpr double millionths = 1e6;
  const double size = std::abs(value);
  return size >= 1e-3 && size < 1e9 ? std::round(value * millionths) / millionths : value;
}

}  // namespace

Expected<Registers> encode(const Point& point, double value) {
  if (!std::isfinite(value)) return tl::unexpected(Fault::not_finite);
  const double raw = (value - point.offset) / point.scale;
  if (!std::isfinite(raw)) return tl::unexpected(Fault::out_of_range);
  const Expected<std::uint32_t> bits = raw_bits(point.type, raw);
  if (!bits) return tl::unexpected(bits.error());
  if (is_sentinel(point, *bits)) return tl::unexpected(Fault::out_of_range);
  return pack(point, *bits);
}

Expected<double> decode(const Point& point, std::span<const std::uint16_t> registers) {
  if (registers.size() < static_cast<std::size_t>(point.width())) return tl::unexpected(Fault::out_of_range);
  const std::uint32_t bits = unpack(point, registers);
  if (is_sentinel(point, bits)) return tl::unexpected(Fault::not_finite);
  const double value = decimal(raw_value(point.type, bits) * point.scale + point.offset);
  if (!std::isfinite(value)) return tl::unexpected(Fault::not_finite);
  // A limit is a decimal of the file and the value came through the scale: half a raw step is the same
  // number.
  const double slack = point.type == PointType::float32 ? 0.0 : 0.5 * std::abs(point.scale);
  if (value < point.min - slack || value > point.max + slack) return tl::unexpected(Fault::out_of_range);
  return value;
}

double rounded(const Point& point, double value) {
  const Expected<Registers> registers = encode(point, value);
  if (!registers) return std::numeric_limits<double>::quiet_NaN();
  return decode(point, registers->used()).value_or(std::numeric_limits<double>::quiet_NaN());
}

Registers invalid_registers(const Point& point) {
  if (point.sentinels > 0) return pack(point, point.sentinel[0]);
  switch (point.type) {
    case PointType::coil:
    case PointType::discrete: return pack(point, 0);
    case PointType::int16: return pack(point, 0x8000U);
    case PointType::uint16: return pack(point, 0xFFFFU);
    case PointType::int32: return pack(point, 0x80000000U);
    case PointType::uint32: return pack(point, 0xFFFFFFFFU);
    case PointType::float32: return pack(point, 0x7FC00000U);
  }
  return pack(point, 0);
}

}  // namespace airside::hal
