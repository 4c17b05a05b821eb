#pragma once
// What the daemon knows beyond its own life: state, log, weights that come and go. Each row ends in one commit.

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "airside/controller/history.hpp"
#include "airside/controller/instances.hpp"
#include "firmware/edge/daemon.hpp"
#include "firmware/edge/say.hpp"
#include "firmware/edge/weights_export.hpp"
#include "firmware/edge/weights_trial.hpp"
#include "hal/log/log_csv.hpp"
#include "hal/log/log_record.hpp"
#include "hal/log/row_log.hpp"
#include "hal/site/site_file.hpp"
#include "hal/storage/durable_store.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/weights/blob_file.hpp"

namespace airside::edge {

/// What a row commits beside the learning state. Plain bytes.
template <Topology T>
struct RowRecord {
  CycleState<T> cycle;
  Decision decision;
  CivilTime row_time;
  std::uint32_t blob_crc = 0;  ///< of the site's weights that this state grew from
  std::uint32_t reserved = 0;
  TrialRecord trial;  ///< of weights that were pushed since
};

/// The folders of one box and the controller that they are for, which must outlive this.
template <Topology T>
class EdgeMemory {
  using Learning = LearningState<T, float>;
  using Ring = ReplayRing<T, float>;
  using Payload = BlobPayload<T, NetworkWeights<T, float>::count>;

 public:
  EdgeMemory(const hal::SiteFile& site, hal::Sync sync, Controller<T>& controller)
      : site_(site),
        sync_(sync),
        controller_(controller),
        log_row_(hal::make_log_row(hal::counts_of<T>())),
        trial_(site.keys_dir, site.inbox_dir, site.state_dir, layout().meaning, sync, site.scope, site.log_dir),
        export_(site.state_dir, site.name, sync) {}

  /// Sizes of the durable state of this topology and build.
  static hal::StoreLayout layout() {
    return {.learning_bytes = sizeof(Learning),
            .row_bytes = sizeof(RowRecord<T>),
            .transition_bytes = sizeof(typename Ring::Row),
            .ring_capacity = Ring::capacity,
            .meaning = topology_hash<T>(NetworkWeights<T, float>::count) ^ units_hash<T>() ^
                       (std::uint64_t{state_version} << 32)};
  }

  /// Reads blob and history, then opens log, state and inbox. A folder that fails is tried again by every row.
  /// Errors: hal::InputError for a bad blob or history, which leaves no folder behind, or a state folder in use.
  void open() {
    blob_crc_ = load_blob();
    std::error_code ignored;
    if (!std::filesystem::exists(site_.state_dir, ignored)) load_history();
    open_log();
    open_store();
    trial_.open_inbox();
    export_.open();
  }
  /// Loads the newest good state, else begins from the blob, else leaves the controller as it is. Returns the time of
  /// the last row, 0 where there was no state.
  CivilTime resume() {
    is_new_ = !trial_.has_counters() && !(log_ && log_->holds_past());
    const Found found = load_state();
    if (found == Found::nothing && !record_was_whole_ && !is_new_ && store_ && store_->ready()) lose_state();
    trial_.join_counters(record_.trial, record_was_whole_ || (is_new_ && !state_lost_));
    if (found == Found::nothing) {
      begin_from_blob();
      if (blob_bytes_ > 0) remember_history();
      if (log_) note(log_->resume({}), "log");
    }
    history_.reset();
    return found == Found::state ? record_.row_time : CivilTime{};
  }
  /// Reads what open() would read and leaves everything as it is. Returns the keys, for people. Errors: as of open(),
  /// but for the state folder; and for a bad history without weights or bad key files, which a start leaves out.
  std::string check() {
    (void)load_blob();
    if (!site_.history_log.empty()) (void)hal::read_log(site_.history_log, hal::counts_of<T>());
    return hal::describe(hal::KeyRing::load(site_.keys_dir));
  }

