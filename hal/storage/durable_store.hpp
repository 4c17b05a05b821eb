#pragma once
// State that survives kill -9 and power cuts. Three kinds of record in one folder:
//   row record (small, every 6 min): the commit point, in two slots;
//   learning record (about 1 MB, when learning moved): in two slots, with a copy of the row that goes with it;
//   replay journal: a ring file of numbered transitions, with spare slots so that what the last commit refers to is
//   never overwritten before the next commit is complete.
// A commit writes and syncs journal, then learning, then row; whatever happens in between, load() finds the old
// generation or the new one whole. Bytes: docs/formats.md.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hal/storage/durable_record.hpp"
#include "hal/storage/log_position.hpp"
#include "hal/storage/storage_file.hpp"
#include "hal/storage/store_error.hpp"

namespace airside::hal {

/// Sizes that the caller's types have, fixed for the life of a store.
struct StoreLayout {
  std::size_t learning_bytes = 0;
  std::size_t row_bytes = 0;
  std::size_t transition_bytes = 0;
  std::uint32_t ring_capacity = 0;  ///< transitions that the replay ring holds
  std::uint32_t spare_slots = 256;  ///< transitions that may be pushed between two commits without a rewrite
  std::uint64_t meaning = 0;        ///< hash of topology, units and build format: other numbers do not mix

  std::uint64_t hash() const;
};

/// One generation as the caller holds it.
/// Shape: learning, row: as in StoreLayout; replay: ring_capacity x transition_bytes, transition k in slot
/// k % ring_capacity, of which those numbered replay_count - ring_capacity .. replay_count - 1 exist.
struct StoredState {
  std::span<const std::byte> learning;
  std::span<const std::byte> row;
  std::span<const std::byte> replay;
  std::uint64_t replay_count = 0;  ///< transitions ever pushed
  LogPosition log;
  bool learning_changed = true;  ///< false: learning is as in the commit before
};

/// Where load() writes to; as in StoredState.
struct StateBuffers {
  std::span<std::byte> learning;
  std::span<std::byte> row;
  std::span<std::byte> replay;
};

enum class LoadOutcome : std::uint8_t {
  none = 0,               ///< no usable generation: first start, or everything is damaged
  newest = 1,             ///< the last commit
  older = 2,              ///< the last commit is damaged; an earlier one, whole
  replay_incomplete = 3,  ///< weights and row are whole, but some transitions of the replay are not
};

/// What load() found. On none the buffers hold nothing of use, but the row where row_is_whole.
struct LoadedState {
  LoadOutcome outcome = LoadOutcome::none;
  std::uint64_t generation = 0;
  std::uint64_t learning_generation = 0;
  std::uint64_t replay_count = 0;  ///< value for the ring's count; smaller than committed on replay_incomplete
  LogPosition log;
  std::uint32_t damaged_records = 0;  ///< slots that hold something else than a whole record, or lack what a row names
  bool row_is_whole = false;          ///< on none: `row` is that of the newest commit whose row is whole
  std::uint64_t dropped_transitions = 0;  ///< on replay_incomplete: damaged ones, which the ring closes over
};

/// Text for logs.
const char* text_of(LoadOutcome outcome);

/// The store. One process at a time: the folder is locked while it is open.
/// A medium that fails is tried again by every commit(), also when it failed at open(): a disk that was full, a mount
/// that came late. What such a medium still gives to read is loaded.
/// Cost: no heap after open().
class DurableStore {
 public:
  /// Opens or makes the folder, locks it and reserves the space of all files; ready() tells what of it failed.
  /// Errors: locked.
  static StoreResult<DurableStore> open(const char* dir, const StoreLayout& layout, Sync sync = Sync::full);
  /// Why nothing can be committed yet. Errors: read_only, no_space, not_found, io.
  const StoreResult<void>& ready() const { return ready_; }

  DurableStore(DurableStore&&) = default;
  DurableStore& operator=(DurableStore&&) = default;

  /// Finds the newest generation that is whole, forces it to the medium, and lets commits go on from it. Call it before
  /// the first commit. A record that cannot be read counts as damaged.
  /// Errors: wrong_size; other_layout when the files belong to another topology or build.
  StoreResult<LoadedState> load(const StateBuffers& into);

  /// Makes `state` the newest generation.
  /// Errors: no_space, read_only, io, not_found, wrong_size; the generation before then still stands, and the next
  /// commit writes everything that is in doubt again. unread: the medium was away at load(), is there now, and holds
  /// records: load() them, or load() and commit anew; or files of another layout were not archived. removed: somebody
  /// took files away; the next commit writes all of it into new ones. Where the folder itself is another now, that
  /// commit tells locked while another process uses it, and unread where it holds records.
  /// Cost: 14 to 18 system calls, three of them fdatasync, plus a few µs for each transition.
  StoreResult<void> commit(const StoredState& state);

