#include "power_loss/write_recorder.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <climits>

namespace airside::hal {
namespace {

WriteRecorder* recorder = nullptr;

std::string name_of(int fd) {
  char path[PATH_MAX];
  const ssize_t size = ::readlink(("/proc/self/fd/" + std::to_string(fd)).c_str(), path, sizeof path);
  const std::string text(path, size > 0 ? static_cast<std::size_t>(size) : 0);
  return text.substr(text.rfind('/') + 1);
}

int fail() {
  errno = recorder->fail_errno;
  return -1;
}

}  // namespace

WriteRecorder::WriteRecorder() { recorder = this; }
WriteRecorder::~WriteRecorder() { recorder = nullptr; }

bool WriteRecorder::fails_now() {
  const int call = calls++;
  return fail_at >= 0 && call >= fail_at && call - fail_at < fail_count;
}

}  // namespace airside::hal

using airside::hal::recorder;
using airside::hal::WriteOp;

extern "C" {

ssize_t pwrite(int fd, const void* bytes, size_t size, off_t offset) {
  if (recorder != nullptr) {
    const bool fails = recorder->fails_now();
    if (fails) size /= 2;
    const auto* begin = static_cast<const std::byte*>(bytes);
    recorder->ops.push_back(
        {WriteOp::Kind::write, airside::hal::name_of(fd), static_cast<std::uint64_t>(offset), {begin, begin + size}});
    if (fails) {
      (void)!syscall(SYS_pwrite64, fd, bytes, size, offset);
      return airside::hal::fail();
    }
  }
  return syscall(SYS_pwrite64, fd, bytes, size, offset);
}

int fdatasync(int fd) {
  if (recorder != nullptr) {
    const bool fails = recorder->fails_now();
    recorder->ops.push_back(
        {fails ? WriteOp::Kind::failed_sync : WriteOp::Kind::sync, airside::hal::name_of(fd), 0, {}});
    if (fails) return airside::hal::fail();
  }
  return static_cast<int>(syscall(SYS_fdatasync, fd));
}

int fsync(int fd) {
  if (recorder != nullptr && recorder->fails_now()) return airside::hal::fail();
  return static_cast<int>(syscall(SYS_fsync, fd));
}

int ftruncate(int fd, off_t size) noexcept {
  if (recorder != nullptr) {
    if (recorder->fails_now()) return airside::hal::fail();
    recorder->ops.push_back({WriteOp::Kind::truncate, airside::hal::name_of(fd), static_cast<std::uint64_t>(size), {}});
  }
  return static_cast<int>(syscall(SYS_ftruncate, fd, size));
}

}  // extern "C"
