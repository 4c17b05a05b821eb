#include "hal/weights/counter_ledger.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <type_traits>

#include "hal/storage/digest64.hpp"
#include "hal/storage/storage_file.hpp"

namespace airside::hal {
namespace {

constexpr const char* ledger_name = "push_counters";
constexpr const char* staged_ledger_name = "push_counters.new";
constexpr std::uint64_t counters_magic = 0x31544E4344525341u;  // "ASRDCNT1" in file order

template <class File>
std::uint64_t digest_of_counters(const File& file) {
  static_assert(sizeof(File) == 408 && std::has_unique_object_representations_v<File>);
  return digest64(std::as_bytes(std::span(&file, 1)).first(sizeof file - sizeof file.digest));
}

template <class Entries>
bool are_alike(const Entries& a, const Entries& b) {
  return std::ranges::equal(std::as_bytes(std::span(&a, 1)), std::as_bytes(std::span(&b, 1)));
}

}  // namespace

CounterLedger::CounterLedger(std::string first_dir, std::string second_dir, Sync sync)
    : places_{Place{std::move(first_dir)}, Place{std::move(second_dir)}}, sync_(sync) {}

CounterLedger::Look CounterLedger::read_file(const Place& place, File& file) {
  if (place.dir.empty()) return Look::missing;
  const auto folder = StorageFile::open_existing_dir(place.dir.c_str());
  if (!folder) return Look::missing;
  const auto opened = StorageFile::open_to_read(folder->descriptor(), ledger_name, "open push counters");
  if (!opened) return opened.error().fault == StoreFault::not_found ? Look::missing : Look::damaged;
  const auto got = opened->read_at(std::as_writable_bytes(std::span(&file, 1)), 0, "read push counters");
  const bool whole =
      got && *got == sizeof file && file.magic == counters_magic && file.digest == digest_of_counters(file);
  return whole ? Look::whole : Look::damaged;
}

StoreResult<void> CounterLedger::write_file(const Place& place, const File& file) const {
  const auto folder = StorageFile::open_dir(place.dir.c_str());
  if (!folder) return tl::make_unexpected(folder.error());
  const int dir = folder->descriptor();
  (void)::unlinkat(dir, staged_ledger_name, 0);  // whatever lies there is not written to
  const StorageFile opened(::openat(dir, staged_ledger_name, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0640));
  if (!opened.is_open()) return tl::make_unexpected(store_error(errno, "open push counters"));
  StoreResult<void> done = opened.write_at(std::as_bytes(std::span(&file, 1)), 0, "write push counters");
  if (done) done = opened.sync(sync_, "sync push counters");
  if (done && ::renameat(dir, staged_ledger_name, dir, ledger_name) != 0) {
    done = tl::make_unexpected(store_error(errno, "rename push counters"));
  }
  if (done && sync_ == Sync::full && ::fsync(dir) != 0) {
    done = tl::make_unexpected(store_error(errno, "sync folder of push counters"));
  }
  return done;
}

int CounterLedger::write(StoreResult<void>& failed) {
  File file{counters_magic, is_known_ ? 1U : 0U, entries_, 0};
  file.digest = digest_of_counters(file);
  int written = 0;
  for (Place& place : places_) {
    if (place.dir.empty()) continue;
    const auto done = write_file(place, file);
    place.is_behind = !done;
    written += done ? 1 : 0;
    if (!done) failed = done;
  }
  exists_ = exists_ || written > 0;
  return written;
}

void CounterLedger::read() {
  entries_ = {};
  exists_ = false;
  bool any_unknown = false;
  found_whole_ = false;
  std::array<File, 2> files{};
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Look look = read_file(places_[i], files[i]);
    exists_ = exists_ || look != Look::missing;
    places_[i].is_behind = look != Look::whole;
    if (look != Look::whole) continue;
    found_whole_ = true;
    any_unknown = any_unknown || files[i].is_known == 0;
    for (const Entry& entry : files[i].entry) join(entry);
  }
  is_known_ = found_whole_ && !any_unknown;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const bool is_alike = are_alike(files[i].entry, entries_) && (files[i].is_known != 0) == is_known_;
    places_[i].is_behind = places_[i].is_behind || !is_alike;
  }
}

