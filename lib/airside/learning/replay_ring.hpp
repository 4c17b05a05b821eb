#pragma once
// Memory of the last transitions, first in first out, with uniform sampling from a generator that the caller saves.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "airside/memory_size.hpp"
#include "airside/network/losses.hpp"
#include "airside/splitmix64.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Shape: Capacity rows [S E A S1 E1], scaled. Plain data: rows in slots, then the count of all rows ever pushed;
/// row number k (from 0) lies in slot k % Capacity.
template <Topology T, class Scalar, int Capacity = replay_capacity>
class ReplayRing {
 public:
  static constexpr int capacity = Capacity;
  using Row = std::array<Scalar, static_cast<std::size_t>(Layout<T>::transition)>;

  /// Remembers a transition, forgetting the oldest when full.  Cost: O(1).
  void push(const Row& row) {
    rows_[static_cast<std::size_t>(total_ % Capacity)] = row;
    ++total_;
  }
  /// The same, unless it is the newest one again to the bit: a device that repeats itself must not fill the memory.
  void push_news(const Row& row) {
    if (size() == 0 || newest(0) != row) push(row);
  }
  void clear() { total_ = 0; }

  int size() const { return static_cast<int>(std::min<std::uint64_t>(total_, Capacity)); }
  std::uint64_t total_pushed() const { return total_; }

  /// Physical slot, 0 .. size()-1.
  const Row& slot(int i) const { return rows_[static_cast<std::size_t>(i)]; }
  Row& slot(int i) { return rows_[static_cast<std::size_t>(i)]; }
  /// Slot of the row pushed `age` pushes before the last one; 0 <= age < size().
  int slot_of_age(int age) const { return static_cast<int>((total_ - 1 - static_cast<std::uint64_t>(age)) % Capacity); }
  const Row& newest(int age) const { return slot(slot_of_age(age)); }

  /// Sets the count after slots have been refilled from durable storage.
  void restore_count(std::uint64_t total_pushed) { total_ = total_pushed; }

  /// Fills `index` with n = min(index.size(), size()) different slots, uniformly drawn, the `recent` newest always
  /// among them. Floyd's method: a draw a slot, so the same generator state gives the same slots.
  /// Returns n.  Cost: O(n + Capacity/64) time, Capacity/8 bytes of stack.  Source: docs/method.md, open point 12.
  int sample(SplitMix64& generator, std::span<std::uint32_t> index, int recent = 0) const {
    const int have = size();
    const int n = std::min(static_cast<int>(index.size()), have);
    int filled = 0;
    if (n == have) {
      for (; filled < n; ++filled) index[static_cast<std::size_t>(filled)] = static_cast<std::uint32_t>(filled);
      return n;
    }
    const int newest_count = std::clamp(recent, 0, n);
    for (; filled < newest_count; ++filled)
      index[static_cast<std::size_t>(filled)] = static_cast<std::uint32_t>(slot_of_age(filled));
    std::array<std::uint64_t, (static_cast<std::size_t>(Capacity) + 63) / 64> taken{};
    const auto take = [&](int age) {
      std::uint64_t& word = taken[static_cast<std::size_t>(age) / 64];
      const std::uint64_t bit = std::uint64_t{1} << (age % 64);
      const bool is_new = (word & bit) == 0;
      word |= bit;
      return is_new;
    };
    for (int last = have - (n - newest_count); last < have; ++last) {
      const auto range = static_cast<std::uint32_t>(last - newest_count + 1);
      const int drawn = newest_count + static_cast<int>(generator.below(range));
      const bool is_new = take(drawn);
      if (!is_new) take(last);
      index[static_cast<std::size_t>(filled++)] = static_cast<std::uint32_t>(slot_of_age(is_new ? drawn : last));
    }
    return n;
  }

  /// Fills all of `index` with independently drawn slots; nothing if the ring is empty. Returns how many.
  int sample_with_replacement(SplitMix64& generator, std::span<std::uint32_t> index) const {
    if (size() == 0) return 0;
    for (std::uint32_t& slot : index) slot = generator.below(static_cast<std::uint32_t>(size()));
    return static_cast<int>(index.size());
  }

  /// The sampled transitions, for the learner.
  BatchView<T, Scalar> view(std::span<const std::uint32_t> index) const {
    return {rows_.front().data(), index.data(), static_cast<int>(index.size())};
  }

 private:
  std::array<Row, static_cast<std::size_t>(Capacity)> rows_{};
  std::uint64_t total_ = 0;
};

static_assert(std::is_trivially_copyable_v<ReplayRing<FiveZone, float>>);

}  // namespace airside
