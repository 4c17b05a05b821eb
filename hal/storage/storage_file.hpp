#pragma once
// Whole reads and writes of an open file, with errors as values and without heap.

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/storage/store_error.hpp"

namespace airside::hal {

/// An open file descriptor, closed with its owner.
class StorageFile {
 public:
  StorageFile() = default;
  explicit StorageFile(int descriptor) : descriptor_(descriptor) {}
  ~StorageFile() { close(); }
  StorageFile(StorageFile&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
  StorageFile& operator=(StorageFile&& other) noexcept;

  /// Opens `name` below the folder `dir_fd` for reading and writing, made with mode 0640 if `create`.
  static StoreResult<StorageFile> open(int dir_fd, const char* name, bool create, const char* step);
  /// Opens `name` for reading alone: what a medium that became read-only still gives.
  static StoreResult<StorageFile> open_to_read(int dir_fd, const char* name, const char* step);
  /// Opens the folder `path`, made if its parent exists; a new one's name is forced to the medium.
  static StoreResult<StorageFile> open_dir(const char* path);

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  void close();

  /// Whether its last name was taken away: what is written to it is gone when it closes.
  bool is_unlinked() const;
  /// Of a folder that was opened at `path`: whether that names another one by now, or none. What cannot be looked at
  /// is no other, here and above: a call that failed once must not give up what is open.
  bool is_replaced_at(const char* path) const;

  /// Writes all bytes at an offset.  Errors: no_space, read_only, io; an unknown part may have been written.
  StoreResult<void> write_at(std::span<const std::byte> bytes, std::uint64_t offset, const char* step) const;
  /// Reads as many bytes as there are, up to the size of the span.
  StoreResult<std::size_t> read_at(std::span<std::byte> bytes, std::uint64_t offset, const char* step) const;
  /// Bytes in the file.
  StoreResult<std::uint64_t> size(const char* step) const;
  StoreResult<void> truncate(std::uint64_t size, const char* step) const;
  /// Reserves the space of `size` bytes, so that later writes in place cannot meet a full disk.
  StoreResult<void> reserve(std::uint64_t size, const char* step) const;
  /// Forces content to the medium. A failure means that the writes since the last success are in doubt and must be
  /// made again: a second call alone proves nothing.
  StoreResult<void> sync(Sync mode, const char* step) const;

 private:
  int descriptor_ = -1;
};

}  // namespace airside::hal