  /// One row: log it unless its time cannot be right, look into the inbox, commit. Order matters: the log first, then
  /// the commit that names its end. Cost: no heap.
  void row(CivilTime t, const Expected<Reading<T>>& sensed, bool has_date) {
    hal::fill_log_row<T>(log_row_, t, sensed, controller_.decision(), controller_.cycle().last_setpoint_degc);
    const bool logs = log_ && has_date;
    hal::StoreResult<void> logged = logs ? log_->append(log_row_) : hal::StoreResult<void>{};
    if (logged && logs) logged = log_->sync();
    const bool exchanged = trial_.row(t, controller_, record_.trial);
    if (exchanged && store_) store_->replay_replaced();
    if (exchanged) learning_exchanged_ = true;
    hal::StoreResult<void> committed = store_ ? store_->commit(state(t)) : hal::StoreResult<void>{};
    if (!committed && committed.error().fault == hal::StoreFault::unread) {
      resume_late(t);
      committed = store_->commit(state(t));
    }
    // At a start a locked folder ends the daemon; later it means that another one has taken it.
    taken_over_ = !committed && committed.error().fault == hal::StoreFault::locked;
    if (committed && !has_committed_) find_late_loss(t);
    has_committed_ = has_committed_ || committed;
    row_committed_ = committed.has_value();
    if (committed) {
      learning_exchanged_ = false;
      trial_.committed();
    }
    note(logged ? committed : logged, logged ? "state" : "log");
  }
  /// After a row whose commit stands: the weights for whoever asks for them.
  void give_weights(CivilTime t) {
    if (row_committed_) export_.row(t, controller_, record_.trial);
  }
  /// At an orderly end.
  void end() {
    if (has_committed_) export_.end(record_.row_time, controller_, record_.trial);
  }

  /// `ok`, or what is wrong with the disk.
  const char* storage() const { return storage_; }
  bool is_well() const { return std::strcmp(storage_, "ok") == 0; }
  /// There was state, and none of it is whole and of this version and topology.
  bool state_lost() const { return state_lost_; }
  /// Until when what was lost had been learned, as far as row record or log know; 0 where nothing was lost.
  CivilTime lost_until() const { return lost_until_; }
  /// Another daemon uses the state folder, so the AHU is its.
  bool taken_over() const { return taken_over_; }
  bool release_waits() const { return trial_.release_waits(); }
  const TrialRecord& trial() const { return record_.trial; }
  std::uint64_t generation() const { return store_ ? store_->generation() : 0; }

 private:
  static std::span<const std::byte> bytes_of(const void* p, std::size_t n) {
    return {static_cast<const std::byte*>(p), n};
  }
  static std::span<std::byte> bytes_of(void* p, std::size_t n) { return {static_cast<std::byte*>(p), n}; }

  hal::StoredState state(CivilTime t) {
    // The cycle's part of the record is copied, the large parts are written from where they stand.
    record_.cycle = controller_.cycle();
    record_.decision = controller_.decision();
    record_.row_time = t;
    return {.learning = controller_.saved_bytes().learning,
            .row = bytes_of(static_cast<const void*>(&record_), sizeof record_),
            .replay = controller_.saved_bytes().replay,
            .replay_count = controller_.replay().total_pushed(),
            .log = log_ ? log_->position() : hal::LogPosition{},
            .learning_changed = starts_cycle(t) || !has_committed_ || learning_exchanged_};
  }

  void open_log() {
    if (site_.log_dir.empty()) return;
    hal::RowLogLimits limits;
    limits.max_files = site_.log_max_files;
    limits.max_file_bytes = static_cast<std::uint64_t>(site_.log_max_file_mb * 1e6);
    log_.emplace(site_.log_dir.c_str(), hal::counts_of<T>(), limits, sync_);
    if (log_->ready()) return;
    storage_ = "log cannot be written";
    say("log in {}: {}; each row tries again", site_.log_dir, hal::describe(log_->ready().error()));
  }

  void open_store() {
    if (site_.state_dir.empty()) return;
    auto opened = hal::DurableStore::open(site_.state_dir.c_str(), layout(), sync_);
    if (!opened) {
      throw hal::InputError(site_.state_dir, "another airsided that uses this state folder",
                            "one daemon a state folder", "stop the other one, or give this site its own [state] dir");
    }
    store_.emplace(std::move(*opened));
    if (store_->ready()) return;
    storage_ = "state cannot be written";
    say("state in {}: {}; running in memory, each row tries again", site_.state_dir,
        hal::describe(store_->ready().error()));
  }

