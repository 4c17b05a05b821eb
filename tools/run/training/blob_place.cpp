#include "tools/run/training/blob_place.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "hal/text/input_error.hpp"
#include "hal/weights/blob_file.hpp"

namespace airside::tools {

namespace {

/// 0, or what hindered it.
int write_and_sync(int file, std::span<const std::byte> bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::pwrite(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return n < 0 ? errno : ENOSPC;
    done += static_cast<std::size_t>(n);
  }
  if (::ftruncate(file, static_cast<off_t>(bytes.size())) != 0 || ::fsync(file) != 0) return errno;
  return 0;
}

}  // namespace

BlobPlace::BlobPlace(std::string path, std::size_t bytes) : path_(std::move(path)), part_(path_ + ".part") {
  hal::check_blob_place(path_);
  unfinished_.emplace(part_);
  file_ = ::open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666);
  const int error = file_ < 0 ? errno : ::posix_fallocate(file_, 0, static_cast<off_t>(bytes));
  if (error == 0 || (file_ >= 0 && error == EOPNOTSUPP)) return;
  if (file_ >= 0) {
    ::close(file_);
    ::unlink(part_.c_str());
  }
  throw hal::InputError(path_, fmt::format("no room for the weights: {}", std::strerror(error)),
                        fmt::format("room for {} bytes", bytes), "free some, or choose another output path");
}

BlobPlace::~BlobPlace() {
  if (file_ < 0) return;
  ::close(file_);
  ::unlink(part_.c_str());
}

void BlobPlace::write(std::span<const std::byte> blob) {
  if (const int error = write_and_sync(file_, blob); error != 0) keep_elsewhere(blob, error);
  if (std::rename(part_.c_str(), path_.c_str()) != 0) keep_elsewhere(blob, errno);
  ::close(std::exchange(file_, -1));
  unfinished_.reset();
  const std::string folder = std::filesystem::path(path_).parent_path().string();
  const int opened = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (opened < 0) return;
  ::fsync(opened);
  ::close(opened);
}

void BlobPlace::keep_elsewhere(std::span<const std::byte> blob, int error) {
  const std::string found = fmt::format("a file that cannot be written any more: {}", std::strerror(error));
  std::error_code ignored;
  const std::filesystem::path name = std::filesystem::path(path_).filename();
  std::string kept = (std::filesystem::temp_directory_path(ignored) / ("airside-XXXXXX-" + name.string())).string();
  const int file = ::mkostemps(kept.data(), static_cast<int>(name.string().size()) + 1, O_CLOEXEC);
  const bool whole = file >= 0 && write_and_sync(file, blob) == 0;
  if (file >= 0) ::close(file);
  if (!whole) {
    if (file >= 0) ::unlink(kept.c_str());
    throw hal::InputError(path_, found, "the place that was reserved for the weights",
                          "the weights are lost, since " + kept + " cannot be written either; make room and run again");
  }
  throw hal::InputError(path_, found, "the place that was reserved for the weights",
                        "the weights are kept in " + kept + "; move them from there");
}

}  // namespace airside::tools
