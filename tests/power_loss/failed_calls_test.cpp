// Every system call of a short life of the store, the log and the small files beside them fails once, or from then on:
// what was told to be written is there afterwards, the rest is old or new, and the next life goes on from it.
// The calls that fail on demand stand in for the C library's in this program.

#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstring>
#include <functional>
#include <map>

#include "hal/log/row_log.hpp"
#include "hal/storage/atomic_file.hpp"
#include "hal/storage/durable_store.hpp"
#include "hal/storage/start_ledger.hpp"
#include "hal/storage/state_copy.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/weights/mailbox.hpp"
#include "support/test_folder.hpp"

namespace {

/// Which of the calls fail. `error` 0: the call does nothing and says so (a write of 0 bytes).
struct Failing {
  int at = 0;           ///< number of the first call that fails, from 1; 0: none
  bool sticky = false;  ///< all later ones too
  int error = EIO;
  int calls = 0;
  bool writes_only = false;

  bool due(bool writes) {
    if (at == 0 || (writes_only && !writes)) return false;
    ++calls;
    if (calls != at && !(sticky && calls > at)) return false;
    errno = error;
    return true;
  }
} failing;

template <class... Arguments>
long kernel(long number, Arguments... arguments) {
  static const auto real = reinterpret_cast<long (*)(long, ...)>(dlsym(RTLD_NEXT, "syscall"));
  return real(number, arguments...);
}
int failed() { return failing.error == 0 ? 0 : -1; }

}  // namespace

// Names and types are the C library's.
extern "C" {
ssize_t pwrite(int fd, const void* bytes, size_t size, off_t offset) {
  return failing.due(true) ? failed() : kernel(SYS_pwrite64, fd, bytes, size, offset);
}
ssize_t pread(int fd, void* bytes, size_t size, off_t offset) {
  return failing.due(false) ? failed() : kernel(SYS_pread64, fd, bytes, size, offset);
}
int fdatasync(int fd) { return failing.due(true) ? -1 : static_cast<int>(kernel(SYS_fdatasync, fd)); }
int fsync(int fd) { return failing.due(true) ? -1 : static_cast<int>(kernel(SYS_fsync, fd)); }
int ftruncate(int fd, off_t size) noexcept {
  return failing.due(true) ? -1 : static_cast<int>(kernel(SYS_ftruncate, fd, size));
}
int posix_fallocate(int fd, off_t offset, off_t size) {
  if (failing.due(true)) return failing.error;
  return kernel(SYS_fallocate, fd, 0, offset, size) == 0 ? 0 : errno;
}
int fstat(int fd, struct stat* status) noexcept {
  return failing.due(false) ? -1 : static_cast<int>(kernel(SYS_fstat, fd, status));
}
int fstatat(int dir, const char* name, struct stat* status, int flags) noexcept {
  return failing.due(false) ? -1 : static_cast<int>(kernel(SYS_newfstatat, dir, name, status, flags));
}
int openat(int dir, const char* name, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const auto mode = va_arg(rest, mode_t);
  va_end(rest);
  return failing.due((flags & O_ACCMODE) != O_RDONLY) ? -1
                                                      : static_cast<int>(kernel(SYS_openat, dir, name, flags, mode));
}
int open(const char* name, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const auto mode = va_arg(rest, mode_t);
  va_end(rest);
  return failing.due(false) ? -1 : static_cast<int>(kernel(SYS_open, name, flags, mode));
}
int mkdir(const char* name, mode_t mode) noexcept {
  return failing.due(true) ? -1 : static_cast<int>(kernel(SYS_mkdir, name, mode));
}
int flock(int fd, int operation) noexcept {
  return failing.due(false) ? -1 : static_cast<int>(kernel(SYS_flock, fd, operation));
}
int unlinkat(int dir, const char* name, int flags) noexcept {
  return failing.due(true) ? -1 : static_cast<int>(kernel(SYS_unlinkat, dir, name, flags));
}
int renameat(int from_dir, const char* from, int to_dir, const char* to) noexcept {
  return failing.due(true) ? -1 : static_cast<int>(kernel(SYS_renameat, from_dir, from, to_dir, to));
}
int faccessat(int dir, const char* name, int mode, int flags) noexcept {
  return failing.due(true) ? -1 : static_cast<int>(kernel(SYS_faccessat2, dir, name, mode, flags));
}
off_t lseek(int fd, off_t offset, int whence) noexcept {
  return failing.due(false) ? -1 : kernel(SYS_lseek, fd, offset, whence);
}
long syscall(long number, ...) noexcept {
  va_list rest;
  va_start(rest, number);
  const long a = va_arg(rest, long), b = va_arg(rest, long), c = va_arg(rest, long);
  const long d = va_arg(rest, long), e = va_arg(rest, long), f = va_arg(rest, long);
  va_end(rest);
  return number == SYS_getdents64 && failing.due(false) ? -1 : kernel(number, a, b, c, d, e, f);
}
}

