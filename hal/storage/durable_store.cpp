// Opening and committing; loading is in durable_store_load.cpp.
#include "hal/storage/durable_store.hpp"

#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace airside::hal {
namespace {

constexpr std::size_t chunk_bytes = 65536;
constexpr const char* row_names[2] = {"row.a", "row.b"};
constexpr const char* learning_names[2] = {"learning.a", "learning.b"};
constexpr const char* replay_names[2] = {"replay.a", "replay.b"};
constexpr const char* kept_names[3][2] = {
    {"other-replay.a", "other-replay.b"}, {"other-learning.a", "other-learning.b"}, {"other-row.a", "other-row.b"}};

auto fail(StoreFault fault, const char* step) { return tl::make_unexpected(StoreError{fault, 0, step}); }

/// Whether nothing was ever written to the beginning of a file.
bool is_blank(const StorageFile& file) {
  std::byte front[64] = {};
  (void)file.read_at(front, 0, "look at state");  // what cannot be read is no reason to lose what can
  return std::ranges::all_of(front, [](std::byte b) { return b == std::byte{0}; });
}

}  // namespace

std::uint64_t StoreLayout::hash() const {
  const std::uint64_t words[] = {learning_bytes, row_bytes, transition_bytes, ring_capacity, spare_slots, meaning};
  return digest64(std::as_bytes(std::span(words)), record_version);
}

StoreResult<DurableStore> DurableStore::open(const char* dir, const StoreLayout& layout, Sync sync) {
  DurableStore store;
  store.layout_ = layout;
  store.sync_ = sync;
  store.path_ = dir;
  store.scratch_bytes_ = std::max(store.stride(), chunk_bytes / store.stride() * store.stride());
  store.scratch_ = std::make_unique<std::byte[]>(store.scratch_bytes_);
  store.ready_ = store.make_ready();
  if (!store.ready_ && store.ready_.error().fault == StoreFault::locked) {
    return tl::make_unexpected(store.ready_.error());
  }
  store.scan();
  return store;
}

/// Everything that a commit needs, as far as it is not there yet. What fails may leave files that can only be read.
StoreResult<void> DurableStore::make_ready() {
  if (!dir_.is_open()) {
    auto folder = StorageFile::open_dir(path_.c_str());
    if (!folder) return tl::make_unexpected(folder.error());
    dir_ = std::move(*folder);
  }
  StoreResult<void> failed;
  if (!lock_.is_open()) {
    auto lock = StorageFile::open(dir_.descriptor(), "lock", true, "open lock of state folder");
    if (!lock) {
      failed = tl::make_unexpected(lock.error());
      lock = StorageFile::open_to_read(dir_.descriptor(), "lock", "open lock of state folder");
    }
    if (lock && ::flock(lock->descriptor(), LOCK_EX | LOCK_NB) != 0) {
      return tl::make_unexpected(store_error(errno, "lock state folder"));
    }
    // A lock that can only be read holds other daemons off too; one that is not there is tried again.
    if (lock) lock_ = std::move(*lock);
  }
  const auto opened = open_everything();
  return failed ? opened : failed;
}

StoreResult<void> DurableStore::open_files(StorageFile (&files)[2], const char* const (&names)[2], std::uint64_t bytes,
                                           const char* step) {
  StoreResult<void> failed;
  for (int i = 0; i < 2; ++i) {
    auto file = StorageFile::open(dir_.descriptor(), names[i], true, step);
    if (file) {
      if (const auto done = file->reserve(bytes, step); !done) failed = done;
      files[i] = std::move(*file);
      continue;
    }
    failed = tl::make_unexpected(file.error());
    if (files[i].is_open()) continue;
    auto to_read = StorageFile::open_to_read(dir_.descriptor(), names[i], step);
    if (to_read) files[i] = std::move(*to_read);
    if (!to_read && to_read.error().fault != StoreFault::not_found) out_of_reach_ = true;
  }
  return failed;
}

