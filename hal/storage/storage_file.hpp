#pragma once
// Whole reads and writes of an open file, with errors as values and without heap.

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/storage/store_error.hpp"

namespace airside::hal {

/// Which symbolic links a folder's last path component may be.
enum class FolderLink : std::uint8_t {
  trusted,  ///< one that root or this process's user made: an administrator may move a folder to another medium
  refused,  ///< none: the folder is shared with other users, and its path can be corrected in the site file instead
};

/// An open file descriptor, closed with its owner.
class StorageFile {
 public:
  StorageFile() = default;
  explicit StorageFile(int descriptor) : descriptor_(descriptor) {}
  ~StorageFile() { close(); }
  StorageFile(StorageFile&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
  StorageFile& operator=(StorageFile&& other) noexcept;

  /// Opens `name` below the folder `dir_fd` for reading and writing, made with mode 0640 if `create`. Whoever may write
  /// to the folder may have put something else there, so no link is followed, no pipe is waited for, and only a regular
  /// file is opened.
  /// Errors: wrong_kind for anything else, here and in open_to_read().
  static StoreResult<StorageFile> open(int dir_fd, const char* name, bool create, const char* step);
  /// Opens `name` for reading alone: what a medium that became read-only still gives.
  static StoreResult<StorageFile> open_to_read(int dir_fd, const char* name, const char* step);
  /// Opens the folder `path`, made if its parent exists; a new one's name is forced to the medium.
  /// Errors: wrong_kind for a link that is not to be followed.
  static StoreResult<StorageFile> open_dir(const char* path, FolderLink link = FolderLink::trusted);
  /// The same for a folder that exists; it is not made.
  static StoreResult<StorageFile> open_existing_dir(const char* path, FolderLink link = FolderLink::trusted);

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
