#pragma once
// State and log of one box as folders that may fail, come late or be gone: what of it is well, and what is said of it.

#include <optional>

#include "airside/civil_time.hpp"
#include "hal/log/log_record.hpp"
#include "hal/log/row_log.hpp"
#include "hal/site/site_file.hpp"
#include "hal/storage/durable_store.hpp"

namespace airside::edge {

class BoxFolders {
 public:
  BoxFolders(const hal::SiteFile& site, hal::Sync sync) : site_(site), sync_(sync) {}

  /// Opens or makes the folders that the site names. One that fails is tried again by every row, and said.
  /// Errors: hal::InputError for a state folder that another daemon uses.
  void open_log(const hal::TopologyCounts& counts);
  void open_store(const hal::StoreLayout& layout);

  /// Errors: hal::InputError for a folder below /etc, where the unit may not write.
  void refuse_unwritable() const;

  std::optional<hal::DurableStore>& store() { return store_; }
  const std::optional<hal::DurableStore>& store() const { return store_; }
  std::optional<hal::RowLog>& log() { return log_; }
  hal::LogPosition log_position() const { return log_ ? log_->position() : hal::LogPosition{}; }
  /// Whether the state folder was reached, so that what is missing in it is gone.
  bool has_store() const { return store_ && store_->ready(); }

  /// The result of what was done last with `what`; a new fault is said.
  void note(const hal::StoreResult<void>& result, const char* what);
  /// The same of a row at t: one that is not after the log's last row is said with both times.
  void note_logged(const hal::StoreResult<void>& result, CivilTime t);
  /// `ok`, or what is wrong with the disk, or with the clock that the log's rows are in the order of.
  const char* storage() const { return storage_; }
  /// What a person does about it; "" where all is well.
  const char* remedy() const { return remedy_; }
  bool is_well() const;

  /// Time of the log's last row, 0 without one.
  CivilTime last_logged() const;
  /// Says that what was learned until row `until` is lost, 0 where that is not known.
  void say_lost(CivilTime until) const;
  /// Keeps the state of another topology or version under other names.
  void archive_foreign_state();
  void say_resumed(const hal::LoadedState& found, CivilTime row, std::uint64_t ring_capacity) const;

 private:
  const hal::SiteFile& site_;
  hal::Sync sync_;
  std::optional<hal::DurableStore> store_;
  std::optional<hal::RowLog> log_;
  const char *storage_ = "ok", *remedy_ = "";
};

}  // namespace airside::edge
