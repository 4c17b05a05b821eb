#pragma once

// A store of a few hundred bytes, whose script wraps its ring and its journal within 14 steps.

#include <stdexcept>

#include "hal/storage/durable_store.hpp"
#include "power_loss/state_script.hpp"
#include "support/test_folder.hpp"

namespace airside::hal {

inline const StoreLayout layout{
    .learning_bytes = 100, .row_bytes = 44, .transition_bytes = 20, .ring_capacity = 7, .spare_slots = 4, .meaning = 1};
inline constexpr std::uint64_t steps = 14;  // past the ring's wrap, the journal's wrap and a burst

inline DurableStore open_store(const TestFolder& folder, const StoreLayout& with = layout) {
  auto store = DurableStore::open(folder.c_str(), with);
  if (!store) throw std::runtime_error(describe(store.error()));
  return std::move(*store);
}

struct Recovered {
  StateScript script{layout};
  LoadedState loaded;
};

inline Recovered recover(const TestFolder& folder) {
  Recovered r;
  DurableStore store = open_store(folder);
  const auto loaded = store.load(r.script.buffers());
  if (!loaded) throw std::runtime_error(describe(loaded.error()));
  r.loaded = *loaded;
  return r;
}

}  // namespace airside::hal
