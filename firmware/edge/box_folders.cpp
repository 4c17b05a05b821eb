#include "firmware/edge/box_folders.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "firmware/edge/report/say.hpp"
#include "hal/storage/etc_folder.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"

namespace airside::edge {
namespace {

class RowText {
 public:
  explicit RowText(CivilTime t) { hal::write_civil_text(text_.data(), t); }
  std::string_view view() const { return {text_.data(), text_.size()}; }

 private:
  std::array<char, hal::civil_text_size> text_{};
};

}  // namespace

void BoxFolders::refuse_unwritable() const {
  for (const auto& [table, folder] :
       {std::pair("state", &site_.state_dir), std::pair("log", &site_.log_dir), std::pair("inbox", &site_.inbox_dir)}) {
    if (!hal::is_below_etc(*folder)) continue;
    const std::string wanted = hal::folder_of_box(table);
    throw hal::InputError(std::string("[") + table + "] dir", *folder,
                          "a folder that airsided.service may write, which none below /etc is",
                          "write dir = \"" + wanted + "\"");
  }
}

void BoxFolders::open_log(const hal::TopologyCounts& counts) {
  if (site_.log_dir.empty()) return;
  hal::RowLogLimits limits;
  limits.max_files = site_.log_max_files;
  limits.max_file_bytes = static_cast<std::uint64_t>(site_.log_max_file_mb * 1e6);
  log_.emplace(site_.log_dir.c_str(), counts, limits, sync_);
  if (log_->ready()) return;
  storage_ = "log cannot be written";
  remedy_ = hal::remedy_of(log_->ready().error().fault);
  say("log in {}: {}; each row tries again", site_.log_dir, hal::describe(log_->ready().error()));
}

void BoxFolders::open_store(const hal::StoreLayout& layout) {
  if (site_.state_dir.empty()) return;
  auto opened = hal::DurableStore::open(site_.state_dir.c_str(), layout, sync_);
  if (!opened) {
    throw hal::InputError(site_.state_dir, "another airsided that uses this state folder", "one daemon a state folder",
                          "stop the other one, or give this site its own [state] dir");
  }
  store_.emplace(std::move(*opened));
  if (store_->ready()) return;
  storage_ = "state cannot be written";
  remedy_ = hal::remedy_of(store_->ready().error().fault);
  say("state in {}: {}; running in memory, each row tries again", site_.state_dir,
      hal::describe(store_->ready().error()));
}

void BoxFolders::note(const hal::StoreResult<void>& result, const char* what) {
  const char* before = storage_;
  storage_ = result ? "ok" : hal::text_of(result.error().fault);
  remedy_ = result ? "" : hal::remedy_of(result.error().fault);
  if (result || std::strcmp(before, storage_) == 0) return;
  say("{}: {} ({}); {}", what, storage_, result.error().step, remedy_);
}

void BoxFolders::note_logged(const hal::StoreResult<void>& result, CivilTime t) {
  const bool said = !result && std::strcmp(storage_, hal::text_of(result.error().fault)) == 0;
  note(result, "log");
  if (said || result || result.error().fault != hal::StoreFault::out_of_order) return;
  say("log: the clock is at {}, the last row in {} is of {}", RowText(t).view(), site_.log_dir,
      RowText(log_->last_time()).view());
}

bool BoxFolders::is_well() const { return std::strcmp(storage_, "ok") == 0; }

CivilTime BoxFolders::last_logged() const {
  return log_ && log_->ready() && log_->position().bytes > 0 ? log_->last_time() : CivilTime{};
}

void BoxFolders::say_lost(CivilTime until) const {
  say("state in {}: no saved generation is whole and of this version", site_.state_dir);
  if (until.seconds == 0) {
    say("what this box had learned is lost");
  } else {
    say("what this box had learned until row {} is lost", RowText(until).view());
  }
}

void BoxFolders::archive_foreign_state() {
  const hal::StoreResult<void> kept = store_->archive_foreign_state();
  if (kept) say("it is kept there as other-*; control begins anew");
  if (!kept) say("it cannot be renamed: {}; each row tries again", hal::text_of(kept.error().fault));
}

void BoxFolders::say_resumed(const hal::LoadedState& found, CivilTime row, std::uint64_t ring_capacity) const {
  say("resuming after row {} ({}, generation {})", RowText(row).view(), hal::text_of(found.outcome), found.generation);
  if (found.dropped_transitions == 0) return;
  say("{} of {} transitions are damaged and left out of the replay", found.dropped_transitions,
      found.dropped_transitions + std::min(found.replay_count, ring_capacity));
}

}  // namespace airside::edge