namespace airside::hal {
namespace {

/// Runs `life` with each of its calls failing, then `after` with none.
void fail_each_call(const std::function<void()>& life, const std::function<void(const std::string&)>& after) {
  struct Way {
    int error;
    bool sticky, writes_only;
  };
  // An interrupted call is never for ever, and a write of nothing is none of reads and opens.
  for (const Way way :
       {Way{EIO, false, false}, Way{EIO, true, false}, Way{ENOSPC, false, true}, Way{ENOSPC, true, true},
        Way{EROFS, false, true}, Way{EROFS, true, true}, Way{EINTR, false, false}, Way{0, false, true}}) {
    for (int at = 1;; ++at) {
      failing = {at, way.sticky, way.error, 0, way.writes_only};
      life();
      const bool reached = failing.calls >= at;
      failing = {};
      after("errno " + std::to_string(way.error) + (way.sticky ? " from call " : " at call ") + std::to_string(at));
      if (!reached || ::testing::Test::HasFatalFailure()) break;
      ASSERT_LT(at, 2000);
    }
  }
}

/// What the test itself does meanwhile does not fail and is not counted.
class InPeace {
 public:
  InPeace() : kept_(failing) { failing.at = 0; }
  ~InPeace() { failing = kept_; }
  InPeace(const InPeace&) = delete;
  InPeace& operator=(const InPeace&) = delete;