  /// Keeps files of another layout, which load() refused, under names that begin with `other-`, in place of those kept
  /// before, and begins anew without them. Until it has succeeded, commit() leaves them alone. A power cut in the
  /// middle is followed by another load() that refuses, and the rest goes the same way. Errors: read_only, no_space,
  /// io; what could not be renamed stays. Cost: no heap.
  StoreResult<void> archive_foreign_state();
  /// Whether files stand there that archive_foreign_state() has kept.
  bool keeps_other() const;

  /// The ring was cleared or refilled other than by pushing: the next commit writes all of it.
  void replay_replaced() { rewrite_replay_ = true; }

  /// Of the last commit or load; 0 before.
  std::uint64_t generation() const { return committed_.generation; }
  const StoreLayout& layout() const { return layout_; }

 private:
  /// What the last good row record says, and where it is stored.
  struct Committed {
    std::uint64_t generation = 0;
    std::uint64_t learning_generation = 0;
    std::uint64_t learning_digest = 0;
    std::uint64_t epoch = 0;
    std::uint64_t replay_count = 0;
    LogPosition log;
    int row_slot = 1;  ///< the next record goes to the other slot
    int learning_slot = 1;
  };

  DurableStore() = default;
  StoreResult<void> make_ready();
  StoreResult<void> open_files(StorageFile (&files)[2], const char* const (&names)[2], std::uint64_t bytes,
                               const char* step);
  StoreResult<void> open_everything();
  bool lacks_files() const;
  void release_files();
  std::size_t stride() const { return sizeof(JournalEntry) + (layout_.transition_bytes + 7) / 8 * 8; }
  std::uint64_t ring_slots() const { return std::uint64_t{layout_.ring_capacity} + layout_.spare_slots; }
  std::uint64_t first_transition(std::uint64_t count) const {
    return count > layout_.ring_capacity ? count - layout_.ring_capacity : 0;
  }
  /// How many transitions from `number` on lie side by side in the journal and fit the scratch buffer.
  std::uint64_t run_length(std::uint64_t number, std::uint64_t end) const;
  StoreResult<void> write_replay(std::uint64_t first, std::uint64_t end, std::uint64_t epoch,
                                 std::span<const std::byte> replay);
  /// Reads what is whole of the replay: transition k to slot k % ring_capacity, or those that are whole one behind the
  /// other to the slots from 0 on. Returns how many are damaged.
  std::uint64_t read_replay(const RecordHeader& header, std::span<std::byte> replay, bool close_gaps);
  StoreResult<void> write_record(const StorageFile& file, const RecordHeader& header, const StoredState& state) const;
  /// A header that is not whole comes back with generation 0.
  RecordHeader read_header(const StorageFile& file, RecordKind kind);
  bool read_row(int slot, const RecordHeader& header, std::span<std::byte> row) const;
  bool read_learning(int slot, const RecordHeader& header, std::span<std::byte> learning) const;
  bool read_row_copy(int slot, const RecordHeader& header, std::span<std::byte> row) const;
  void scan();
  struct Candidate;
  bool read_candidate(const Candidate& candidate, const StateBuffers& into, bool& learning_is_damaged);
  LoadedState adopt(const Candidate& candidate, std::uint64_t damaged_transitions, const StateBuffers& buffers);
  LoadedState nothing_whole(std::span<std::byte> row);

  StoreLayout layout_;
  Sync sync_ = Sync::full;
  std::string path_;
  StorageFile dir_, lock_;
  StorageFile row_[2], learning_[2], replay_[2];
  std::unique_ptr<std::byte[]> scratch_;  ///< one row record, or a run of journal entries
  std::size_t scratch_bytes_ = 0;
  Committed committed_;
  RecordHeader row_header_[2], learning_header_[2];  ///< as scan() found them
  std::uint64_t highest_generation_ = 0;             ///< seen in any slot, so that a new record is always the newest
  std::uint32_t damaged_ = 0;                        ///< slots that are neither empty nor whole
  StoreResult<void> ready_ = tl::make_unexpected(StoreError{StoreFault::not_found, 0, "open state folder"});
  bool out_of_reach_ = false;                    ///< load() could not look at all files
  bool other_layout_ = false, refused_ = false;  ///< seen by scan(); reported by load() and not archived yet
  bool learning_in_doubt_ = true;
  bool rewrite_replay_ = true;
};

}  // namespace airside::hal