  /// Reads the blob, if the site names one. Returns its checksum, 0 without.
  std::uint32_t load_blob() {
    if (site_.weights_blob.empty()) return 0;
    payload_ = std::make_unique<Payload>();
    const std::vector<std::byte> bytes = hal::read_blob_file(site_.weights_blob);
    hal::decode_blob<T>(bytes, site_.scope, site_.weights_blob, *payload_);
    blob_bytes_ = bytes.size();
    return crc32c(bytes);
  }

  /// Reads the schedule's days, which only weights make useful. A resumed state has them already and needs no file.
  void load_history() {
    if (blob_bytes_ > 0 && !site_.history_log.empty()) {
      history_ = hal::read_log(site_.history_log, hal::counts_of<T>());
    }
  }

  /// Cost: no heap.
  void begin_from_blob() {
    record_.blob_crc = blob_crc_;
    if (blob_bytes_ == 0) return;
    take_payload<T>(controller_, *payload_);
    say("starting from {}", site_.weights_blob);
  }

  void remember_history() {
    if (!history_) load_history();
    if (!history_) return;
    HistoryReader<T> reader(controller_, HistoryReader<T>::Head::leave);
    for (const hal::LogRow& row : history_->rows) {
      reader.row(row.time, Eigen::Map<const typename Reading<T>::Vector>(row.value.data()), row.setpoint_degc);
    }
    say("remembered {} transitions of {}", reader.transitions(), site_.history_log);
  }

  enum class Found {
    nothing,  ///< that fits; the controller is as it was made
    state,
    nothing_read,  ///< the controller is as it was
  };

  /// Loads the newest generation; the inbox is told to it anew. `late`: after rows that were not committed. Cost: no
  /// heap.
  Found load_state(bool late = false) {
    if (!store_) return Found::nothing;
    auto found = store_->load({.learning = controller_.loaded_bytes().learning,
                               .row = bytes_of(static_cast<void*>(&record_), sizeof record_),
                               .replay = controller_.loaded_bytes().replay});
    if (!found) {
      say("state in {}: {} ({})", site_.state_dir, hal::text_of(found.error().fault), found.error().step);
      if (found.error().fault != hal::StoreFault::other_layout) return forget();
      set_other_aside();
      return late ? Found::nothing_read : forget();  // late, what was learned since the start stands
    }
    if (found->outcome == hal::LoadOutcome::none) {
      // Kept files of another version beside none of this one: a start that did not come to its first row.
      const bool lost = found->damaged_records > 0 || store_->keeps_other();
      record_was_whole_ = found->row_is_whole;
      if (lost) lose_state();
      return record_was_whole_ ? forget_weights() : forget();
    }
    record_was_whole_ = true;
    if (record_.blob_crc != blob_crc_) {
      say("the site names other weights than the state grew from; starting from them");
      return forget_weights();
    }
    trial_.tell_anew();
    if (controller_.restore(record_.cycle, found->replay_count, record_.decision) != Fault::none) {
      say("state in {}: saved weights are not finite", site_.state_dir);
      lose_state();
      return forget_weights();
    }
    if (log_ && !late) note(log_->resume(found->log), "log");  // late, rows since the start stand there
    char row[hal::civil_text_size];
    const std::string_view text(row, static_cast<std::size_t>(hal::write_civil_text(row, record_.row_time) - row));
    say("resuming after row {} ({}, generation {})", text, hal::text_of(found->outcome), found->generation);
    if (found->dropped_transitions > 0) {
      say("{} of {} transitions are damaged and left out of the replay", found->dropped_transitions,
          found->dropped_transitions + std::min<std::uint64_t>(found->replay_count, Ring::capacity));
    }
    return Found::state;
  }