StoreResult<void> DurableStore::open_everything() {
  const std::uint64_t row_end = payload_offset + layout_.row_bytes;
  const auto rows = open_files(row_, row_names, row_end, "open row record");
  const auto learning = open_files(learning_, learning_names, row_end + layout_.learning_bytes, "open learning record");
  const auto replay = open_files(replay_, replay_names, ring_slots() * stride(), "open replay journal");
  for (const auto* opened : {&rows, &learning, &replay}) {
    if (!*opened) return *opened;
  }
  if (sync_ == Sync::full && ::fsync(dir_.descriptor()) != 0) {
    return tl::make_unexpected(store_error(errno, "sync state folder"));
  }
  return {};
}

bool DurableStore::lacks_files() const {
  const StorageFile* files[] = {&lock_, &row_[0], &row_[1], &learning_[0], &learning_[1], &replay_[0], &replay_[1]};
  return std::ranges::any_of(files, [](const StorageFile* file) { return file->is_unlinked(); });
}

/// What is written to files without a name is lost at the next start. Where only files are gone, memory knows best
/// what belongs into new ones; another folder may hold state that is worth more.
void DurableStore::release_files() {
  if (dir_.is_replaced_at(path_.c_str())) {
    dir_.close();
    out_of_reach_ = true;
    highest_generation_ = 0;
    committed_ = {};
  }
  lock_.close();
  for (auto* files : {&row_, &learning_, &replay_}) {
    for (StorageFile& file : *files) file.close();
  }
  learning_in_doubt_ = rewrite_replay_ = true;
}

StoreResult<void> DurableStore::archive_foreign_state() {
  // Rows last: by them the next start sees that there is more to rename.
  const char* const(*names[3])[2] = {&replay_names, &learning_names, &row_names};
  const StorageFile(*files[3])[2] = {&replay_, &learning_, &row_};
  const int dir = dir_.descriptor();
  StoreResult<void> failed;
  for (int kind = 0; kind < 3; ++kind) {
    for (int i = 0; i < 2; ++i) {
      // After a power cut in the middle of this some were renamed and made anew: those must not replace the kept ones.
      if (is_blank((*files[kind])[i]) && ::faccessat(dir, kept_names[kind][i], F_OK, 0) == 0) continue;
      if (::renameat(dir, (*names[kind])[i], dir, kept_names[kind][i]) == 0) continue;
      failed = tl::make_unexpected(store_error(errno, "set other state aside"));
    }
  }
  committed_ = {};
  ready_ = open_everything();
  scan();
  if (!failed) return failed;
  refused_ = out_of_reach_ = false;
  return ready_;
}

bool DurableStore::keeps_other() const {
  return ::faccessat(dir_.descriptor(), kept_names[2][0], F_OK, 0) == 0;  // the first of the rows, which come last
}

std::uint64_t DurableStore::run_length(std::uint64_t number, std::uint64_t end) const {
  const std::uint64_t to_wrap = ring_slots() - number % ring_slots();
  return std::min({end - number, to_wrap, std::uint64_t{scratch_bytes_ / stride()}});
}

StoreResult<void> DurableStore::write_replay(std::uint64_t first, std::uint64_t end, std::uint64_t epoch,
                                             std::span<const std::byte> replay) {
  if (first == end) return {};
  const StorageFile& file = replay_[epoch & 1];
  const std::size_t size = layout_.transition_bytes;
  while (first < end) {
    const std::uint64_t run = run_length(first, end);
    std::memset(scratch_.get(), 0, static_cast<std::size_t>(run) * stride());
    for (std::uint64_t i = 0; i < run; ++i) {
      const std::uint64_t number = first + i;
      const auto slot = static_cast<std::size_t>(number % layout_.ring_capacity);
      const auto bytes = replay.subspan(slot * size, size);
      const JournalEntry entry{number, digest64(bytes, number ^ (epoch << 40))};
      std::byte* at = scratch_.get() + static_cast<std::size_t>(i) * stride();
      std::memcpy(at, &entry, sizeof entry);
      std::memcpy(at + sizeof entry, bytes.data(), size);
    }
    const auto done = file.write_at({scratch_.get(), static_cast<std::size_t>(run) * stride()},
                                    first % ring_slots() * stride(), "write replay journal");
    if (!done) return done;
    first += run;
  }
  return file.sync(sync_, "sync replay journal");
}

