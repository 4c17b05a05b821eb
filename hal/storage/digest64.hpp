#pragma once
// The checksum of durable records: 64 bits, so that torn and rotten records are distinguished from whole ones.
// It guards against accidents, not against forgers; signatures do that.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace airside::hal {

/// h = mix(h ^ word) over 8-byte little-endian words, the last one zero-padded, then the length.
/// Each step is a bijection of word and of h, so any change within one word changes the digest.
/// Cost: one 64-bit multiplication a word.
inline std::uint64_t digest64(std::span<const std::byte> bytes, std::uint64_t seed = 0) {
  static_assert(std::endian::native == std::endian::little, "records are little-endian");
  constexpr std::uint64_t odd = 0x9FB21C651E98DF25u;
  std::uint64_t h = seed ^ 0x2545F4914F6CDD1Du;
  const auto absorb = [&h](std::uint64_t word) { h = std::rotl((h ^ word) * odd, 29); };
  std::size_t at = 0;
  for (; at + 8 <= bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, 8);
    absorb(word);
  }
  if (at < bytes.size()) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, bytes.size() - at);
    absorb(word);
  }
  absorb(bytes.size());
  h ^= h >> 32;
  h *= 0xD6E8FEB86659FD93u;
  h ^= h >> 32;
  return h;
}

}  // namespace airside::hal
