#pragma once
// The daemon's log: rows as CSV in a bounded set of files, one a day, whose end is part of the durable record.
// After a crash the log is cut back to what was committed, so no row stands twice and none is missing.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "hal/log/log_csv.hpp"
#include "hal/storage/log_position.hpp"
#include "hal/storage/storage_file.hpp"
#include "hal/storage/store_error.hpp"

namespace airside::hal {

/// How much a row log keeps.
struct RowLogLimits {
  int max_files = 40;                        ///< the oldest file goes when there are more
  std::uint64_t max_file_bytes = 8'000'000;  ///< a day's further rows go to `_01`, `_02` ... beyond this
};

/// Appends rows to `airside-2021-07-01.csv`, `airside-2021-07-02.csv` ... in one folder.
/// Order of use in a row: append(), sync(), DurableStore::commit() with position().
/// Cost: no heap after open().
class RowLog {
 public:
  /// Opens or makes the folder, finds the newest file and cuts a row off that a crash left unfinished; ready() tells
  /// what of it failed. A folder that failed is tried again by every append().
  RowLog(const char* dir, const TopologyCounts& counts, const RowLogLimits& limits = {}, Sync sync = Sync::full);
  /// The same. Errors: not_found, read_only, io.
  static StoreResult<RowLog> open(const char* dir, const TopologyCounts& counts, const RowLogLimits& limits = {},
                                  Sync sync = Sync::full);
  /// Why nothing can be appended yet. Errors: not_found, read_only, io.
  const StoreResult<void>& ready() const { return ready_; }

  /// Removes what was written after `committed`. bytes 0 removes nothing: then rows that already stand there are
  /// refused by append() as out_of_order.
  /// Errors: log_shorter when committed rows are missing (the log then goes on after the last whole row);
  /// read_only, io; those of a log that is not ready, which then resumes when it is.
  StoreResult<void> resume(const LogPosition& committed);

  /// Appends one row, starting a new file on a new day, and where the newest file or the folder was taken away: in
  /// whatever folder stands at the path by then, behind the rows that lie there.
  /// Errors: out_of_order for a row that is not after the last one, row_too_long, no_space, read_only, io; nothing
  /// of the row then stands in the file.
  /// Cost: one write(2) and three looks; a few more calls on a new day.
  StoreResult<void> append(const LogRow& row);

  /// Forces the rows to the medium.
  /// Errors: io, no_space; the next call writes the rows in doubt again before it syncs. Once, that of an old file that
  /// could not be removed; once removed, where the rows before this one were taken away.
  StoreResult<void> sync();

  /// End of the last row. bytes 0: nothing logged.
  LogPosition position() const { return position_; }
  /// Time of the last row; before any row, the smallest time.
  CivilTime last_time() const { return last_time_; }
  std::size_t files() const { return file_count_; }
  /// Whether more than one row lies here, as far as that was looked for at the last opening. One alone may be of a box
  /// that lost power before its first commit.
  bool holds_past() const { return file_count_ > 1 || rows_before_last_; }

 private:
  struct FileId {
    std::int64_t day;
    std::uint32_t part;
    auto operator<=>(const FileId&) const = default;
  };
  static constexpr std::size_t name_size = 40;
  static constexpr CivilTime before_all{std::numeric_limits<std::int64_t>::min()};

  StoreResult<void> make_ready();
  void release_files();
  StoreResult<void> follow(const LogPosition& committed);
  std::size_t max_files() const { return static_cast<std::size_t>(limits_.max_files); }
  void keep(FileId id, std::size_t most);
  void trim(std::size_t most);
  static void write_name(char (&name)[name_size], FileId id);
  static bool parse_name(const char* name, FileId& id);
  StoreResult<void> list_files();
  StoreResult<void> remove(FileId id);
  StoreResult<void> open_newest();
  StoreResult<void> start_file(FileId id);
  StoreResult<void> find_last_row();
  StoreResult<void> rewrite_in_doubt();
  StoreResult<void> sync_rows();

  std::string path_, header_;
  RowLogLimits limits_;
  Sync sync_ = Sync::full;
  StorageFile dir_, file_;
  std::unique_ptr<FileId[]> files_;  ///< oldest first; room for max_files + 2
  std::size_t file_count_ = 0;
  std::unique_ptr<char[]> text_;      ///< header and one row
  std::unique_ptr<char[]> in_doubt_;  ///< rows that are written again; text_ may hold a new one then
  LogPosition position_;
  CivilTime last_time_ = before_all;
  std::uint64_t synced_bytes_ = 0;  ///< of the open file
  StoreResult<void> ready_;
  StoreResult<void> untold_;            ///< what went wrong beside the rows, until sync() tells it
  FileId left_{before_all.seconds, 0};  ///< newest file that was taken away
  LogPosition resume_at_;               ///< of the last resume(); done again by a log that was not ready. bytes 0: none
  bool sync_failed_ = false;
  bool new_file_unsynced_ = false;
  bool rows_before_last_ = false;  ///< in the newest file, when it was opened
  bool other_header_ = false;      ///< the newest file has other columns: the next row starts a new file
};

}  // namespace airside::hal
