#include "hal/log/row_log.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "hal/storage/folder_names.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::hal {
namespace {

constexpr std::string_view prefix = "airside-";
constexpr std::string_view suffix = ".csv";
constexpr std::uint32_t max_parts = 99;

std::span<const std::byte> bytes_of(const char* text, std::size_t size) { return std::as_bytes(std::span(text, size)); }

}  // namespace

void RowLog::write_name(char (&name)[name_size], FileId id) {
  char* at = std::copy(prefix.begin(), prefix.end(), name);
  at = write_date_text(at, {id.day * 86400});
  if (id.part > 0) {
    *at++ = '_';
    *at++ = static_cast<char>('0' + id.part / 10 % 10);
    *at++ = static_cast<char>('0' + id.part % 10);
  }
  at = std::copy(suffix.begin(), suffix.end(), at);
  *at = '\0';
}

bool RowLog::parse_name(const char* name, FileId& id) {
  std::string_view text(name);
  if (text.size() < prefix.size() + date_text_size + suffix.size()) return false;
  std::array<char, civil_text_size> date{};
  constexpr std::string_view midnight = "T00:00:00";
  std::copy_n(name + prefix.size(), date_text_size, date.begin());
  std::copy(midnight.begin(), midnight.end(), date.begin() + date_text_size);
  const auto time = parse_civil_text({date.data(), date.size()});
  if (!time) return false;
  id = {time->day(), 0};
  if (text.size() == prefix.size() + date_text_size + 3 + suffix.size()) {
    const char* digits = name + prefix.size() + date_text_size + 1;
    id.part = static_cast<std::uint32_t>((digits[0] - '0') * 10 + (digits[1] - '0'));
    if (id.part < 1 || id.part > max_parts) return false;
  }
  char again[name_size];
  write_name(again, id);
  return text == again;
}

RowLog::RowLog(const char* dir, const TopologyCounts& counts, const RowLogLimits& limits, Sync sync)
    : path_(dir),
      header_(log_header(counts, true)),
      limits_{std::max(limits.max_files, 2), limits.max_file_bytes},
      sync_(sync),
      files_(std::make_unique<FileId[]>(static_cast<std::size_t>(limits_.max_files) + 2)),
      text_(std::make_unique<char[]>(header_.size() + max_log_row_text)),
      in_doubt_(std::make_unique<char[]>(max_log_row_text)) {
  ready_ = make_ready();
}

StoreResult<RowLog> RowLog::open(const char* dir, const TopologyCounts& counts, const RowLogLimits& limits, Sync sync) {
  RowLog log(dir, counts, limits, sync);
  if (!log.ready_) return tl::make_unexpected(log.ready_.error());
  return log;
}

StoreResult<void> RowLog::make_ready() {
  if (dir_.is_open() && dir_.is_replaced_at(path_.c_str())) dir_.close();
  if (!dir_.is_open()) {
    auto folder = StorageFile::open_dir(path_.c_str());
    if (!folder) return tl::make_unexpected(folder.error());
    dir_ = std::move(*folder);
  }
  if (::faccessat(dir_.descriptor(), ".", W_OK, AT_EACCESS) != 0) {
    return tl::make_unexpected(store_error(errno, "open log folder"));
  }
  if (const auto done = list_files(); !done) return done;
  if (const auto done = open_newest(); !done) return done;
  trim(max_files());
  return {};
}

/// Puts a file among the newest.
void RowLog::keep(FileId id, std::size_t most) {
  FileId* const end = files_.get() + file_count_;
  FileId* const place = std::lower_bound(files_.get(), end, id);
  if (place != end && *place == id) return;  // uncovered: a listing may show a name twice while files go
  std::move_backward(place, end, end + 1);
  *place = id;
  ++file_count_;
  trim(most);
}

/// Removes the oldest file where there are more than `most`. One that cannot be removed is forgotten until the next
/// start, and sync() tells of it: the rows of today matter more.
void RowLog::trim(std::size_t most) {
  if (file_count_ <= most) return;
  if (const auto done = remove(files_[0]); !done) untold_ = done;
  std::move(files_.get() + 1, files_.get() + file_count_, files_.get());
  --file_count_;
}

StoreResult<void> RowLog::list_files() {
  file_count_ = 0;
  const auto listed = for_each_name(dir_.descriptor(), [&](const char* name) {
    FileId id{};
    if (parse_name(name, id)) keep(id, max_files() + 1);  // the newest may hold no row, and go
    return true;
  });
  if (!listed) return tl::make_unexpected(store_error(errno, "list log folder"));
  return {};
}

