#include "hal/storage/storage_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <utility>

namespace airside::hal {
namespace {

auto failed(const char* step) { return tl::make_unexpected(store_error(errno, step)); }

StoreResult<StorageFile> open_regular(int dir_fd, const char* name, int flags, const char* step) {
  const int fd = ::openat(dir_fd, name, flags | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, 0640);
  if (fd < 0) return failed(step);
  StorageFile file(fd);
  struct stat status {};
  if (::fstat(fd, &status) != 0) return failed(step);
  if (!S_ISREG(status.st_mode)) return tl::make_unexpected(store_error(S_ISDIR(status.st_mode) ? EISDIR : ENXIO, step));
  return file;
}

}  // namespace

StorageFile& StorageFile::operator=(StorageFile&& other) noexcept {
  if (this != &other) {
    close();
    descriptor_ = other.descriptor_;
    other.descriptor_ = -1;
  }
  return *this;
}

void StorageFile::close() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

StoreResult<StorageFile> StorageFile::open(int dir_fd, const char* name, bool create, const char* step) {
  return open_regular(dir_fd, name, O_RDWR | (create ? O_CREAT : 0), step);
}

StoreResult<StorageFile> StorageFile::open_to_read(int dir_fd, const char* name, const char* step) {
  return open_regular(dir_fd, name, O_RDONLY, step);
}

StoreResult<StorageFile> StorageFile::open_existing_dir(const char* path, FolderLink link) {
  constexpr int flags = O_RDONLY | O_DIRECTORY | O_CLOEXEC;
  constexpr const char* step = "open folder";
  // A path that ends in a slash names what the link points to.
  std::array<char, PATH_MAX> name{};
  std::size_t size = std::strlen(path);
  if (size >= name.size()) return tl::make_unexpected(store_error(ENAMETOOLONG, step));
  while (size > 1 && path[size - 1] == '/') --size;
  std::memcpy(name.data(), path, size);
  const int fd = ::open(name.data(), flags | O_NOFOLLOW);
  if (fd >= 0) return StorageFile(fd);
  const int error = errno;
  struct stat status {};
  if (error != ENOTDIR && error != ELOOP) return tl::make_unexpected(store_error(error, step));
  if (::fstatat(AT_FDCWD, name.data(), &status, AT_SYMLINK_NOFOLLOW) != 0) return failed(step);
  if (!S_ISLNK(status.st_mode)) return tl::make_unexpected(store_error(error, step));
  // Who may replace an administrator's link between these two calls may as well replace the folder itself.
  if (link == FolderLink::refused || (status.st_uid != 0 && status.st_uid != ::geteuid())) {
    return tl::make_unexpected(store_error(ELOOP, step));
  }
  const int followed = ::open(name.data(), flags);
  if (followed < 0) return failed(step);
  return StorageFile(followed);
}

StoreResult<StorageFile> StorageFile::open_dir(const char* path, FolderLink link) {
  const bool made = ::mkdir(path, 0750) == 0;
  if (!made && errno != EEXIST && errno != EROFS) return failed("make folder");
  auto folder = open_existing_dir(path, link);
  if (folder && made) {
    // A folder whose name is lost takes everything in it along, however often that was synced.
    const StorageFile parent(::openat(folder->descriptor(), "..", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (parent.is_open()) (void)::fsync(parent.descriptor());
  }
  return folder;
}

bool StorageFile::is_unlinked() const {
  struct stat held {};
  return ::fstat(descriptor_, &held) == 0 && held.st_nlink == 0;
}

bool StorageFile::is_replaced_at(const char* path) const {
  struct stat held {
  }, named{};
  if (::fstat(descriptor_, &held) != 0) return false;
  if (::stat(path, &named) != 0) return errno == ENOENT || held.st_nlink == 0;
  return std::pair(held.st_dev, held.st_ino) != std::pair(named.st_dev, named.st_ino);
}

StoreResult<void> StorageFile::write_at(std::span<const std::byte> bytes, std::uint64_t offset,
                                        const char* step) const {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0) {
      if (errno == EINTR) continue;
      return failed(step);
    }
    if (written == 0) return tl::make_unexpected(StoreError{StoreFault::io, 0, step});
    bytes = bytes.subspan(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
  return {};
}

StoreResult<std::size_t> StorageFile::read_at(std::span<std::byte> bytes, std::uint64_t offset,
                                              const char* step) const {
  std::size_t total = 0;
  while (total < bytes.size()) {
    const ssize_t got =
        ::pread(descriptor_, bytes.data() + total, bytes.size() - total, static_cast<off_t>(offset + total));
    if (got < 0) {
      if (errno == EINTR) continue;
      return failed(step);
    }
    if (got == 0) break;
    total += static_cast<std::size_t>(got);
  }
  return total;
}

StoreResult<std::uint64_t> StorageFile::size(const char* step) const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) return failed(step);
  return static_cast<std::uint64_t>(status.st_size);
}

StoreResult<void> StorageFile::truncate(std::uint64_t size, const char* step) const {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) return failed(step);
  return {};
}

StoreResult<void> StorageFile::reserve(std::uint64_t size, const char* step) const {
  const int error = ::posix_fallocate(descriptor_, 0, static_cast<off_t>(size));
  if (error != 0) return tl::make_unexpected(store_error(error, step));
  return {};
}

StoreResult<void> StorageFile::sync(Sync mode, const char* step) const {
  if (mode == Sync::full && ::fdatasync(descriptor_) != 0) return failed(step);
  return {};
}

}  // namespace airside::hal