  /// There was state on this box, and what was learned is gone: the schedule runs until a person has seen it.
  void lose_state() {
    state_lost_ = true;
    lost_until_ = record_was_whole_ ? record_.row_time : CivilTime{};
    if (log_ && log_->ready() && log_->position().bytes > 0) lost_until_ = std::max(lost_until_, log_->last_time());
    say("state in {}: no saved generation is whole and of this version", site_.state_dir);
    if (lost_until_.seconds == 0) return say("what this box had learned is lost");
    char row[hal::civil_text_size];
    const std::string_view text(row, static_cast<std::size_t>(hal::write_civil_text(row, lost_until_) - row));
    say("what this box had learned until row {} is lost", text);
  }

  /// What another topology or version has learned is lost to this one, but not gone: the schedule runs until a person
  /// has seen it.
  void set_other_aside() {
    lose_state();
    const hal::StoreResult<void> aside = store_->archive_foreign_state();
    if (aside) say("it is kept there as other-*; control begins anew");
    if (!aside) say("it cannot be set aside: {}; each row tries again", hal::text_of(aside.error().fault));
  }

  /// The state's medium came after the start. What it holds is worth more than what was learned since.
  void resume_late(CivilTime t) {
    const bool known = state_lost_;
    const ModeArbiter since_start = controller_.cycle().mode_arbiter;
    const Found found = load_state(true);
    trial_.join_counters(record_.trial, record_was_whole_);
    if (found == Found::nothing) begin_from_blob();
    controller_.join_releases(since_start, t);
    const bool waits_for_person = found == Found::nothing && since_start.active(Reason::state_lost, t);
    if (state_lost_ && (!known || waits_for_person)) controller_.hold(Reason::state_lost, t, 0);
  }

  /// The first commit of a start whose state folder was out of reach, onto a medium that turned out to be empty.
  void find_late_loss(CivilTime t) {
    if (is_new_ || record_was_whole_ || state_lost_) return;
    lose_state();
    controller_.hold(Reason::state_lost, t, 0);
  }

  /// Undoes what load_state() may have overwritten.
  Found forget() {
    const LimitsTable<T> limits = controller_.limits();
    controller_.configure(controller_.settings(), limits, hal::box_kernels(), site_.seed);
    record_ = fresh_record();
    if (store_) store_->replay_replaced();
    learning_exchanged_ = true;
    trial_.tell_anew();
    return Found::nothing;
  }

  /// The same where the record itself is whole: an old blob must not come in again by this way, and an AHU that was
  /// released must not be written to.
  Found forget_weights() {
    const auto counters = record_.trial.counter;
    ModeArbiter mode_arbiter = record_.cycle.mode_arbiter;
    mode_arbiter.keep_only_releases();
    const Found nothing = forget();
    record_.trial.counter = counters;
    controller_.take_reasons(mode_arbiter);
    return nothing;
  }

  static RowRecord<T> fresh_record() {
    return {.cycle = {}, .decision = Controller<T>::schedule_decision(), .row_time = {}, .trial = {}};
  }

  void note(const hal::StoreResult<void>& result, const char* what) {
    const char* before = storage_;
    storage_ = result ? "ok" : hal::text_of(result.error().fault);
    if (!result && std::strcmp(before, storage_) != 0) say("{}: {} ({})", what, storage_, result.error().step);
  }

  const hal::SiteFile& site_;
  hal::Sync sync_;
  Controller<T>& controller_;
  std::unique_ptr<Payload> payload_;  ///< of the site's blob: a state that comes late may be one of other weights
  std::optional<hal::Log> history_;   ///< until resume() has ended
  std::uint32_t blob_crc_ = 0;
  std::size_t blob_bytes_ = 0;
  std::optional<hal::DurableStore> store_;
  std::optional<hal::RowLog> log_;
  hal::LogRow log_row_;
  RowRecord<T> record_ = fresh_record();
  WeightsTrial<T> trial_;
  WeightsExport<T> export_;
  /// This process has committed once: until then the medium may hold weights that forget() discarded.
  bool has_committed_ = false, row_committed_ = false;
  bool learning_exchanged_ = false;  ///< and not committed yet
  bool state_lost_ = false, taken_over_ = false;
  bool is_new_ = false;            ///< at the start nothing said that this box had ever committed
  bool record_was_whole_ = false;  ///< the last load found a whole row record, with its counters and releases
  CivilTime lost_until_;
  const char* storage_ = "ok";
};

}  // namespace airside::edge