StoreResult<void> DurableStore::write_record(const StorageFile& file, const RecordHeader& header,
                                             const StoredState& state) const {
  const bool learning = header.kind == static_cast<std::uint32_t>(RecordKind::learning);
  const char* step = learning ? "write learning record" : "write row record";
  std::byte front[payload_offset] = {};
  std::memcpy(front, &header, sizeof header);
  if (const auto done = file.write_at(front, 0, step); !done) return done;
  std::size_t at = payload_offset;
  if (learning) {
    if (const auto done = file.write_at(state.learning, at, step); !done) return done;
    at += state.learning.size();
  }
  if (const auto done = file.write_at(state.row, at, step); !done) return done;
  return file.sync(sync_, learning ? "sync learning record" : "sync row record");
}

StoreResult<void> DurableStore::commit(const StoredState& state) {
  if (state.learning.size() != layout_.learning_bytes || state.row.size() != layout_.row_bytes ||
      state.replay.size() != layout_.transition_bytes * layout_.ring_capacity) {
    return fail(StoreFault::wrong_size, "commit state");
  }
  if (ready_ && (dir_.is_replaced_at(path_.c_str()) || lacks_files())) {
    release_files();
    return ready_ = fail(StoreFault::removed, "commit state");
  }
  if (!ready_) {
    if (dir_.is_open() && dir_.is_replaced_at(path_.c_str()))
      release_files();  // or a medium mounted there is never seen
    ready_ = make_ready();
    if (!ready_) return ready_;
  }
  if (out_of_reach_) {
    scan();
    if (highest_generation_ > 0 || other_layout_) return fail(StoreFault::unread, "commit state");
    out_of_reach_ = false;
  }
  if (refused_) return fail(StoreFault::unread, "commit state");
  learning_in_doubt_ = learning_in_doubt_ || state.learning_changed;
  rewrite_replay_ = rewrite_replay_ || state.replay_count < committed_.replay_count ||
                    state.replay_count - committed_.replay_count > layout_.spare_slots;

  Committed next = committed_;
  next.generation = highest_generation_ + 1;
  next.replay_count = state.replay_count;
  next.log = state.log;
  if (rewrite_replay_) ++next.epoch;
  const std::uint64_t first = rewrite_replay_ ? first_transition(state.replay_count)
                                              : std::max(committed_.replay_count, first_transition(state.replay_count));
  if (const auto done = write_replay(first, state.replay_count, next.epoch, state.replay); !done) return done;

  RecordHeader header;
  header.layout = layout_.hash();
  header.generation = next.generation;
  header.epoch = next.epoch;
  header.replay_count = next.replay_count;
  header.log_day = next.log.day;
  header.log_bytes = next.log.bytes;
  header.log_part = next.log.part;
  if (learning_in_doubt_) {
    next.learning_slot = 1 - committed_.learning_slot;
    next.learning_generation = next.generation;
    next.learning_digest = digest64(state.learning);
    header.kind = static_cast<std::uint32_t>(RecordKind::learning);
    header.payload_bytes = state.learning.size() + state.row.size();
    header.payload_digest = digest64(state.row, next.learning_digest);
    header.learning_generation = next.learning_generation;
    header.learning_digest = next.learning_digest;
    header.header_digest = header.digest();
    if (const auto done = write_record(learning_[next.learning_slot], header, state); !done) return done;
  }

  next.row_slot = 1 - committed_.row_slot;
  header.kind = static_cast<std::uint32_t>(RecordKind::row);
  header.payload_bytes = state.row.size();
  header.payload_digest = digest64(state.row);
  header.learning_generation = next.learning_generation;
  header.learning_digest = next.learning_digest;
  header.header_digest = header.digest();
  // The number is spent even if the write fails: a record that may have reached the medium must not share it.
  highest_generation_ = next.generation;
  if (const auto done = write_record(row_[next.row_slot], header, state); !done) return done;

  committed_ = next;
  learning_in_doubt_ = false;
  rewrite_replay_ = false;
  return {};
}

}  // namespace airside::hal
