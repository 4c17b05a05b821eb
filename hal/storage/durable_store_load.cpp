#include <algorithm>
#include <cstring>

#include "hal/storage/durable_store.hpp"

namespace airside::hal {

namespace {

/// Reads all of `into`, twice where the medium says that it failed: a sector may answer at the second time.
bool read_whole(const StorageFile& file, std::span<std::byte> into, std::uint64_t offset, bool* failed = nullptr) {
  for (int attempt = 0; attempt < 2; ++attempt) {
    const auto got = file.read_at(into, offset, "read state");
    if (got) return *got == into.size();
  }
  if (failed != nullptr) *failed = true;
  return false;
}

/// The slot of the newer record for i = 0, of the other one for 1.
int newer_first(const RecordHeader (&headers)[2], int i) {
  return headers[0].generation >= headers[1].generation ? i : 1 - i;
}

}  // namespace

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

RecordHeader DurableStore::read_header(const StorageFile& file, RecordKind kind) {
  RecordHeader header;
  if (!file.is_open()) return header;
  const auto bytes = std::as_writable_bytes(std::span(&header, 1));
  std::fill(bytes.begin(), bytes.end(), std::byte{0});  // a file that has no space yet is empty, not damaged
  bool failed = false;
  const bool read = read_whole(file, bytes, 0, &failed);
  const bool empty = std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
  if (read && header.header_digest == header.digest() && header.magic == record_magic &&
      header.kind == static_cast<std::uint32_t>(kind)) {
    const std::size_t learning = kind == RecordKind::learning ? layout_.learning_bytes : 0;
    if (header.layout == layout_.hash() && header.version == record_version &&
        header.payload_bytes == layout_.row_bytes + learning) {
      if (header.generation <= largest_count && header.replay_count <= largest_count) return header;
      ++damaged_;
    } else {
      other_layout_ = true;
    }
  } else if (!empty || failed) {
    ++damaged_;
  }
  header = {};
  return header;
}

void DurableStore::scan() {
  damaged_ = 0;
  other_layout_ = false;
  for (int slot = 0; slot < 2; ++slot) {
    row_header_[slot] = read_header(row_[slot], RecordKind::row);
    learning_header_[slot] = read_header(learning_[slot], RecordKind::learning);
    highest_generation_ =
        std::max({highest_generation_, row_header_[slot].generation, learning_header_[slot].generation});
  }
}

bool DurableStore::read_row(int slot, const RecordHeader& header, std::span<std::byte> row) const {
  return read_whole(row_[slot], row, payload_offset) && digest64(row) == header.payload_digest;
}

bool DurableStore::read_row_copy(int slot, const RecordHeader& header, std::span<std::byte> row) const {
  return read_whole(learning_[slot], row, payload_offset + layout_.learning_bytes) &&
         digest64(row, header.learning_digest) == header.payload_digest;
}

bool DurableStore::read_learning(int slot, const RecordHeader& header, std::span<std::byte> learning) const {
  return read_whole(learning_[slot], learning, payload_offset) && digest64(learning) == header.learning_digest;
}

std::uint64_t DurableStore::read_replay(const RecordHeader& header, std::span<std::byte> replay, bool close_gaps) {
  const std::uint64_t end = header.replay_count;
  const std::size_t size = layout_.transition_bytes;
  std::uint64_t damaged = 0, whole = 0;
  for (std::uint64_t number = first_transition(end); number < end;) {
    const std::uint64_t run = run_length(number, end);
    const std::span<std::byte> chunk(scratch_.get(), static_cast<std::size_t>(run) * stride());
    std::memset(chunk.data(), 0, chunk.size());
    // What cannot be read stays zero, which is the entry of no number but 0, and of that with another digest.
    (void)read_whole(replay_[header.epoch & 1], chunk, number % ring_slots() * stride());
    for (std::uint64_t i = 0; i < run; ++i, ++number) {
      const auto record = chunk.subspan(static_cast<std::size_t>(i) * stride(), stride());
      JournalEntry entry;
      std::memcpy(&entry, record.data(), sizeof entry);
      const auto bytes = record.subspan(sizeof entry, size);
      if (entry.number != number || entry.digest != digest64(bytes, number ^ (header.epoch << 40))) {
        ++damaged;
        continue;
      }
      const auto slot = static_cast<std::size_t>((close_gaps ? whole++ : number) % layout_.ring_capacity);
      std::memcpy(replay.data() + slot * size, bytes.data(), size);
    }
  }
  return damaged;
}

bool DurableStore::read_candidate(const Candidate& candidate, const StateBuffers& into, bool& learning_is_damaged) {
  const bool row = candidate.row_slot >= 0 ? read_row(candidate.row_slot, candidate.header, into.row)
                                           : read_row_copy(candidate.learning_slot, candidate.header, into.row);
  if (!row) return false;
  if (read_learning(candidate.learning_slot, candidate.header, into.learning)) return true;
  learning_is_damaged = true;
  ++damaged_;
  return false;
}

LoadedState DurableStore::adopt(const Candidate& candidate, std::uint64_t damaged_transitions,
                                const StateBuffers& buffers) {
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
  out_of_reach_ = false;
  // A killed process may have left the record in the kernel's memory alone, which a sync that failed has called clean:
  // it is written again as it is. The next commit overwrites the other slot, so this one must be on the medium first;
  // where it cannot be forced there, it is the one to be overwritten.
  const bool from_row = candidate.row_slot >= 0;
  const StorageFile& file = from_row ? row_[candidate.row_slot] : learning_[candidate.learning_slot];
  const bool writes = ready_ && sync_ == Sync::full;
  const StoredState same{.learning = buffers.learning, .row = buffers.row, .replay = {}, .log = {}};
  const bool forced = (writes ? write_record(file, h, same) : file.sync(sync_, "sync loaded record")).has_value();
  if (!forced && from_row) committed_.row_slot = 1 - candidate.row_slot;
  if (!forced && !from_row) learning_in_doubt_ = true;
  LoadedState state;
  state.generation = h.generation;
  state.learning_generation = h.learning_generation;
  state.replay_count = h.replay_count;
  state.log = log;
  state.damaged_records = damaged_;
  if (damaged_transitions > 0) {  // those that are whole have become numbers 0, 1, 2 ...
    state.replay_count = h.replay_count - first_transition(h.replay_count) - damaged_transitions;
    state.dropped_transitions = damaged_transitions;
    rewrite_replay_ = true;
  }
  return state;
}

/// Where no generation is whole. A row without its learning record, and learning records of more than a first commit
/// that was cut off, are of a state that is lost.
LoadedState DurableStore::nothing_whole(std::span<std::byte> row) {
  LoadedState none;
  const bool committed = row_header_[0].generation > 0 || row_header_[1].generation > 0;
  if (committed || highest_generation_ > 1) damaged_ = std::max(damaged_, 1U);
  none.damaged_records = damaged_;
  for (int i = 0; i < 2 && !none.row_is_whole; ++i) {
    const int slot = newer_first(row_header_, i);
    none.row_is_whole = row_header_[slot].generation > 0 && read_row(slot, row_header_[slot], row);
  }
  for (int i = 0; i < 2 && !none.row_is_whole; ++i) {
    const int slot = newer_first(learning_header_, i);
    none.row_is_whole = learning_header_[slot].generation > 0 && read_row_copy(slot, learning_header_[slot], row);
  }
  return none;
}

StoreResult<LoadedState> DurableStore::load(const StateBuffers& into) {
  if (into.learning.size() != layout_.learning_bytes || into.row.size() != layout_.row_bytes ||
      into.replay.size() != layout_.transition_bytes * layout_.ring_capacity) {
    return tl::make_unexpected(StoreError{StoreFault::wrong_size, 0, "load state"});
  }
  out_of_reach_ = false;
  if (!ready_) ready_ = make_ready();
  if (!dir_.is_open()) out_of_reach_ = true;
  scan();
  Candidate candidates[6];  // two rows, each with two learning records that may be alike, and these alone
  int count = 0;
  bool whole_row[2] = {false, false};
  for (int i = 0; i < 2; ++i) {
    const int slot = newer_first(row_header_, i);
    const RecordHeader& header = row_header_[slot];
    if (header.generation == 0) continue;
    if (!read_row(slot, header, into.row)) {
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
  bool learning_is_damaged[2] = {false, false};
  for (const bool take_incomplete : {false, true}) {
    for (int i = 0; i < count; ++i) {
      bool& is_damaged = learning_is_damaged[candidates[i].learning_slot];
      if (is_damaged || !read_candidate(candidates[i], into, is_damaged)) continue;
      const RecordHeader& header = candidates[i].header;
      std::uint64_t damaged = read_replay(header, into.replay, false);
      if (damaged > 0 && !take_incomplete) continue;
      if (damaged > 0) damaged = read_replay(header, into.replay, true);
      LoadedState state = adopt(candidates[i], damaged, into);
      state.outcome = damaged > 0                                                  ? LoadOutcome::replay_incomplete
                      : candidates[i].row_slot >= 0 && header.generation == newest ? LoadOutcome::newest
                                                                                   : LoadOutcome::older;
      return state;
    }
  }
  refused_ = other_layout_;
  if (other_layout_) return tl::make_unexpected(StoreError{StoreFault::other_layout, 0, "load state"});
  return nothing_whole(into.row);
}

}  // namespace airside::hal