 private:
  Failing kept_;
};

constexpr StoreLayout layout{16, 8, 8, 4, 2, 7};

struct Memory {
  std::array<std::byte, layout.learning_bytes> learning{};
  std::array<std::byte, layout.row_bytes> row{};
  std::array<std::byte, layout.ring_capacity * layout.transition_bytes> replay{};
  std::uint64_t count = 0;
  StateBuffers buffers() { return {learning, row, replay}; }
};

TEST(FailedCalls, LeaveTheStoreOnAGenerationThatWasCommittedAndNoOlderThanTheLastConfirmed) {
  const TestFolder folder("failed_store");
  std::map<std::uint8_t, Memory> attempted;
  std::uint8_t attempt = 0, confirmed = 0;
  /// Opens, loads, and commits thrice; what each commit was to write is noted.
  const auto live = [&] {
    auto store = DurableStore::open(folder.c_str(), layout);
    if (!store) return;
    Memory memory;
    const auto loaded = store->load(memory.buffers());
    if (!loaded || loaded->outcome == LoadOutcome::none) memory = {};
    if (loaded) memory.count = loaded->replay_count;
    for (int k = 0; k < 3; ++k) {
      memory.row[0] = memory.learning[0] = static_cast<std::byte>(++attempt);
      memory.replay[memory.count % layout.ring_capacity * layout.transition_bytes] = static_cast<std::byte>(attempt);
      ++memory.count;
      attempted[attempt] = memory;
      const auto done = store->commit({memory.learning, memory.row, memory.replay, memory.count, {}, true});
      if (done) confirmed = attempt;
      if (!done && done.error().fault == StoreFault::unread) return;  // it must be loaded first
    }
  };
  fail_each_call(
      [&] {
        attempted.clear();
        attempt = confirmed = 0;
        live();
        live();
      },
      [&](const std::string& what) {
        {
          auto store = DurableStore::open(folder.c_str(), layout);
          ASSERT_TRUE(store && store->ready()) << what;
          Memory found;
          const auto loaded = store->load(found.buffers());
          ASSERT_TRUE(loaded) << what;
          ASSERT_TRUE(confirmed == 0 || loaded->outcome != LoadOutcome::none) << what;
          if (loaded->outcome != LoadOutcome::none) {
            const auto number = static_cast<std::uint8_t>(found.row[0]);
            ASSERT_EQ(attempted.count(number), 1u) << what;
            const Memory& wrote = attempted[number];
            EXPECT_GE(number, confirmed) << what;
            EXPECT_EQ(found.learning, wrote.learning) << what;
            EXPECT_TRUE(loaded->outcome == LoadOutcome::replay_incomplete || loaded->replay_count == wrote.count)
                << what;
          }
          EXPECT_TRUE(store->commit({found.learning, found.row, found.replay, loaded->replay_count, {}, true})) << what;
        }
        for (const auto& entry : std::filesystem::directory_iterator(folder.c_str())) std::filesystem::remove(entry);
      });
}

const TopologyCounts& counts() {
  static const TopologyCounts one{"1vav-0fcu-1power", 1, 0, 1};
  return one;
}

TEST(FailedCalls, LeaveInTheLogExactlyTheRowsThatWereTaken) {
  const TestFolder folder("failed_log");
  std::vector<std::string> taken;
  constexpr RowLogLimits limits{.max_files = 20, .max_file_bytes = 400};
  const auto live = [&](int first) {
    RowLog log(folder.c_str(), counts(), limits);
    (void)log.resume({});
    LogRow row = make_log_row(counts());
    for (int k = first; k < first + 6; ++k) {
      row.time = {1625183640 + 40 * k * row_s};  // over midnight
      const auto done = log.append(row);
      if (done) taken.push_back(civil_text(row.time));
      (void)log.sync();
    }
  };
  fail_each_call(
      [&] {
        taken.clear();
        live(0);
        live(6);
      },
      [&](const std::string& what) {
        const auto log = RowLog::open(folder.c_str(), counts(), limits);
        ASSERT_TRUE(log) << what;
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::directory_iterator(folder.c_str())) files.push_back(entry.path());
        std::ranges::sort(files);
        std::vector<std::string> rows;
        for (const auto& file : files) {
          std::ifstream in(file);
          std::string line;
          for (std::getline(in, line); std::getline(in, line);) rows.push_back(line.substr(0, civil_text_size));
          std::filesystem::remove(file);
        }
        EXPECT_EQ(rows, taken) << what;
      });
}

TEST(FailedCalls, LeaveALogOfAFewFilesWithItsCommittedRowsAndNoneThatWereCutOff) {
  const TestFolder folder("failed_few");
  constexpr RowLogLimits limits{.max_files = 3, .max_file_bytes = 4000};
  constexpr std::int64_t rows_apart_s = 80 * row_s, begin_s = 1625097600;  // three rows a day, from midnight
  std::vector<std::int64_t> taken, beyond;  ///< beyond: what the first life took after its last commit
  std::int64_t committed_s = 0;
  bool cut = false;
  const auto append = [&](RowLog& log, int from, int to) {
    LogRow row = make_log_row(counts());
    for (int k = from; k < to; ++k) {
      row.time = {begin_s + k * rows_apart_s};
      if (log.append(row)) taken.push_back(row.time.seconds);
    }
  };
  fail_each_call(
      [&] {
        taken.clear(), beyond.clear();
        committed_s = 0, cut = false;
        LogPosition committed;
        {
          RowLog log(folder.c_str(), counts(), limits);
          (void)log.resume({});
          append(log, 0, 8);
          if (log.sync() && !taken.empty()) committed = log.position(), committed_s = taken.back();
          const std::size_t kept = taken.size();
          append(log, 8, 11);
          beyond.assign(taken.begin() + static_cast<std::ptrdiff_t>(kept), taken.end());
        }
        {
          const InPeace peace;
          // The process died in the middle of a row of the newest file.
          std::filesystem::path newest;
          for (const auto& entry : std::filesystem::directory_iterator(folder.c_str())) {
            newest = std::max(newest, entry.path());
          }
          if (!newest.empty()) std::ofstream(newest, std::ios::app) << "2021-07-";
          std::ofstream(folder.file("airside-2021-08-01.csv")) << "no row\n";
        }
        RowLog log(folder.c_str(), counts(), limits);
        (void)log.resume(committed);
        const std::size_t before = taken.size();
        append(log, 14, 20);
        cut = committed.bytes > 0 && taken.size() > before;
      },
      [&](const std::string& what) {
        {
          const auto log = RowLog::open(folder.c_str(), counts(), limits);
          ASSERT_TRUE(log) << what;
          EXPECT_LE(log->files(), 3u) << what;
        }
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::directory_iterator(folder.c_str())) files.push_back(entry.path());
        std::ranges::sort(files);
        EXPECT_LE(files.size(), 3u) << what;
        std::vector<std::int64_t> rows;
        for (const auto& file : files) {
          std::ifstream in(file);
          std::string line;
          for (std::getline(in, line); std::getline(in, line);) {
            const auto time = parse_civil_text(line.substr(0, civil_text_size));
            ASSERT_TRUE(time) << what << ": " << line;
            rows.push_back(time->seconds);
          }
          std::filesystem::remove(file);
        }
        EXPECT_TRUE(std::ranges::is_sorted(rows, std::ranges::less_equal{})) << what << ": no row twice";
        for (const std::int64_t row : rows) {
          EXPECT_EQ(std::ranges::count(taken, row), 1) << what << ": a row that was refused, " << row;
          EXPECT_FALSE(cut && std::ranges::count(beyond, row) == 1) << what << ": a row that was cut off, " << row;
        }
        // Of the days that are kept every committed row is there.
        for (const std::int64_t row : taken) {
          if (rows.empty() || row < rows.front() || row > committed_s) continue;
          EXPECT_EQ(std::ranges::count(rows, row), 1) << what << ": a committed row is gone, " << row;
        }
      });
}

