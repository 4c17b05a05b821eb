// Preloaded into a real airsided (LD_PRELOAD), it stands between the program and libc: it counts the calls that reach
// files below one folder, records those that change them, fails those that a test chooses, and kills the process at
// one.
//   AIRSIDE_IO_ROOT=FOLDER         only files below it count
//   AIRSIDE_IO_LOG=FILE            appends the record (io_record.hpp)
//   AIRSIDE_IO_KILL=N[:PHASE]      SIGKILL at call N (from 0): 0 before it, 1 within it (half of a write), 2 after it
//   AIRSIDE_IO_FAIL=N:COUNT:ERRNO  calls N .. N + COUNT - 1 fail; a failing write still writes half of its bytes
//   AIRSIDE_IO_FAIL_EVERY=N:ERRNO  every N-th call from 400 on fails
//   AIRSIDE_IO_COUNT=FILE          at the end: calls, "killed" or "ended", open files at call 400 and a late one,
//   threads AIRSIDE_ALLOC_FAIL=N:COUNT     allocations N .. N + COUNT - 1 of the process fail AIRSIDE_ALLOC_COUNT=FILE
//   at the end: allocations
// No heap, no locks: airsided has one thread.

#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "hal/storage/folder_names.hpp"
#include "power_loss/io_record.hpp"

namespace {

using airside::power_loss::IoEntry;
using airside::power_loss::IoKind;

constexpr std::size_t path_bytes = 1024;
constexpr int most_files = 1024;

template <class F>
F* next(const char* name) {
  return reinterpret_cast<F*>(::dlsym(RTLD_NEXT, name));
}

struct Probe {
  std::array<char, path_bytes> root{};
  std::size_t root_bytes = 0;
  int log = -1, count_file = -1;
  long calls = 0, kill_at = -1, fail_at = -1, fail_count = 0;
  long fail_every = 0;
  int kill_phase = 0, fail_errno = 0, files_early = 0, files_late = 0, threads = 0;
  std::array<bool, most_files> watched{};
  std::array<ino_t, most_files> inode{};

  Probe() {
    const char* folder = std::getenv("AIRSIDE_IO_ROOT");
    if (folder == nullptr) return;
    root_bytes = std::strlen(folder);
    if (root_bytes + 1 > root.size()) std::abort();
    std::memcpy(root.data(), folder, root_bytes);
    log = opened("AIRSIDE_IO_LOG", O_APPEND);
    count_file = opened("AIRSIDE_IO_COUNT", O_TRUNC);
    if (const char* text = std::getenv("AIRSIDE_IO_KILL")) {
      char* end = nullptr;
      kill_at = std::strtol(text, &end, 10);
      if (*end == ':') kill_phase = static_cast<int>(std::strtol(end + 1, nullptr, 10));
    }
    if (const char* text = std::getenv("AIRSIDE_IO_FAIL")) {
      char* end = nullptr;
      fail_at = std::strtol(text, &end, 10);
      fail_count = std::strtol(end + 1, &end, 10);
      fail_errno = static_cast<int>(std::strtol(end + 1, nullptr, 10));
    }
    if (const char* text = std::getenv("AIRSIDE_IO_FAIL_EVERY")) {
      char* end = nullptr;
      fail_every = std::strtol(text, &end, 10);
      fail_errno = static_cast<int>(std::strtol(end + 1, nullptr, 10));
    }
    record({.kind = IoKind::start}, "", 0, nullptr);
  }
  ~Probe() { tell("ended"); }

