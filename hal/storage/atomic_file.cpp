#include "hal/storage/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

namespace airside::hal {

StoreResult<void> write_file_atomically(const StorageFile& folder, const std::string& name,
                                        std::span<const std::byte> bytes, Sync sync) {
  const int dir_fd = folder.descriptor();
  const std::string staged = name + '.' + std::to_string(::getpid()) + ".new";
  const auto failed = [&](StoreError error) {
    ::unlinkat(dir_fd, staged.c_str(), 0);
    return tl::make_unexpected(error);
  };
  {
    ::unlinkat(dir_fd, staged.c_str(), 0);
    // A file of our own: whoever may write to the folder may have put a link or a pipe there.
    constexpr int flags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
    const int fd = ::openat(dir_fd, staged.c_str(), flags, 0640);
    if (fd < 0) return tl::make_unexpected(store_error(errno, "create staged file"));
    const StorageFile file(fd);
    if (const auto done = file.write_at(bytes, 0, "write staged file"); !done) return failed(done.error());
    if (const auto done = file.sync(sync, "sync staged file"); !done) return failed(done.error());
  }
  if (::renameat(dir_fd, staged.c_str(), dir_fd, name.c_str()) != 0) {
    return failed(store_error(errno, "rename staged file"));
  }
  if (sync == Sync::full && ::fsync(dir_fd) != 0) return tl::make_unexpected(store_error(errno, "sync folder"));
  return {};
}

StoreResult<void> write_file_atomically(const std::string& path, std::span<const std::byte> bytes, Sync sync) {
  const std::filesystem::path place(path);
  const std::string parent = place.parent_path().string();
  const StorageFile folder(::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.is_open()) return tl::make_unexpected(store_error(errno, "open folder"));
  return write_file_atomically(folder, place.filename().string(), bytes, sync);
}

}  // namespace airside::hal
