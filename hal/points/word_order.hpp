#pragma once
// Byte and word orders of a value, and which of them make sense: people's maps get them wrong more often than anything
// else. Nothing here changes an order; a person does.

#include <array>
#include <cstdint>
#include <span>

#include "hal/points/point_map.hpp"

namespace airside::hal {

/// Whether the registers make sense in the point's own order: within its limits, and neither a float that is next to
/// nothing beside them nor a sentinel. Exchanged words are often in range as such a float.
bool makes_sense(const Point& point, std::span<const std::uint16_t> registers);

/// The same registers in another order.
struct OrderGuess {
  Endian byte_order, word_order;
  double value;  ///< NaN where it makes no sense
};
/// The orders that differ from the point's: three for a 32-bit type, one for 16 bits (`count`), none for a bit.
struct OrderGuesses {
  std::array<OrderGuess, 3> guess;
  int count = 0;
};
OrderGuesses other_orders(const Point& point, std::span<const std::uint16_t> registers);

/// Whether the point's order makes no sense and another does. A sentinel or NaN says nothing about orders.
/// Cost: up to 4 decodings; no heap.
bool fits_other_order_only(const Point& point, std::span<const std::uint16_t> registers);

/// `ABCD`, `CDAB`, `BADC`, `DCBA` of 32 bits, `AB`, `BA` of 16, as manuals call them.
const char* order_text(const Point& point, Endian byte_order, Endian word_order);

}  // namespace airside::hal
