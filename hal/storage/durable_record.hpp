#pragma once
// Bytes of the durable records: the header before each slot and each journal entry. Little-endian, no padding.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "hal/storage/digest64.hpp"

namespace airside::hal {

constexpr std::uint64_t record_magic = 0x3130454449535241u;  ///< "ARSIDE01" in file order
constexpr std::uint32_t record_version = 1;

/// No box reaches it; a record beyond it would leave no number for the next one.
constexpr std::uint64_t largest_count = std::uint64_t{1} << 62;

enum class RecordKind : std::uint32_t { row = 1, learning = 2 };

/// Stands at offset 0 of a slot; the payload follows.
struct RecordHeader {
  std::uint64_t magic = record_magic;
  std::uint32_t version = record_version;
  std::uint32_t kind = 0;
  std::uint64_t layout = 0;      ///< StoreLayout::hash()
  std::uint64_t generation = 0;  ///< of the commit that wrote the record, from 1
  std::uint64_t payload_bytes = 0;
  std::uint64_t payload_digest = 0;       ///< row: of the row; learning: of the row, seeded with learning_digest
  std::uint64_t learning_generation = 0;  ///< the learning record that belongs to this one
  std::uint64_t learning_digest = 0;
  std::uint64_t epoch = 0;  ///< of the journal; its last bit names the file
  std::uint64_t replay_count = 0;
  std::int64_t log_day = 0;
  std::uint64_t log_bytes = 0;
  std::uint32_t log_part = 0;
  std::uint32_t zero_1 = 0;
  std::uint64_t zero_2 = 0;
  std::uint64_t header_digest = 0;  ///< of all bytes before

  std::uint64_t digest() const {
    return digest64(std::as_bytes(std::span(this, 1)).first(sizeof(RecordHeader) - sizeof header_digest));
  }
};
static_assert(sizeof(RecordHeader) == 120 && std::is_trivially_copyable_v<RecordHeader>);
static_assert(std::has_unique_object_representations_v<RecordHeader>, "no padding");
static_assert(std::endian::native == std::endian::little);

constexpr std::size_t payload_offset = 128;  ///< of a slot

/// Stands before each transition of the journal.
struct JournalEntry {
  std::uint64_t number = 0;  ///< of the transition, from 0
  std::uint64_t digest = 0;  ///< of the transition, seeded with number and epoch
};
static_assert(sizeof(JournalEntry) == 16);

}  // namespace airside::hal
