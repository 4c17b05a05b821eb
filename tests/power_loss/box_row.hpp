#pragma once
// What the tests must know of the daemon's durable state, without all that its headers bring along.

#include <cstdint>
#include <span>

#include "airside/civil_time.hpp"
#include "hal/storage/durable_store.hpp"
#include "hal/weights/key_ring.hpp"

namespace airside::power_loss {

/// What of a row record says which weights are in force.
struct RowFacts {
  CivilTime row_time;
  std::uint64_t counter = 0;   ///< highest of the first key
  std::uint32_t blob_crc = 0;  ///< of the last pushed weights
  bool rolled_back = false;
  std::uint64_t previous_digest = 0;  ///< of the copy to go back to
  hal::KeyId key{};                   ///< the first one
};

/// Of airsided with five zones.
hal::StoreLayout box_layout();
RowFacts facts_of_box_row(std::span<const std::byte> row);

}  // namespace airside::power_loss