StoreResult<void> RowLog::remove(FileId id) {
  char name[name_size];
  write_name(name, id);
  if (::unlinkat(dir_.descriptor(), name, 0) != 0 && errno != ENOENT) {
    return tl::make_unexpected(store_error(errno, "remove old log"));
  }
  return {};
}

/// Opens the newest file that holds a row; files that hold none are removed.
StoreResult<void> RowLog::open_newest() {
  position_ = {};
  last_time_ = before_all;
  rows_before_last_ = false;
  file_.close();
  while (file_count_ > 0) {
    const FileId id = files_[file_count_ - 1];
    char name[name_size];
    write_name(name, id);
    auto file = StorageFile::open(dir_.descriptor(), name, false, "open log");
    if (!file) return tl::make_unexpected(file.error());
    file_ = std::move(*file);
    position_ = {id.day, id.part, 0};
    if (const auto done = find_last_row(); !done) return done;
    if (position_.bytes > 0) return {};
    file_.close();
    if (const auto done = remove(id); !done) return done;
    --file_count_;
    position_ = {};
  }
  return {};
}

/// Sets position and last_time from the end of the open file and cuts off an unfinished row.
StoreResult<void> RowLog::find_last_row() {
  const auto size = file_.size("read log");
  if (!size) return tl::make_unexpected(size.error());
  std::uint64_t end = *size;
  const std::size_t window = max_log_row_text;
  while (true) {
    const std::uint64_t begin = end > window ? end - window : 0;
    const std::span<char> text(text_.get(), static_cast<std::size_t>(end - begin));
    const auto got = file_.read_at(std::as_writable_bytes(text), begin, "read log");
    if (!got) return tl::make_unexpected(got.error());
    const std::string_view tail(text.data(), *got);
    const std::size_t last = tail.rfind('\n');
    if (last == std::string_view::npos) {
      end = 0;
      break;
    }
    const std::size_t before = last == 0 ? std::string_view::npos : tail.rfind('\n', last - 1);
    const std::size_t row = before == std::string_view::npos ? 0 : before + 1;
    end = begin + last + 1;
    const auto time = parse_civil_text(tail.substr(row, std::min(civil_text_size, last - row)));
    // A sector that never reached the medium reads as zeros in the middle of a row.
    if (time && tail.substr(row, last - row).find('\0') == std::string_view::npos) {
      // A file of another day than its rows: what follows must still go to a file that sorts behind it.
      last_time_ = std::max(*time, CivilTime{position_.day * 86400 - 1});
      rows_before_last_ = begin + row > header_.size();
      break;
    }
    // A line that is no row: the header (nothing logged), or what a power cut left of a row.
    if (before == std::string_view::npos) {
      end = 0;
      break;
    }
    end = begin + row;
  }
  if (end < *size) {
    if (const auto done = file_.truncate(end, "cut unfinished row"); !done) return done;
  }
  position_.bytes = end;
  synced_bytes_ = 0;
  sync_failed_ = false;
  const std::span<char> front(text_.get(), header_.size());
  const auto got = file_.read_at(std::as_writable_bytes(front), 0, "read log");
  if (!got) return tl::make_unexpected(got.error());
  other_header_ = std::string_view(front.data(), *got) != header_;
  return {};
}

StoreResult<void> RowLog::resume(const LogPosition& committed) {
  resume_at_ = committed;
  if (!ready_) return ready_;
  const auto done = follow(committed);
  // Half done, the position is none: nothing may be appended there before it was done whole.
  if (!done && done.error().fault != StoreFault::log_shorter) ready_ = done;
  return done;
}

StoreResult<void> RowLog::follow(const LogPosition& committed) {
  const FileId id{committed.day, committed.part};
  file_.close();
  while (committed.bytes > 0 && file_count_ > 0 && files_[file_count_ - 1] > id) {
    if (const auto done = remove(files_[file_count_ - 1]); !done) return done;
    --file_count_;
  }
  bool shorter = committed.bytes > 0;
  if (committed.bytes > 0 && file_count_ > 0 && files_[file_count_ - 1] == id) {
    char name[name_size];
    write_name(name, id);
    const auto file = StorageFile::open(dir_.descriptor(), name, false, "open log");
    if (!file) return tl::make_unexpected(file.error());
    const auto size = file->size("read log");
    if (!size) return tl::make_unexpected(size.error());
    shorter = *size < committed.bytes;
    if (*size > committed.bytes) {
      if (const auto done = file->truncate(committed.bytes, "cut uncommitted rows"); !done) return done;
    }
  }
  if (const auto done = open_newest(); !done) return done;
  shorter = shorter || (committed.bytes > 0 && !(position_ == committed));
  if (shorter) return tl::make_unexpected(StoreError{StoreFault::log_shorter, 0, "resume log"});
  return {};
}

