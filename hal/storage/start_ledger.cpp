#include "hal/storage/start_ledger.hpp"

#include <algorithm>
#include <ctime>
#include <span>

#include "hal/storage/digest64.hpp"
#include "hal/storage/storage_file.hpp"

namespace airside::hal {
namespace {

constexpr std::uint64_t ledger_magic = 0x3153545241545341u;  // "ASTARTS1" in file order

std::int64_t seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return now.tv_sec;
}

template <class Record>
std::uint64_t digest_of(const Record& record) {
  return digest64(std::as_bytes(std::span(&record, 1)).first(sizeof record - sizeof record.digest));
}

}  // namespace

bool StartLedger::read(File& file) const {
  const auto folder = StorageFile::open_dir(dir_.c_str());
  if (!folder) return false;
  const auto opened = StorageFile::open(folder->descriptor(), "starts", false, "open starts");
  if (!opened) return false;
  const auto got = opened->read_at(std::as_writable_bytes(std::span(&file, 1)), 0, "read starts");
  return got && *got == sizeof file && file.magic == ledger_magic && file.count <= most &&
         file.digest == digest_of(file);
}

bool StartLedger::write(File& file) const {
  file.magic = ledger_magic;
  file.digest = digest_of(file);
  const auto folder = StorageFile::open_dir(dir_.c_str());
  if (!folder) return false;
  const auto opened = StorageFile::open(folder->descriptor(), "starts", true, "open starts");
  return opened && opened->write_at(std::as_bytes(std::span(&file, 1)), 0, "write starts") &&
         opened->sync(sync_, "sync starts");
}

int StartLedger::record(std::int64_t window_s) {
  File file;
  if (!read(file)) file = {};
  if (file.count == most) {
    std::move(file.start + 1, file.start + most, file.start);
    --file.count;
  }
  const Start now{seconds_of(CLOCK_REALTIME), seconds_of(CLOCK_BOOTTIME)};
  file.start[file.count++] = now;
  // Unsigned, since the file may hold any number: the difference of two that far apart has no sign bit to spare.
  const auto near = [window_s](std::int64_t a, std::int64_t b) {
    return a >= b &&
           static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b) < static_cast<std::uint64_t>(window_s);
  };
  int recent = 0;
  for (std::uint64_t i = 0; i < file.count; ++i) {
    const Start& start = file.start[i];
    recent += near(now.wall_s, start.wall_s) || near(now.since_boot_s, start.since_boot_s) ? 1 : 0;
  }
  kept_ = write(file);
  last_ = file;
  return recent;
}

void StartLedger::keep() {
  if (!kept_) kept_ = write(last_);
}

void StartLedger::clear() {
  File file;
  if (!read(file) || file.count == 0) return;
  file = {};
  (void)write(file);
}

}  // namespace airside::hal
