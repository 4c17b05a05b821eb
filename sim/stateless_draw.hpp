#pragma once
// Random numbers addressed by place instead of drawn in turn: (seed, stream, place, slot) always gives the same
// number. A plant may then be copied, split or looked ahead without a generator's state to carry along.

#include <cmath>
#include <cstdint>
#include <string_view>

#include "airside/splitmix64.hpp"

namespace airside::sim {

/// 64 random bits of one address.  Cost: a few ns.
inline std::uint64_t draw_bits(std::uint64_t seed, std::uint64_t stream, std::uint64_t place, std::int64_t slot) {
  SplitMix64 outer(seed ^ (stream * 0xD1B54A32D192ED03u));
  SplitMix64 middle(outer.next() ^ (place * 0x8CB92BA72F3D8DD7u));
  SplitMix64 inner(middle.next() ^ (static_cast<std::uint64_t>(slot) * 0xABC98388FB8FAC03u));
  return inner.next();
}

/// A number of a name, by which things that have names are drawn: FNV-1a, the same on every machine.
constexpr std::uint64_t seed_of_name(std::string_view name) {
  std::uint64_t hash = 0xCBF29CE484222325u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return hash;
}

/// Uniform in [0, 1).
inline double draw_uniform(std::uint64_t seed, std::uint64_t stream, std::uint64_t place, std::int64_t slot) {
  return static_cast<double>(draw_bits(seed, stream, place, slot) >> 11) * (1.0 / 9007199254740992.0);
}

/// Nearly normal, mean 0, standard deviation 1, never beyond 3.5: the sum of four 16-bit uniforms.
/// Uses no library function, so the numbers are the same on every machine.
inline double draw_normal(std::uint64_t seed, std::uint64_t stream, std::uint64_t place, std::int64_t slot) {
  const std::uint64_t bits = draw_bits(seed, stream, place, slot);
  const auto sum =
      static_cast<double>((bits & 0xFFFFu) + ((bits >> 16) & 0xFFFFu) + ((bits >> 32) & 0xFFFFu) + (bits >> 48));
  return (sum / 65535.0 - 2.0) * 1.7320508075688772;
}

/// Smooth random course of time: normal numbers at multiples of `lattice_s`, linear between them.
inline double draw_course(std::uint64_t seed, std::uint64_t stream, std::uint64_t place, double time_s,
                          double lattice_s) {
  const double position = time_s / lattice_s;
  const double slot = std::floor(position);
  const double share = position - slot;
  const auto first = static_cast<std::int64_t>(slot);
  return (1.0 - share) * draw_normal(seed, stream, place, first) + share * draw_normal(seed, stream, place, first + 1);
}

}  // namespace airside::sim