TEST(FailedCalls, TakeNoFolderForAwayThatCouldNotBeLookedAt) {
  const TestFolder folder("failed_look");
  const auto opened = StorageFile::open_dir(folder.c_str());
  ASSERT_TRUE(opened);
  failing = {.at = 1, .sticky = true};
  const bool away = opened->is_replaced_at(folder.c_str()), nameless = opened->is_unlinked();
  failing = {};
  EXPECT_FALSE(away || nameless);
  std::filesystem::remove(folder.c_str());
  EXPECT_TRUE(opened->is_replaced_at(folder.c_str()) && opened->is_unlinked());
}

TEST(FailedCalls, LeaveAFolderThatWasMadeOrSayWhy) {
  const TestFolder parent("failed_folder");
  const std::string path = parent.file("new").string();
  bool told = false;
  fail_each_call([&] { told = StorageFile::open_dir(path.c_str()).has_value(); },
                 [&](const std::string& what) {
                   EXPECT_EQ(StorageFile::open_dir(path.c_str()).has_value(), true) << what;
                   EXPECT_TRUE(!told || std::filesystem::is_directory(path)) << what;
                   std::filesystem::remove(path);
                 });
}

TEST(FailedCalls, LeaveACopyOfTheStateUnderTheDigestThatWasTold) {
  const TestFolder folder("failed_copy");
  std::uint64_t in_force = 0, saved = 0;
  fail_each_call(
      [&] {
        StateCopy copy(folder.c_str(), 7);
        std::array<std::byte, 24> state{std::byte{1}};
        {
          const InPeace peace;
          const auto first = copy.save(state, 0);
          in_force = first.value_or(0);
          EXPECT_TRUE(first && copy.settle(in_force));
        }
        state[0] = std::byte{2};
        saved = copy.save(state, in_force).value_or(0);
        if (saved != 0) (void)copy.settle(saved);
        (void)copy.load(state, saved);
      },
      [&](const std::string& what) {
        StateCopy copy(folder.c_str(), 7);
        std::array<std::byte, 24> state{};
        if (saved != 0) {
          EXPECT_TRUE(copy.load(state, saved)) << what;
          EXPECT_EQ(state[0], std::byte{2}) << what;
          EXPECT_TRUE(copy.settle(saved));
        } else {
          EXPECT_TRUE(copy.load(state, in_force)) << what << ": the copy in force still stands";
        }
        for (const auto& entry : std::filesystem::directory_iterator(folder.c_str())) std::filesystem::remove(entry);
      });
}

