#include "firmware/edge/daemon_state.hpp"

#include <algorithm>
#include <filesystem>
#include <span>
#include <vector>

#include "airside/topologies.hpp"
#include "firmware/edge/report/say.hpp"
#include "hal/log/log_record.hpp"
#include "hal/text/input_error.hpp"
#include "hal/weights/blob_file.hpp"

namespace airside::edge {

template <Topology T>
DaemonState<T>::DaemonState(const hal::SiteFile& site, const hal::TopologyCounts& columns, hal::Sync sync,
                            Controller<T>& controller)
    : site_(site),
      controller_(controller),
      folders_(site, sync),
      columns_(columns),
      shape_(shape_in<T>(columns.shape())),
      log_row_(hal::make_log_row(columns_)),
      trial_(site.keys_dir, site.inbox_dir, site.state_dir, layout(shape_, cycle_of_minutes(site.cycle_min)).meaning,
             sync, site.scope, site.log_dir),
      export_(site.state_dir, site.name, sync) {}

template <Topology T>
hal::StoreLayout DaemonState<T>::layout(const Shape& site, ControlCycle cycle) {
  // What was learned is of one length of the cycle; 0 for 18 min, so that state from before there was another stays.
  const auto other_cycle = static_cast<std::uint64_t>(cycle.rows ^ default_cycle.rows);
  return {.learning_bytes = sizeof(Learning),
          .row_bytes = sizeof(RowRecord<T>),
          .transition_bytes = sizeof(typename Ring::Row),
          .ring_capacity = Ring::capacity,
          .meaning = topology_hash(site, parameters_of<T>(site)) ^ units_hash<T>(site) ^
                     (std::uint64_t{state_version} << 32) ^ (other_cycle << 56)};
}

template <Topology T>
void DaemonState<T>::open() {
  blob_crc_ = load_blob();
  std::error_code ignored;
  if (!std::filesystem::exists(site_.state_dir, ignored)) load_history();
  folders_.open_log(columns_);
  folders_.open_store(layout(shape_, cycle_of_minutes(site_.cycle_min)));
  trial_.open_inbox();
  export_.open();
}

template <Topology T>
CivilTime DaemonState<T>::resume() {
  is_new_ = !trial_.has_counters() && !(folders_.log() && folders_.log()->holds_past());
  logged_until_ = folders_.last_logged();
  const Found found = load_state();
  if (found == Found::nothing && !record_was_whole_ && !is_new_ && folders_.has_store() && !state_lost_) lose_state();
  trial_.join_counters(record_.trial, record_was_whole_ || (is_new_ && !state_lost_));
  if (found == Found::nothing) {
    begin_from_blob();
    if (uses_history(controller_.settings(), blob_bytes_ > 0)) remember_history();
    if (folders_.log()) folders_.note(folders_.log()->resume({}), "log");
  }
  history_.reset();
  return found == Found::state ? record_.row_time : CivilTime{};
}

template <Topology T>
std::string DaemonState<T>::check() {
  folders_.refuse_unwritable();
  (void)load_blob();
  if (!site_.history_log.empty()) (void)hal::read_log(site_.history_log, columns_);
  return hal::describe(hal::KeyRing::load(site_.keys_dir));
}

template <Topology T>
void DaemonState<T>::row(CivilTime t, const Expected<Reading<T>>& sensed, bool has_date) {
  if (has_date) record_.believed_day = static_cast<std::uint32_t>(std::max<std::int64_t>(t.day(), 0));
  hal::fill_log_row<T>(log_row_, shape_, t, sensed, controller_.decision(), controller_.cycle().last_setpoint_degc);
  hal::fill_sides<T>(log_row_, columns_.sides, sensed);
  auto& log = folders_.log();
  auto& store = folders_.store();
  const bool logs = log && has_date;
  hal::StoreResult<void> logged = logs ? log->append(log_row_) : hal::StoreResult<void>{};
  if (logged && logs) logged = log->sync();
  const bool exchanged = trial_.row(t, controller_, record_.trial);
  if (exchanged && store) store->replay_replaced();
  if (exchanged) learning_exchanged_ = true;
  hal::StoreResult<void> committed = store ? store->commit(state(t)) : hal::StoreResult<void>{};
  if (!committed && committed.error().fault == hal::StoreFault::unread) {
    resume_late(t);
    committed = store->commit(state(t));
  }
  // At a start a locked folder ends the daemon; later it means that another one has taken it.
  taken_over_ = !committed && committed.error().fault == hal::StoreFault::locked;
  if (committed && !has_committed_) find_late_loss(t);
  has_committed_ = has_committed_ || committed;
  row_committed_ = committed.has_value();
  hal::StoreResult<void> beside;  // what is neither log nor state, and must not be missing unseen
  if (committed) {
    learning_exchanged_ = false;
    beside = trial_.committed();
    if (beside) beside = export_.blocked();
  }
  if (!logged) return folders_.note_logged(logged, t);
  if (!committed) return folders_.note(committed, "state");
  folders_.note(beside, "files beside the state");
}

template <Topology T>
void DaemonState<T>::give_weights(CivilTime t) {
  if (row_committed_) export_.row(t, controller_, record_.trial);
}

template <Topology T>
void DaemonState<T>::end() {
  if (has_committed_) export_.end(record_.row_time, controller_, record_.trial);
}

template <Topology T>
hal::StoredState DaemonState<T>::state(CivilTime t) {
  // The cycle's part of the record is copied, the large parts are written from where they are.
  record_.cycle = controller_.cycle();
  record_.decision = controller_.decision();
  record_.row_time = t;
  return {
      .learning = controller_.saved_bytes().learning,
      .row = std::as_bytes(std::span(&record_, 1)),
      .replay = controller_.saved_bytes().replay,
      .replay_count = controller_.replay().total_pushed(),
      .log = folders_.log_position(),
      .learning_changed = control_cycle(controller_.settings()).starts(t) || !has_committed_ || learning_exchanged_};
}

/// Reads the blob, if the site names one. Returns its checksum, 0 without.
template <Topology T>
std::uint32_t DaemonState<T>::load_blob() {
  if (site_.weights_blob.empty()) return 0;
  payload_ = std::make_unique<Payload>();
  const std::vector<std::byte> bytes = hal::read_blob_file(site_.weights_blob);
  payload_->site = shape_;
  payload_->cycle = control_cycle(controller_.settings());
  hal::decode_blob<T>(bytes, site_.scope, site_.weights_blob, *payload_);
  blob_bytes_ = bytes.size();
  return crc32c(bytes);
}

/// Reads the schedule's days, where something learns from them. A resumed state has them already and needs no file.
template <Topology T>
void DaemonState<T>::load_history() {
  if (uses_history(controller_.settings(), blob_bytes_ > 0) && !site_.history_log.empty()) {
    history_ = hal::read_log(site_.history_log, columns_);
  }
}

/// Cost: no heap.
template <Topology T>
void DaemonState<T>::begin_from_blob() {
  record_.blob_crc = blob_crc_;
  if (blob_bytes_ == 0) return;
  take_payload<T>(controller_, *payload_);
  say("starting from {}", site_.weights_blob);
}

template <Topology T>
void DaemonState<T>::remember_history() {
  if (!history_) load_history();
  if (!history_) return;
  HistoryReader<T> reader(controller_, HistoryReader<T>::Head::leave);
  for (const hal::LogRow& row : history_->rows) {
    reader.row(hal::reading_of<T>(row, shape_, columns_.sides), row.setpoint_degc);
  }
  if (reader.demand_rows() > 0) say("learned demand from {} rows of {}", reader.demand_rows(), site_.history_log);
  if (blob_bytes_ > 0) say("remembered {} transitions of {}", reader.transitions(), site_.history_log);
}

/// Loads the newest generation; the inbox is reported to it anew. `late`: after rows that were not committed. Cost: no
/// heap.
template <Topology T>
typename DaemonState<T>::Found DaemonState<T>::load_state(bool late) {
  auto& store = folders_.store();
  if (!store) return Found::nothing;
  const auto found = store->load({.learning = controller_.loaded_bytes().learning,
                                  .row = std::as_writable_bytes(std::span(&record_, 1)),
                                  .replay = controller_.loaded_bytes().replay});
  if (!found) {
    say("state in {}: {} ({})", site_.state_dir, hal::text_of(found.error().fault), found.error().step);
    if (found.error().fault != hal::StoreFault::other_layout) return forget();
    archive_foreign_state();
    return late ? Found::nothing_read : forget();  // late, what was learned since the start is kept
  }
  if (found->outcome == hal::LoadOutcome::none) {
    // Kept files of another version beside none of this one: a start that did not come to its first row.
    const bool lost = found->damaged_records > 0 || store->keeps_other();
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
  // Late, rows since the start are in the log.
  if (folders_.log() && !late) folders_.note(folders_.log()->resume(found->log), "log");
  folders_.say_resumed(*found, record_.row_time, Ring::capacity);
  return Found::state;
}

/// There was state on this box, and what was learned is gone: the schedule runs until a person has seen it.
template <Topology T>
void DaemonState<T>::lose_state() {
  state_lost_ = true;
  lost_until_ = record_was_whole_ ? std::max(record_.row_time, logged_until_) : logged_until_;
  folders_.say_lost(lost_until_);
}

/// What another topology or version has learned is lost to this one, but not gone.
template <Topology T>
void DaemonState<T>::archive_foreign_state() {
  lose_state();
  folders_.archive_foreign_state();
}

/// The state's medium came after the start. What it holds is worth more than what was learned since.
template <Topology T>
void DaemonState<T>::resume_late(CivilTime t) {
  const bool known = state_lost_;
  const StoredSetpoint stored = controller_.cycle().stored;
  const ModeArbiter since_start = controller_.cycle().mode_arbiter;
  const Found found = load_state(true);
  trial_.join_counters(record_.trial, record_was_whole_);
  if (found == Found::nothing) begin_from_blob();
  controller_.take_stored(stored);  // of this process, which has written since
  controller_.join_releases(since_start, t);
  const bool waits_for_person = found == Found::nothing && since_start.active(Reason::state_lost, t);
  if (state_lost_ && (!known || waits_for_person)) controller_.hold(Reason::state_lost, t, 0);
}

/// The first commit of a start whose state folder was out of reach, onto a medium that turned out to be empty.
template <Topology T>
void DaemonState<T>::find_late_loss(CivilTime t) {
  if (is_new_ || record_was_whole_ || state_lost_) return;
  lose_state();
  controller_.hold(Reason::state_lost, t, 0);
}

/// Undoes what load_state() may have overwritten.
template <Topology T>
typename DaemonState<T>::Found DaemonState<T>::forget() {
  const LimitsTable<T> limits = controller_.limits();
  controller_.configure(controller_.settings(), limits, hal::box_kernels(), site_.seed);
  record_ = fresh_record();
  if (folders_.store()) folders_.store()->replay_replaced();
  learning_exchanged_ = true;
  trial_.tell_anew();
  return Found::nothing;
}

/// The same where the record itself is whole: an old blob must not come in again by this way, and an AHU that was
/// released must not be written to.
template <Topology T>
typename DaemonState<T>::Found DaemonState<T>::forget_weights() {
  const auto counters = record_.trial.counter;
  ModeArbiter mode_arbiter = record_.cycle.mode_arbiter;
  mode_arbiter.keep_only_releases();
  const StoredSetpoint stored = record_.cycle.stored;
  const std::uint32_t believed_day = record_.believed_day;
  const Found nothing = forget();
  record_.trial.counter = counters;
  record_.believed_day = believed_day;
  controller_.take_reasons(mode_arbiter);
  controller_.take_stored(stored);
  return nothing;
}

template <Topology T>
RowRecord<T> DaemonState<T>::fresh_record() {
  return {.cycle = {}, .decision = Controller<T>::schedule_decision(), .row_time = {}, .trial = {}};
}

#define AIRSIDE_INSTANTIATE(Tag) template class DaemonState<Tag>;
AIRSIDE_FOR_EACH_TOPOLOGY(AIRSIDE_INSTANTIATE)
#undef AIRSIDE_INSTANTIATE

}  // namespace airside::edge
