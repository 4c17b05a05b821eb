#include "hal/storage/state_copy.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "hal/storage/digest64.hpp"
#include "hal/storage/storage_file.hpp"

namespace airside::hal {
namespace {

constexpr const char* staged_name = "previous.new";
constexpr const char* settled_name = "previous";
constexpr std::uint64_t copy_magic = 0x3156455250524941u;  // "AIRPREV1" in file order

/// Before the learning state.
struct CopyHeader {
  std::uint64_t magic = copy_magic;
  std::uint64_t meaning = 0;
  std::uint64_t bytes = 0;
  std::uint64_t digest = 0;  ///< of the learning state, seeded with meaning
};
static_assert(sizeof(CopyHeader) == 32);

auto failed(StoreFault fault, const char* step) { return tl::make_unexpected(StoreError{fault, 0, step}); }

}  // namespace

StoreResult<void> StateCopy::settle(std::uint64_t digest) {
  const auto folder = StorageFile::open_dir(dir_.c_str());
  if (!folder) return tl::make_unexpected(folder.error());
  {
    const auto file = StorageFile::open(folder->descriptor(), staged_name, false, "open copy of state");
    CopyHeader header;
    if (!file || !file->read_at(std::as_writable_bytes(std::span(&header, 1)), 0, "read copy of state")) return {};
    if (header.magic != copy_magic || header.digest != digest) return {};
  }
  if (::renameat(folder->descriptor(), staged_name, folder->descriptor(), settled_name) != 0) {
    return tl::make_unexpected(store_error(errno, "rename copy of state"));
  }
  if (sync_ == Sync::full && ::fsync(folder->descriptor()) != 0) {
    return tl::make_unexpected(store_error(errno, "sync folder"));
  }
  return {};
}

StoreResult<std::uint64_t> StateCopy::save(std::span<const std::byte> learning, std::uint64_t in_force) {
  // A crash may have left the copy in force under the name that is written now.
  if (const auto done = settle(in_force); !done) return tl::make_unexpected(done.error());
  const auto folder = StorageFile::open_dir(dir_.c_str());
  if (!folder) return tl::make_unexpected(folder.error());
  const auto file = StorageFile::open(folder->descriptor(), staged_name, true, "open copy of state");
  if (!file) return tl::make_unexpected(file.error());
  const CopyHeader header{copy_magic, meaning_, learning.size(),
                          std::max<std::uint64_t>(digest64(learning, meaning_), 1)};
  StoreResult<void> done = file->truncate(0, "truncate copy of state");
  if (done) done = file->write_at(std::as_bytes(std::span(&header, 1)), 0, "write copy of state");
  if (done) done = file->write_at(learning, sizeof header, "write copy of state");
  if (done) done = file->sync(sync_, "sync copy of state");
  if (done && sync_ == Sync::full && ::fsync(folder->descriptor()) != 0) {
    done = tl::make_unexpected(store_error(errno, "sync folder"));
  }
  if (!done) {
    ::unlinkat(folder->descriptor(), staged_name, 0);
    return tl::make_unexpected(done.error());
  }
  return header.digest;
}

StoreResult<void> StateCopy::load_from(const char* name, std::span<std::byte> into, std::uint64_t digest) const {
  const auto folder = StorageFile::open_dir(dir_.c_str());
  if (!folder) return tl::make_unexpected(folder.error());
  const auto file = StorageFile::open_to_read(folder->descriptor(), name, "open copy of state");
  if (!file) return tl::make_unexpected(file.error());
  CopyHeader header;
  const auto head = file->read_at(std::as_writable_bytes(std::span(&header, 1)), 0, "read copy of state");
  if (!head) return tl::make_unexpected(head.error());
  if (*head != sizeof header || header.magic != copy_magic) return failed(StoreFault::io, "read copy of state");
  if (header.meaning != meaning_) return failed(StoreFault::other_layout, "read copy of state");
  if (header.digest != digest) return failed(StoreFault::not_found, "look for copy of state");
  if (header.bytes != into.size()) return failed(StoreFault::wrong_size, "read copy of state");
  const auto got = file->read_at(into, sizeof header, "read copy of state");
  if (!got) return tl::make_unexpected(got.error());
  if (*got != into.size() || header.digest != std::max<std::uint64_t>(digest64(into, meaning_), 1)) {
    return failed(StoreFault::io, "check copy of state");
  }
  return {};
}

StoreResult<void> StateCopy::load(std::span<std::byte> into, std::uint64_t digest) const {
  if (digest == 0) return failed(StoreFault::not_found, "look for copy of state");
  const auto staged = load_from(staged_name, into, digest);
  if (staged) return staged;
  const auto settled = load_from(settled_name, into, digest);
  return settled || !may_pass(staged.error()) ? settled : staged;
}

StoreResult<void> StateCopy::blocked() const {
  const auto folder = StorageFile::open_existing_dir(dir_.c_str());
  if (!folder) return {};  // of which the state itself complains
  for (const char* name : {staged_name, settled_name}) {
    const auto file = StorageFile::open_to_read(folder->descriptor(), name, "look at copy of state");
    if (!file && file.error().fault == StoreFault::wrong_kind) return tl::make_unexpected(file.error());
  }
  return {};
}

}  // namespace airside::hal