TEST(StateCopyFile, IsSettledOnlyUnderItsOwnDigest) {
  const TestFolder folder("copy_settle");
  StateCopy copy(folder.c_str(), 7);
  const std::array<std::byte, 24> state{std::byte{1}};
  const auto saved = copy.save(state, 0);
  ASSERT_TRUE(saved);
  EXPECT_TRUE(copy.settle(*saved + 1));
  EXPECT_FALSE(std::filesystem::exists(folder.file("previous"))) << "it belongs to an exchange that was not committed";
  EXPECT_TRUE(copy.settle(*saved));
  EXPECT_TRUE(std::filesystem::exists(folder.file("previous")));
  std::ofstream(folder.file("previous.new")) << std::string(100, 'x');
  EXPECT_TRUE(copy.settle(*saved));
  std::array<std::byte, 24> found{};
  EXPECT_TRUE(copy.load(found, *saved)) << "what is no copy does not take its place";
}

TEST(FailedCalls, LeaveStartsCountedAndWishesToldOnceOrAgain) {
  const TestFolder folder("failed_starts"), inbox("failed_inbox");
  int told = 0;
  fail_each_call(
      [&] {
        StartLedger ledger(folder.c_str());
        EXPECT_GE(ledger.record(600), 1);
        EXPECT_GE(ledger.record(600), 1);
        ledger.clear();
        ledger.clear();  // nothing is left to write
        {
          const InPeace peace;
          for (const char* wish : {"release", "rollback", "a.blob"}) std::ofstream(inbox.file(wish)).put('x');
        }
        Mailbox box(inbox.c_str());
        std::array<std::byte, 8> blob{};
        told = 0;
        for (int k = 0; k < 3; ++k) {
          if (k == 1) {
            const InPeace peace;
            std::ofstream(inbox.file("hand-back")).put('x');
          }
          const Mail mail = box.collect(blob);
          told += mail.release || mail.hand_back ? 1 : 0;
          box.finish(k == 0);
        }
      },
      [&](const std::string& what) {
        EXPECT_LE(told, 3) << what;
        Mailbox box(inbox.c_str());
        std::array<std::byte, 8> blob{};
        const Mail left = box.collect(blob);
        EXPECT_TRUE(told > 0 || left.release || left.hand_back) << what << ": no wish is lost";
        box.finish(true);
        for (const TestFolder* f : {&folder, &inbox}) {
          for (const auto& entry : std::filesystem::directory_iterator(f->c_str())) std::filesystem::remove(entry);
        }
      });
}

TEST(FailedCalls, LeaveAFileThatIsWrittenWholeOldOrNew) {
  const TestFolder folder("failed_atomic");
  const std::string path = folder.file("wish").string();
  const std::vector<std::byte> before(10, std::byte{1}), after(20, std::byte{2});
  StoreResult<void> written;
  fail_each_call(
      [&] {
        {
          const InPeace peace;
          ASSERT_TRUE(write_file_atomically(path, before));
        }
        written = write_file_atomically(path, after);
      },
      [&](const std::string& what) {
        const auto size = std::filesystem::file_size(path);
        EXPECT_EQ(size, written || written.error().step == std::string("sync folder") ? 20u : 10u) << what;
        EXPECT_LE(folder.image().size(), what.find(" from call ") != std::string::npos ? 2u : 1u) << what;
      });
}

}  // namespace
}  // namespace airside::hal
