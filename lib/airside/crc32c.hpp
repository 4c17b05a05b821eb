#pragma once
// CRC-32C (Castagnoli), the checksum of blobs and durable records.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace airside {

namespace crc32c_detail {
constexpr std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c >> 1) ^ ((c & 1u) != 0 ? 0x82F63B78u : 0u);
    table[i] = c;
  }
  return table;
}
inline constexpr auto table = make_table();
}  // namespace crc32c_detail

/// CRC-32C of `bytes`, continuing from `crc` (0 to begin).  Cost: one table look-up a byte.
constexpr std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t crc = 0) {
  crc = ~crc;
  for (const std::byte b : bytes) {
    crc = (crc >> 8) ^ crc32c_detail::table[(crc ^ static_cast<std::uint32_t>(b)) & 0xFFu];
  }
  return ~crc;
}

}  // namespace airside
