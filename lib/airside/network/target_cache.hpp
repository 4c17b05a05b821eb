#pragma once
// Targets Y of transitions, kept as long as the target network and the transition are the same: between two changes of
// the target a batch is drawn a hundred times from the same memory.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace airside {

/// 64 bits that stand for numbers, bit for bit; four sums side by side, since one would wait for each multiplication.
/// Shape: an odd half of a word at the end counts as a word.  Cost: two multiplications for 8 bytes.
template <class Scalar>
std::uint64_t fingerprint(std::span<const Scalar> numbers, std::uint64_t seed) {
  constexpr std::size_t in_word = sizeof(std::uint64_t) / sizeof(Scalar);
  constexpr std::uint64_t odd = 0x9E3779B97F4A7C15u;
  std::array<std::uint64_t, 4> h{seed, ~seed, seed * odd, seed + odd};
  const auto absorb = [](std::uint64_t& into, const Scalar* from, std::size_t count) {
    std::uint64_t word = 0;
    std::memcpy(&word, from, count * sizeof(Scalar));
    word *= odd;
    word ^= word >> 32;  // else a change of a sign alone would reach the next word as one bit
    into = std::rotl((into ^ word) * odd, 29);
  };
  std::size_t at = 0;
  for (; at + 4 * in_word <= numbers.size(); at += 4 * in_word)
    for (std::size_t lane = 0; lane < 4; ++lane) absorb(h[lane], numbers.data() + at + lane * in_word, in_word);
  for (; at < numbers.size(); at += in_word) absorb(h[0], numbers.data() + at, std::min(in_word, numbers.size() - at));
  std::uint64_t all = numbers.size();
  for (const std::uint64_t lane : h) all = std::rotl((all ^ lane) * odd, 31);
  return all ^ (all >> 32);
}

/// Shape: a place for each of Slots transitions, Rooms numbers each. Slots = 0 keeps nothing.
/// Errors: none that are seen; two transitions in one place with the same 64 bits would share a target.
template <class Scalar, int Rooms, int Slots>
class TargetCache {
 public:
  static constexpr int slots = Slots;

  /// Y of the transition in `slot` whose fingerprint, with that of the target network, is `key`; nullptr: not known.
  const Scalar* find(std::uint32_t slot, std::uint64_t key) const {
    if (slot >= Slots || keys_[slot] != key) return nullptr;
    return targets_.data() + slot * static_cast<std::size_t>(Rooms);
  }
  void keep(std::uint32_t slot, std::uint64_t key, const Scalar* y) {
    if (slot >= Slots) return;
    keys_[slot] = key;
    std::copy_n(y, Rooms, targets_.data() + slot * static_cast<std::size_t>(Rooms));
  }

 private:
  std::array<std::uint64_t, static_cast<std::size_t>(Slots)> keys_{};
  std::array<Scalar, static_cast<std::size_t>(Slots) * static_cast<std::size_t>(Rooms)> targets_{};
};

}  // namespace airside
