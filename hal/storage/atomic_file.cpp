#include "hal/storage/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>

#include "hal/storage/storage_file.hpp"

namespace airside::hal {

StoreResult<void> write_file_atomically(const std::string& path, std::span<const std::byte> bytes, Sync sync) {
  const std::string staged = path + '.' + std::to_string(::getpid()) + ".new";
  const auto failed = [&](StoreError error) {
    ::unlink(staged.c_str());
    return tl::make_unexpected(error);
  };
  {
    ::unlink(staged.c_str());
    // A file of our own: whoever may write to the folder may have put a link or a pipe there.
    constexpr int flags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
    const int fd = ::open(staged.c_str(), flags, 0640);
    if (fd < 0) return tl::make_unexpected(store_error(errno, "create staged file"));
    const StorageFile file(fd);
    if (const auto done = file.write_at(bytes, 0, "write staged file"); !done) return failed(done.error());
    if (const auto done = file.sync(sync, "sync staged file"); !done) return failed(done.error());
  }
  if (std::rename(staged.c_str(), path.c_str()) != 0) return failed(store_error(errno, "rename staged file"));
  if (sync == Sync::none) return {};
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const StorageFile dir(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!dir.is_open() || ::fsync(dir.descriptor()) != 0) {
    return tl::make_unexpected(store_error(errno, "sync folder"));
  }
  return {};
}

}  // namespace airside::hal