  static int opened(const char* variable, int how) {
    const char* path = std::getenv(variable);
    if (path == nullptr) return -1;
    const auto fd = static_cast<int>(
        next<long(long, ...)>("syscall")(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_CLOEXEC | how, 0644));
    // Out of the way of the program's own small numbers, which it may print or compare.
    return fd < 0 ? fd : ::fcntl(fd, F_DUPFD_CLOEXEC, 900);
  }
  void tell(const char* how) const {
    if (count_file < 0) return;
    std::array<char, 64> line{};
    const int size =
        std::snprintf(line.data(), line.size(), "%ld %s %d %d %d\n", calls, how, files_early, files_late, threads);
    next<long(long, ...)>("syscall")(SYS_write, count_file, line.data(), size);
  }
  static int entries_of(const char* folder) {
    const int fd =
        next<int(int, const char*, int, ...)>("openat")(AT_FDCWD, folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    int count = -3;  // ., .. and the folder itself
    airside::hal::for_each_name(fd, [&count](const char*) {
      ++count;
      return true;
    });
    next<int(int)>("close")(fd);
    return count;
  }
  void die() const {
    tell("killed");
    ::kill(::getpid(), SIGKILL);
    while (true) ::pause();
  }

  /// Full path of `name` below `dir_fd`; false: not below the root.
  bool resolve(int dir_fd, const char* name, std::array<char, path_bytes>& path) const {
    if (root_bytes == 0 || name == nullptr) return false;
    std::size_t used = 0;
    if (name[0] != '/') {
      if (dir_fd == AT_FDCWD) {
        if (::getcwd(path.data(), path.size()) == nullptr) return false;
        used = std::strlen(path.data());
      } else {
        std::array<char, 32> link{};
        std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", dir_fd);
        const ssize_t got = ::readlink(link.data(), path.data(), path.size());
        if (got <= 0) return false;
        used = static_cast<std::size_t>(got);
      }
      path[used++] = '/';
    }
    const std::size_t size = std::strlen(name);
    if (used + size + 1 > path.size()) return false;
    std::memcpy(path.data() + used, name, size + 1);
    return std::strncmp(path.data(), root.data(), root_bytes) == 0 && path[root_bytes] == '/';
  }
  const char* below(const std::array<char, path_bytes>& path) const { return path.data() + root_bytes + 1; }
  bool watches(int fd) const { return fd >= 0 && fd < most_files && watched[static_cast<std::size_t>(fd)]; }
  ino_t inode_of(int fd) const { return inode[static_cast<std::size_t>(fd)]; }

  void record(IoEntry entry, const char* name, std::size_t name_bytes, const void* payload) const {
    if (log < 0) return;
    entry.name_bytes = static_cast<std::uint16_t>(name_bytes);
    const std::array<iovec, 3> parts{iovec{&entry, sizeof entry}, iovec{const_cast<char*>(name), name_bytes},
                                     iovec{const_cast<void*>(payload), entry.payload_bytes}};
    const auto wanted = static_cast<long>(sizeof entry + name_bytes + entry.payload_bytes);
    if (next<long(long, ...)>("syscall")(SYS_writev, log, parts.data(), 3) != wanted) std::abort();
  }
  void record(IoKind kind, const char* name) const { record({.kind = kind}, name, std::strlen(name), nullptr); }
  void record(IoKind kind, int fd, std::uint64_t offset = 0, const void* payload = nullptr,
              std::uint64_t bytes = 0) const {
    record({.kind = kind, .inode = inode_of(fd), .offset = offset, .payload_bytes = bytes}, "", 0, payload);
  }
};

Probe& probe() {
  static Probe the_one;
  return the_one;
}

/// One counted call: what to do with it, and the kill after it.
class Call {
 public:
  Call() : index_(probe().calls++) {
    const Probe& p = probe();
    if (p.kill_at == index_ && p.kill_phase == 0) p.die();
    if (index_ % 1000 == early) {
      int& files = index_ == early ? probe().files_early : probe().files_late;
      files = Probe::entries_of("/proc/self/fd");
      probe().threads = Probe::entries_of("/proc/self/task") + 1;
    }
    fails = (p.fail_at >= 0 && index_ >= p.fail_at && index_ - p.fail_at < p.fail_count) ||
            (p.fail_every > 0 && index_ >= early && index_ % p.fail_every == 0);
    half = p.kill_at == index_ && p.kill_phase == 1;
    if (fails) errno = p.fail_errno;
  }
  ~Call() {
    if (probe().kill_at == index_) probe().die();
  }
  bool fails = false, half = false;

