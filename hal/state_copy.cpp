#include "hal/state_copy.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "hal/digest64.hpp"
#include "hal/storage_file.hpp"

namespace airside::hal {
namespace {

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

StoreResult<void> StateCopy::save(std::span<const std::byte> learning) {
  const auto folder = StorageFile::open_dir(dir_.c_str());
  if (!folder) return tl::make_unexpected(folder.error());
  const auto file = StorageFile::open(folder->descriptor(), "previous.new", true, "open copy of state");
  if (!file) return tl::make_unexpected(file.error());
  const CopyHeader header{copy_magic, meaning_, learning.size(), digest64(learning, meaning_)};
  StoreResult<void> done = file->truncate(0, "truncate copy of state");
  if (done) done = file->write_at(std::as_bytes(std::span(&header, 1)), 0, "write copy of state");
  if (done) done = file->write_at(learning, sizeof header, "write copy of state");
  if (done) done = file->sync(sync_, "sync copy of state");
  if (!done) {
    ::unlinkat(folder->descriptor(), "previous.new", 0);
    return done;
  }
  if (::renameat(folder->descriptor(), "previous.new", folder->descriptor(), "previous") != 0) {
    return tl::make_unexpected(store_error(errno, "rename copy of state"));
  }
  if (sync_ == Sync::full && ::fsync(folder->descriptor()) != 0) {
    return tl::make_unexpected(store_error(errno, "sync folder"));
  }
  return {};
}

StoreResult<void> StateCopy::load(std::span<std::byte> into) const {
  const auto folder = StorageFile::open_dir(dir_.c_str());
  if (!folder) return tl::make_unexpected(folder.error());
  const auto file = StorageFile::open(folder->descriptor(), "previous", false, "open copy of state");
  if (!file) return tl::make_unexpected(file.error());
  CopyHeader header;
  const auto head = file->read_at(std::as_writable_bytes(std::span(&header, 1)), 0, "read copy of state");
  if (!head) return tl::make_unexpected(head.error());
  if (*head != sizeof header || header.magic != copy_magic) return failed(StoreFault::io, "read copy of state");
  if (header.meaning != meaning_) return failed(StoreFault::other_layout, "read copy of state");
  if (header.bytes != into.size()) return failed(StoreFault::wrong_size, "read copy of state");
  const auto got = file->read_at(into, sizeof header, "read copy of state");
  if (!got) return tl::make_unexpected(got.error());
  if (*got != into.size() || header.digest != digest64(into, meaning_)) {
    return failed(StoreFault::io, "check copy of state");
  }
  return {};
}

}  // namespace airside::hal