StoreResult<void> RowLog::start_file(FileId id) {
  (void)sync_rows();  // its failure is in what sync() says row by row; a new day's rows must not be lost for it
  char name[name_size];
  write_name(name, id);
  auto file = StorageFile::open(dir_.descriptor(), name, true, "create log");
  if (!file) return tl::make_unexpected(file.error());
  if (const auto done = file->truncate(0, "create log"); !done) return done;
  file_ = std::move(*file);
  position_ = {id.day, id.part, 0};
  synced_bytes_ = 0;
  sync_failed_ = false;
  new_file_unsynced_ = true;
  other_header_ = false;
  keep(id, max_files());
  return {};
}

/// What is written to a folder or a file that was taken away is not where people look for it, or gone when it closes.
/// No row is removed for that: what lies at the path by now may be a copy that holds all of them.
void RowLog::release_files() {
  (void)sync_rows();  // what was only renamed keeps its rows
  file_.close();
  left_ = std::max(left_, FileId{position_.day, position_.part});
  resume_at_ = {};
  ready_ = tl::make_unexpected(StoreError{StoreFault::removed, 0, "append row to log"});
  untold_ = ready_;
}

StoreResult<void> RowLog::append(const LogRow& row) {
  if (ready_ && (dir_.is_replaced_at(path_.c_str()) || (file_.is_open() && file_.is_unlinked()))) release_files();
  if (!ready_) {
    ready_ = make_ready();
    if (!ready_) return ready_;
    if (const auto done = resume(resume_at_); !done && done.error().fault != StoreFault::log_shorter) return done;
  }
  if (row.time <= last_time_) {
    return tl::make_unexpected(StoreError{StoreFault::out_of_order, 0, "append row to log"});
  }
  const std::size_t header = header_.size();
  std::memcpy(text_.get(), header_.data(), header);
  const std::size_t size = format_log_row({text_.get() + header, max_log_row_text}, row, true);
  if (size == 0) return tl::make_unexpected(StoreError{StoreFault::row_too_long, 0, "append row to log"});
  FileId id{row.time.day(), 0};
  // Behind what was taken away: that may come back beside it, and what was committed there cuts nothing here.
  if (left_.day == id.day) id.part = std::min(left_.part + 1, max_parts);
  if (file_.is_open() && position_.day == id.day) {
    std::uint32_t part = position_.part;
    const bool full = position_.bytes + size > limits_.max_file_bytes && position_.bytes > 0;
    if ((full || other_header_) && part < max_parts) ++part;
    id.part = std::max(id.part, part);
  }
  if (!file_.is_open() || FileId{position_.day, position_.part} != id) {
    if (const auto done = start_file(id); !done) return done;
  }
  const bool first = position_.bytes == 0;
  const char* begin = first ? text_.get() : text_.get() + header;
  const std::size_t bytes = first ? header + size : size;
  const auto done = file_.write_at(bytes_of(begin, bytes), position_.bytes, "append row to log");
  if (!done) {
    // What was written of the row goes; if even that fails, the next row overwrites it from the same place.
    (void)file_.truncate(position_.bytes, "append row to log");
    return done;
  }
  position_.bytes += bytes;
  last_time_ = row.time;
  return {};
}

/// After a failed sync the kernel may take lost pages for clean: only writing them again makes them dirty.
StoreResult<void> RowLog::rewrite_in_doubt() {
  for (std::uint64_t at = synced_bytes_; at < position_.bytes;) {
    const std::uint64_t size = std::min<std::uint64_t>(position_.bytes - at, max_log_row_text);
    const std::span<char> text(in_doubt_.get(), static_cast<std::size_t>(size));
    const auto got = file_.read_at(std::as_writable_bytes(text), at, "read log");
    if (!got) return tl::make_unexpected(got.error());
    if (*got == 0) break;
    const auto done = file_.write_at(bytes_of(text.data(), *got), at, "write log again");
    if (!done) return done;
    at += *got;
  }
  return {};
}

StoreResult<void> RowLog::sync() {
  if (const auto done = sync_rows(); !done) return done;
  return std::exchange(untold_, {});
}

StoreResult<void> RowLog::sync_rows() {
  if (!file_.is_open() || sync_ == Sync::none) return {};
  if (sync_failed_) {
    if (const auto done = rewrite_in_doubt(); !done) return done;
  }
  sync_failed_ = true;
  if (const auto done = file_.sync(sync_, "sync log"); !done) return done;
  if (new_file_unsynced_ && ::fsync(dir_.descriptor()) != 0) {
    return tl::make_unexpected(store_error(errno, "sync log folder"));
  }
  sync_failed_ = false;
  new_file_unsynced_ = false;
  synced_bytes_ = position_.bytes;
  return {};
}

}  // namespace airside::hal
