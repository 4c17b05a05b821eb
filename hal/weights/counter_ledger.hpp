#pragma once
// The highest counter of the pushed weights that were taken from each key, kept apart from the state: an old signed
// blob stays old when the state is lost.

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "hal/storage/store_error.hpp"
#include "hal/weights/key_ring.hpp"

namespace airside::hal {

/// Plain bytes; part of the row record too.
struct KeyCounter {
  KeyId key{};
  std::uint64_t highest = 0;  ///< of the blobs taken from this key
};

/// The file `push_counters` in two folders, such as state and log; the larger counter rules. It is written before the
/// commit that exchanges the weights: a power cut between the two leaves it ahead of the state, never behind. The blob
/// whose commit is still to come is named by its digest, so that this one alone may come again. A file exists from the
/// first commit of a box on: where one lies, the box is not new. Bytes in docs/formats.md.
/// Cost: no heap after construction; a write is about ten system calls a folder.
class CounterLedger {
 public:
  CounterLedger(std::string first_dir, std::string second_dir, Sync sync = Sync::full);

  /// Reads both files and joins what they hold. Errors: none; a file that cannot be read counts as damaged.
  void read();
  /// Whether a file lies in one of the folders, whole or not.
  bool exists() const { return exists_; }

  /// The highest counter taken from this key; 0 without an entry.
  std::uint64_t highest(const KeyId& key) const;

  /// Joins the counters of a state. `is_known`: a key without an entry has never sent anything, since the state is
  /// whole or the box is new. It counts where no file was whole: a state that began after a loss knows no better.
  void join(std::span<const KeyCounter> counters, bool is_known);
  /// False: nothing says what was taken from keys without an entry.
  bool is_known() const { return is_known_; }

  enum class Verdict : std::uint8_t { newer, old, unknown };
  /// Whether a blob with this counter and digest is newer than all that were taken from this key. `key` may carry a
  /// person's word of the last counter, from the file `counters` of the keys folder.
  Verdict judge(const PublicKey& key, std::uint64_t counter, std::uint64_t blob_digest) const;

  /// Notes a blob that is about to be exchanged. `keys`: where all places are taken, that of a key which is no longer
  /// there is used. Errors: those of the second folder where neither could be written; the counters are then as before.
  StoreResult<void> raise(const KeyId& key, std::uint64_t counter, std::uint64_t blob_digest, const KeyRing& keys);
  /// The commit that exchanged the blob of this key is done: the next equal blob is an old one.
  void settle(const KeyId& key);
  /// After a commit: writes where a file is missing or behind. Errors: of a folder in which that failed.
  StoreResult<void> keep();

 private:
  struct Entry {
    KeyId key{};
    std::uint64_t highest = 0;
    std::uint64_t pending_digest = 0;  ///< of the blob that waits for its commit; 0: none
  };
  struct File {
    std::uint64_t magic = 0;
    std::uint64_t is_known = 0;
    std::array<Entry, KeyRing::max_keys> entry{};
    std::uint64_t digest = 0;
  };
  struct Place {
    std::string dir;
    bool is_behind = true;
  };
  enum class Look : std::uint8_t { missing, damaged, whole };

  static Look read_file(const Place& place, File& file);
  StoreResult<void> write_file(const Place& place, const File& file) const;
  /// Writes both. Returns how many were written, and the last error.
  int write(StoreResult<void>& failed);
  const Entry* find(const KeyId& key) const;
  Entry* place_for(const KeyId& key, const KeyRing* keys);
  void join(const Entry& other);

  std::array<Place, 2> places_;
  Sync sync_;
  std::array<Entry, KeyRing::max_keys> entries_{};
  bool exists_ = false, found_whole_ = false, is_known_ = false;
};

}  // namespace airside::hal
