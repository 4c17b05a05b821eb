#include <algorithm>
#include <cstring>

#include "hal/durable_store.hpp"

namespace airside::hal {

/// A generation that load() may choose: a row record with its learning record, or a learning record with its copy
/// of the row.
struct DurableStore::Candidate {
  RecordHeader header;
  int row_slot = -1;  ///< -1: the learning record's copy
  int learning_slot = 0;
};

const char* text_of(LoadOutcome outcome) {
  switch (outcome) {
    case LoadOutcome::none: return "no state";
    case LoadOutcome::newest: return "the last commit";
    case LoadOutcome::older: return "an earlier commit, since the last one is damaged";
    case LoadOutcome::replay_incomplete: return "the last commit with a part of the replay";
  }
  return "unknown";
}

StoreResult<RecordHeader> DurableStore::read_header(const StorageFile& file, RecordKind kind) {
  RecordHeader header;
  const auto bytes = std::as_writable_bytes(std::span(&header, 1));
  const auto got = file.read_at(bytes, 0, "read record");
  if (!got) return tl::make_unexpected(got.error());
  const bool empty = std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
  if (*got == bytes.size() && header.header_digest == header.digest() && header.magic == record_magic &&
      header.kind == static_cast<std::uint32_t>(kind)) {
    const std::size_t learning = kind == RecordKind::learning ? layout_.learning_bytes : 0;
    if (header.layout == layout_.hash() && header.version == record_version &&
        header.payload_bytes == layout_.row_bytes + learning) {
      return header;
    }
    other_layout_ = true;
  } else if (*got > 0 && !empty) {
    ++damaged_;
  }
  header = {};
  return header;
}

StoreResult<void> DurableStore::scan() {
  damaged_ = 0;
  other_layout_ = false;
  for (int slot = 0; slot < 2; ++slot) {
    const auto row = read_header(row_[slot], RecordKind::row);
    if (!row) return tl::make_unexpected(row.error());
    const auto learning = read_header(learning_[slot], RecordKind::learning);
    if (!learning) return tl::make_unexpected(learning.error());
    row_header_[slot] = *row;
    learning_header_[slot] = *learning;
    highest_generation_ = std::max({highest_generation_, row->generation, learning->generation});
  }
  return {};
}

StoreResult<bool> DurableStore::read_row(int slot, const RecordHeader& header, std::span<std::byte> row) const {
  const auto got = row_[slot].read_at(row, payload_offset, "read row record");
  if (!got) return tl::make_unexpected(got.error());
  return *got == row.size() && digest64(row) == header.payload_digest;
}

StoreResult<bool> DurableStore::read_row_copy(int slot, const RecordHeader& header, std::span<std::byte> row) const {
  const auto got = learning_[slot].read_at(row, payload_offset + layout_.learning_bytes, "read learning record");
  if (!got) return tl::make_unexpected(got.error());
  return *got == row.size() && digest64(row, header.learning_digest) == header.payload_digest;
}

StoreResult<bool> DurableStore::read_learning(int slot, const RecordHeader& header,
                                              std::span<std::byte> learning) const {
  const auto got = learning_[slot].read_at(learning, payload_offset, "read learning record");
  if (!got) return tl::make_unexpected(got.error());
  return *got == learning.size() && digest64(learning) == header.learning_digest;
}

StoreResult<std::uint64_t> DurableStore::read_replay(const RecordHeader& header, std::span<std::byte> replay) {
  const std::uint64_t end = header.replay_count;
  const std::size_t size = layout_.transition_bytes;
  std::uint64_t first_whole = first_transition(end);
  for (std::uint64_t number = first_whole; number < end;) {
    const std::uint64_t run = run_length(number, end);
    const std::span<std::byte> chunk(scratch_.get(), static_cast<std::size_t>(run) * stride());
    std::memset(chunk.data(), 0, chunk.size());
    const auto got = replay_[header.epoch & 1].read_at(chunk, number % ring_slots() * stride(), "read replay journal");
    if (!got) return tl::make_unexpected(got.error());
    for (std::uint64_t i = 0; i < run; ++i, ++number) {
      const auto record = chunk.subspan(static_cast<std::size_t>(i) * stride(), stride());
      JournalEntry entry;
      std::memcpy(&entry, record.data(), sizeof entry);
      const auto bytes = record.subspan(sizeof entry, size);
      if (entry.number != number || entry.digest != digest64(bytes, number ^ (header.epoch << 40))) {
        first_whole = number + 1;
        continue;
      }
      const auto slot = static_cast<std::size_t>(number % layout_.ring_capacity);
      std::memcpy(replay.data() + slot * size, bytes.data(), size);
    }
  }
  return first_whole;
}

StoreResult<bool> DurableStore::read_candidate(const Candidate& candidate, const StateBuffers& into) {
  const auto row = candidate.row_slot >= 0 ? read_row(candidate.row_slot, candidate.header, into.row)
                                           : read_row_copy(candidate.learning_slot, candidate.header, into.row);
  if (!row || !*row) return row;
  return read_learning(candidate.learning_slot, candidate.header, into.learning);
}

LoadedState DurableStore::adopt(const Candidate& candidate, std::uint64_t first_whole, std::span<std::byte> replay) {
  const RecordHeader& h = candidate.header;
  const LogPosition log{h.log_day, h.log_part, h.log_bytes};
  committed_ = {h.generation,
                h.learning_generation,
                h.learning_digest,
                h.epoch,
                h.replay_count,
                log,
                candidate.row_slot >= 0 ? candidate.row_slot : 1,
                candidate.learning_slot};
  learning_in_doubt_ = false;
  rewrite_replay_ = false;
  LoadedState state;
  state.generation = h.generation;
  state.learning_generation = h.learning_generation;
  state.replay_count = h.replay_count;
  state.log = log;
  state.damaged_records = damaged_;
  if (first_whole != first_transition(h.replay_count)) {
    // The whole transitions become numbers 0, 1, 2 ..., so they must start in slot 0.
    const auto slot = static_cast<std::ptrdiff_t>(first_whole % layout_.ring_capacity);
    std::rotate(replay.begin(), replay.begin() + slot * static_cast<std::ptrdiff_t>(layout_.transition_bytes),
                replay.end());
    state.replay_count = h.replay_count - first_whole;
    rewrite_replay_ = true;
  }
  return state;
}

StoreResult<LoadedState> DurableStore::load(const StateBuffers& into) {
  if (into.learning.size() != layout_.learning_bytes || into.row.size() != layout_.row_bytes ||
      into.replay.size() != layout_.transition_bytes * layout_.ring_capacity) {
    return tl::make_unexpected(StoreError{StoreFault::wrong_size, 0, "load state"});
  }
  if (const auto done = scan(); !done) return tl::make_unexpected(done.error());
  Candidate candidates[4];
  int count = 0;
  bool whole_row[2] = {false, false};
  const auto newer_first = [](const RecordHeader(&headers)[2], int i) {
    return headers[0].generation >= headers[1].generation ? i : 1 - i;
  };
  for (int i = 0; i < 2; ++i) {
    const int slot = newer_first(row_header_, i);
    const RecordHeader& header = row_header_[slot];
    if (header.generation == 0) continue;
    const auto row = read_row(slot, header, into.row);
    if (!row) return tl::make_unexpected(row.error());
    if (!*row) {
      ++damaged_;
      continue;
    }
    whole_row[slot] = true;
    for (int j = 0; j < 2; ++j) {
      const RecordHeader& learning = learning_header_[j];
      if (learning.generation == header.learning_generation && learning.learning_digest == header.learning_digest) {
        candidates[count++] = {header, slot, j};
      }
    }
  }
  for (int i = 0; i < 2; ++i) {
    const int slot = newer_first(learning_header_, i);
    if (learning_header_[slot].generation != 0) candidates[count++] = {learning_header_[slot], -1, slot};
  }
  std::uint64_t newest = 0;
  for (int slot = 0; slot < 2; ++slot) {
    if (whole_row[slot]) newest = std::max(newest, row_header_[slot].generation);
  }
  for (const bool take_incomplete : {false, true}) {
    for (int i = 0; i < count; ++i) {
      const auto whole = read_candidate(candidates[i], into);
      if (!whole) return tl::make_unexpected(whole.error());
      if (!*whole) continue;
      const RecordHeader& header = candidates[i].header;
      const auto first_whole = read_replay(header, into.replay);
      if (!first_whole) return tl::make_unexpected(first_whole.error());
      const bool complete = *first_whole == first_transition(header.replay_count);
      if (!complete && !take_incomplete) continue;
      LoadedState state = adopt(candidates[i], *first_whole, into.replay);
      state.outcome = !complete                                                    ? LoadOutcome::replay_incomplete
                      : candidates[i].row_slot >= 0 && header.generation == newest ? LoadOutcome::newest
                                                                                   : LoadOutcome::older;
      return state;
    }
  }
  if (other_layout_) return tl::make_unexpected(StoreError{StoreFault::other_layout, 0, "load state"});
  LoadedState none;
  none.damaged_records = damaged_;
  return none;
}

}  // namespace airside::hal