 private:
  static constexpr long early = 400;
  long index_;
};

int fail() {
  probe().record({.kind = IoKind::failed}, "", 0, nullptr);
  errno = probe().fail_errno;
  return -1;
}

int fail_sync(int fd) {
  probe().record(IoKind::failed_sync, fd);
  errno = probe().fail_errno;
  return -1;
}

int open_below(int dir_fd, const char* name, int flags, mode_t mode) {
  const auto real = next<int(int, const char*, int, ...)>("openat");
  std::array<char, path_bytes> path{};
  if (!probe().resolve(dir_fd, name, path)) return real(dir_fd, name, flags, mode);
  const Call call;
  if (call.fails) return fail();
  struct stat status {};
  const bool existed = (flags & O_CREAT) == 0 || ::fstatat(dir_fd, name, &status, AT_SYMLINK_NOFOLLOW) == 0;
  const int fd = real(dir_fd, name, flags, mode);
  if (fd < 0 || fd >= most_files || next<int(int, struct stat*)>("fstat")(fd, &status) != 0) return fd;
  const auto slot = static_cast<std::size_t>(fd);
  probe().watched[slot] = true;
  probe().inode[slot] = status.st_ino;
  if (!existed) {
    probe().record({.kind = IoKind::create, .inode = status.st_ino}, probe().below(path),
                   std::strlen(probe().below(path)), nullptr);
  }
  if (existed && (flags & O_TRUNC) != 0) probe().record(IoKind::truncate, fd);
  return fd;
}

mode_t mode_of(int flags, va_list more) { return (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0; }

/// Counts allocations and fails those that a test chooses.
struct Heap {
  long calls = 0, fail_at = -1, fail_count = 0;
  const char* count_file = nullptr;
  bool asked = false;

  bool fails() {
    if (!asked) {
      asked = true;
      if (const char* text = std::getenv("AIRSIDE_ALLOC_FAIL")) {
        char* end = nullptr;
        fail_at = std::strtol(text, &end, 10);
        fail_count = std::strtol(end + 1, nullptr, 10);
      }
      count_file = std::getenv("AIRSIDE_ALLOC_COUNT");
    }
    const long call = calls++;
    const bool now = fail_at >= 0 && call >= fail_at && call - fail_at < fail_count;
    if (now) errno = ENOMEM;
    return now;
  }
  void tell() const {
    if (count_file == nullptr) return;
    std::array<char, 32> line{};
    const int size = std::snprintf(line.data(), line.size(), "%ld\n", calls);
    const int fd = ::open(count_file, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd >= 0) (void)!::write(fd, line.data(), static_cast<std::size_t>(size));
  }
};
Heap& heap() {
  static constinit Heap the_one;  // asked before any constructor has run
  return the_one;
}
__attribute__((destructor)) void tell_heap() { heap().tell(); }

}  // namespace

extern "C" {

void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);

void* malloc(size_t size) { return heap().fails() ? nullptr : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return heap().fails() ? nullptr : __libc_calloc(count, size); }
int posix_memalign(void** to, size_t alignment, size_t size) {
  if (heap().fails()) return ENOMEM;
  *to = __libc_memalign(alignment, size);
  return *to == nullptr ? ENOMEM : 0;
}
void* aligned_alloc(size_t alignment, size_t size) {
  return heap().fails() ? nullptr : __libc_memalign(alignment, size);
}
void* realloc(void* old, size_t size) { return heap().fails() ? nullptr : __libc_realloc(old, size); }

int openat(int dir_fd, const char* name, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  return open_below(dir_fd, name, flags, mode);
}

int open(const char* name, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = mode_of(flags, more);
  va_end(more);
  return open_below(AT_FDCWD, name, flags, mode);
}

int close(int fd) {
  if (probe().watches(fd)) probe().watched[static_cast<std::size_t>(fd)] = false;
  return next<int(int)>("close")(fd);
}

ssize_t pwrite(int fd, const void* bytes, size_t size, off_t offset) {
  const auto real = next<ssize_t(int, const void*, size_t, off_t)>("pwrite");
  if (!probe().watches(fd)) return real(fd, bytes, size, offset);
  const Call call;
  if (call.fails || call.half) size /= 2;
  const ssize_t done = real(fd, bytes, size, offset);
  if (done > 0) {
    probe().record(IoKind::write, fd, static_cast<std::uint64_t>(offset), bytes, static_cast<std::uint64_t>(done));
  }
  return call.fails ? fail() : done;
}

ssize_t pread(int fd, void* bytes, size_t size, off_t offset) {
  const auto real = next<ssize_t(int, void*, size_t, off_t)>("pread");
  if (!probe().watches(fd)) return real(fd, bytes, size, offset);
  const Call call;
  return call.fails ? fail() : real(fd, bytes, size, offset);
}

int ftruncate(int fd, off_t size) noexcept {
  const auto real = next<int(int, off_t)>("ftruncate");
  if (!probe().watches(fd)) return real(fd, size);
  const Call call;
  if (call.fails) return fail();
  const int done = real(fd, size);
  if (done == 0) probe().record(IoKind::truncate, fd, static_cast<std::uint64_t>(size));
  return done;
}

int posix_fallocate(int fd, off_t offset, off_t size) {
  const auto real = next<int(int, off_t, off_t)>("posix_fallocate");
  if (!probe().watches(fd)) return real(fd, offset, size);
  const Call call;
  if (call.fails) return probe().fail_errno;
  const int done = real(fd, offset, size);
  if (done == 0) probe().record(IoKind::allocate, fd, static_cast<std::uint64_t>(offset + size));
  return done;
}

int fdatasync(int fd) {
  const auto real = next<int(int)>("fdatasync");
  if (!probe().watches(fd)) return real(fd);
  const Call call;
  if (call.fails) return fail_sync(fd);
  const int done = real(fd);
  if (done == 0) probe().record(IoKind::sync_file, fd);
  return done;
}

int fsync(int fd) {
  const auto real = next<int(int)>("fsync");
  if (!probe().watches(fd)) return real(fd);
  const Call call;
  if (call.fails) return fail();
  const int done = real(fd);
  std::array<char, path_bytes> path{};
  struct stat status {};
  if (done == 0 && next<int(int, struct stat*)>("fstat")(fd, &status) == 0 && S_ISDIR(status.st_mode)) {
    if (probe().resolve(fd, "", path)) {
      path[std::strlen(path.data()) - 1] = '\0';  // the slash before the empty name
      probe().record(IoKind::sync_dir, probe().below(path));
    }
  } else if (done == 0) {
    probe().record(IoKind::sync_file, fd);
  }
  return done;
}

int renameat(int old_dir, const char* old_name, int new_dir, const char* new_name) noexcept {
  const auto real = next<int(int, const char*, int, const char*)>("renameat");
  std::array<char, path_bytes> from{}, to{};
  if (!probe().resolve(old_dir, old_name, from) || !probe().resolve(new_dir, new_name, to)) {
    return real(old_dir, old_name, new_dir, new_name);
  }
  const Call call;
  if (call.fails) return fail();
  const int done = real(old_dir, old_name, new_dir, new_name);
  if (done == 0) {
    std::array<char, 2 * path_bytes> both{};
    const std::size_t first = std::strlen(probe().below(from)) + 1, second = std::strlen(probe().below(to));
    std::memcpy(both.data(), probe().below(from), first);
    std::memcpy(both.data() + first, probe().below(to), second);
    probe().record({.kind = IoKind::rename}, both.data(), first + second, nullptr);
  }
  return done;
}

int rename(const char* old_name, const char* new_name) noexcept {
  return renameat(AT_FDCWD, old_name, AT_FDCWD, new_name);
}

int unlinkat(int dir_fd, const char* name, int flags) noexcept {
  const auto real = next<int(int, const char*, int)>("unlinkat");
  std::array<char, path_bytes> path{};
  if (!probe().resolve(dir_fd, name, path)) return real(dir_fd, name, flags);
  const Call call;
  if (call.fails) return fail();
  const int done = real(dir_fd, name, flags);
  if (done == 0) probe().record(IoKind::unlink, probe().below(path));
  return done;
}

int unlink(const char* name) noexcept { return unlinkat(AT_FDCWD, name, 0); }

int mkdir(const char* name, mode_t mode) noexcept {
  const auto real = next<int(const char*, mode_t)>("mkdir");
  std::array<char, path_bytes> path{};
  if (!probe().resolve(AT_FDCWD, name, path)) return real(name, mode);
  const Call call;
  return call.fails ? fail() : real(name, mode);
}

int fstat(int fd, struct stat* status) noexcept {
  const auto real = next<int(int, struct stat*)>("fstat");
  if (!probe().watches(fd)) return real(fd, status);
  const Call call;
  return call.fails ? fail() : real(fd, status);
}

int flock(int fd, int operation) noexcept {
  const auto real = next<int(int, int)>("flock");
  if (!probe().watches(fd)) return real(fd, operation);
  const Call call;
  return call.fails ? fail() : real(fd, operation);
}

DIR* fdopendir(int fd) {
  const auto real = next<DIR*(int)>("fdopendir");
  if (!probe().watches(fd)) return real(fd);
  const Call call;
  if (!call.fails) return real(fd);
  fail();
  return nullptr;
}

}  // extern "C"
