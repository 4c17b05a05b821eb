#pragma once
// A scripted controller state: step n is always the same bytes, so what comes back from storage can be compared whole.

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "hal/storage/durable_store.hpp"

namespace airside::hal {

/// Learning changes at every third step; 0 to 2 transitions are pushed a step, and many at each `burst`th.
class StateScript {
 public:
  explicit StateScript(const StoreLayout& layout, std::uint64_t burst = 11) : layout_(layout), burst_(burst) {
    learning.resize(layout.learning_bytes);
    row.resize(layout.row_bytes);
    replay.resize(layout.transition_bytes * layout.ring_capacity);
  }

  std::vector<std::byte> learning, row, replay;
  std::uint64_t step = 0;
  std::uint64_t count = 0;
  bool learning_changed = false;

  void advance() {
    ++step;
    learning_changed = step % 3 == 1;
    if (learning_changed) fill(learning, step * 3 + 1);
    fill(row, step * 3 + 2);
    std::memcpy(row.data(), &step, sizeof step);
    const std::uint64_t pushes = step % burst_ == 0 ? layout_.spare_slots + 3 : step % 3;
    for (std::uint64_t i = 0; i < pushes; ++i, ++count) {
      const auto slot = static_cast<std::size_t>(count % layout_.ring_capacity) * layout_.transition_bytes;
      fill(std::span(replay).subspan(slot, layout_.transition_bytes), count * 3);
    }
  }
  void advance_to(std::uint64_t to) {
    while (step < to) advance();
  }
  /// Goes on from a loaded state; the buffers already hold it.
  void resume(std::uint64_t replay_count) {
    std::memcpy(&step, row.data(), sizeof step);
    count = replay_count;
  }
  LogPosition log() const {
    return {static_cast<std::int64_t>(step / 5), static_cast<std::uint32_t>(step % 2), step * 100};
  }
  StoredState stored() const { return {learning, row, replay, count, log(), learning_changed}; }
  StateBuffers buffers() { return {learning, row, replay}; }
  std::uint64_t step_in_row() const {
    std::uint64_t value = 0;
    std::memcpy(&value, row.data(), sizeof value);
    return value;
  }

  /// Whether these buffers and this count are exactly step `step_in_row()` of the script.
  testing::AssertionResult is_whole(std::uint64_t replay_count) const {
    StateScript want(layout_, burst_);
    // A fast machine commits a hundred thousand times; what is no step at all is some huge number.
    if (step_in_row() > 100'000'000) return testing::AssertionFailure() << "row is not of the script";
    want.advance_to(step_in_row());
    if (row != want.row) return testing::AssertionFailure() << "row of step " << want.step << " is a mixture";
    if (learning != want.learning) return testing::AssertionFailure() << "learning is not of step " << want.step;
    if (replay_count != want.count) {
      return testing::AssertionFailure() << "replay count " << replay_count << ", not " << want.count;
    }
    const std::uint64_t first = want.count > layout_.ring_capacity ? want.count - layout_.ring_capacity : 0;
    for (std::uint64_t k = first; k < want.count; ++k) {
      const auto slot = static_cast<std::size_t>(k % layout_.ring_capacity) * layout_.transition_bytes;
      if (std::memcmp(&replay[slot], &want.replay[slot], layout_.transition_bytes) != 0) {
        return testing::AssertionFailure() << "transition " << k << " is not of step " << want.step;
      }
    }
    return testing::AssertionSuccess();
  }

 private:
  static void fill(std::span<std::byte> bytes, std::uint64_t seed) {
    std::uint64_t x = seed * 0x9E3779B97F4A7C15u + 1;
    for (std::byte& b : bytes) {
      x ^= x << 13;
      x ^= x >> 7;
      x ^= x << 17;
      b = static_cast<std::byte>(x >> 32);
    }
  }
  StoreLayout layout_;
  std::uint64_t burst_;
};

}  // namespace airside::hal