const CounterLedger::Entry* CounterLedger::find(const KeyId& key) const {
  const auto at = std::ranges::find(entries_, key, &Entry::key);
  return key == KeyId{} || at == entries_.end() ? nullptr : &*at;
}

std::uint64_t CounterLedger::highest(const KeyId& key) const {
  const Entry* const entry = find(key);
  return entry == nullptr ? 0 : entry->highest;
}

CounterLedger::Entry* CounterLedger::place_for(const KeyId& key, const KeyRing* keys) {
  auto at = std::ranges::find(entries_, key, &Entry::key);
  if (at == entries_.end()) at = std::ranges::find(entries_, KeyId{}, &Entry::key);
  if (at == entries_.end() && keys != nullptr) {
    at = std::ranges::find_if(entries_, [keys](const Entry& entry) { return keys->find(entry.key) == nullptr; });
  }
  return at == entries_.end() ? nullptr : &*at;
}

void CounterLedger::join(const Entry& other) {
  if (other.key == KeyId{}) return;
  Entry* const mine = place_for(other.key, nullptr);
  if (mine == nullptr) return;
  if (mine->key != other.key || mine->highest < other.highest) {
    *mine = other;
  } else if (mine->highest == other.highest && other.pending_digest == 0) {
    mine->pending_digest = 0;
  }
}

void CounterLedger::join(std::span<const KeyCounter> counters, bool is_known) {
  const auto before = entries_;
  for (const KeyCounter& counter : counters) {
    if (counter.highest > 0) join(Entry{counter.key, counter.highest, 0});
  }
  const bool becomes_known = is_known && !found_whole_ && !is_known_;
  if (are_alike(before, entries_) && !becomes_known) return;
  is_known_ = is_known_ || becomes_known;
  for (Place& place : places_) place.is_behind = true;
}

CounterLedger::Verdict CounterLedger::judge(const PublicKey& key, std::uint64_t counter,
                                            std::uint64_t blob_digest) const {
  const Entry* const entry = find(key.id);
  if (entry == nullptr && !key.counter_given && !is_known_) return Verdict::unknown;
  if (key.counter_given && counter <= key.last_counter) return Verdict::old;
  if (entry == nullptr || counter > entry->highest) return Verdict::newer;
  return counter == entry->highest && blob_digest == entry->pending_digest ? Verdict::newer : Verdict::old;
}

StoreResult<void> CounterLedger::raise(const KeyId& key, std::uint64_t counter, std::uint64_t blob_digest,
                                       const KeyRing& keys) {
  const auto before = entries_;
  Entry* const entry = place_for(key, &keys);
  if (entry == nullptr)
    return tl::make_unexpected(StoreError{StoreFault::wrong_size, 0, "find place for push counter"});
  *entry = {key, counter, blob_digest};
  StoreResult<void> failed;
  if (write(failed) > 0) return {};
  entries_ = before;
  return failed ? tl::make_unexpected(StoreError{StoreFault::not_found, 0, "find folder of push counters"}) : failed;
}

void CounterLedger::settle(const KeyId& key) {
  const auto at = std::ranges::find(entries_, key, &Entry::key);
  if (at == entries_.end() || at->pending_digest == 0) return;
  at->pending_digest = 0;
  for (Place& place : places_) place.is_behind = true;  // keep() writes them
}

StoreResult<void> CounterLedger::keep() {
  const auto lacks = [](const Place& place) {
    if (place.dir.empty()) return false;
    if (place.is_behind) return true;
    const auto folder = StorageFile::open_existing_dir(place.dir.c_str());
    return folder && ::faccessat(folder->descriptor(), ledger_name, F_OK, AT_SYMLINK_NOFOLLOW) != 0 && errno == ENOENT;
  };
  StoreResult<void> failed;
  if (std::ranges::any_of(places_, lacks)) (void)write(failed);
  return failed;
}

}  // namespace airside::hal
