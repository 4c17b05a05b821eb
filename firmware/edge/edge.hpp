#pragma once
// The daemon's wiring for one topology: plant, clock, controller, durable state, log, status. Everything is made in
// the constructor and start(); run() allocates nothing.

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "airside/controller_instances.hpp"
#include "airside/cycle.hpp"
#include "airside/history.hpp"
#include "firmware/edge/daemon.hpp"
#include "firmware/edge/say.hpp"
#include "firmware/edge/status_snapshot.hpp"
#include "firmware/edge/weights_export.hpp"
#include "firmware/edge/weights_trial.hpp"
#include "hal/blob_file.hpp"
#include "hal/civil_text.hpp"
#include "hal/durable_store.hpp"
#include "hal/input_error.hpp"
#include "hal/log_csv.hpp"
#include "hal/log_record.hpp"
#include "hal/modbus_plant.hpp"
#include "hal/modbus_wire.hpp"
#include "hal/plant_clock.hpp"
#include "hal/row_log.hpp"
#include "hal/service_manager.hpp"
#include "hal/signal_limits.hpp"
#include "hal/site_settings.hpp"
#include "hal/start_ledger.hpp"

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

template <Topology T>
class Edge final : public Daemon {
  using Learning = LearningState<T, float>;
  using Ring = ReplayRing<T, float>;

 public:
  Edge(const hal::SiteFile& site, const hal::PointMap& points, const EdgeOptions& options, hal::StopFlag stop)
      : site_(site),
        limits_(hal::signal_limits<T>(points)),
        options_(options),
        stop_(stop),
        link_(hal::link_settings(*site.modbus, options.backoff_first_s)),
        plant_(points, link_, {.utc_offset_s = std::nullopt, .clock_speed = options.clock_speed}),
        system_clock_(stop, std::nullopt, options.clock_speed),
        controller_(std::make_unique<Controller<T>>()),
        log_row_(hal::make_log_row(hal::counts_of<T>())),
        starts_(site.state_dir, options.sync),
        trial_(site.keys_dir, site.inbox_dir, site.state_dir, layout().meaning, options.sync, site.scope),
        export_(site.state_dir, site.name, options.sync) {
    controller_->configure(hal::controller_settings(site), limits_, hal::box_kernels(), site.seed);
    if (site.clock == hal::ClockSource::plant) plant_clock_.emplace(points, link_, stop, options.stall_s);
    for (int i = 0; i < Layout<T>::signals; ++i) names_[static_cast<std::size_t>(i)] = hal::point_name(signal_id<T>(i));
  }

  void start() override {
    const std::uint32_t blob_crc = load_blob();  // first: a refused blob or history leaves no folder behind
    std::error_code ignored;
    if (!std::filesystem::exists(site_.state_dir, ignored)) load_history();
    open_log();
    open_store();
    status_.emplace(site_.state_dir);
    trial_.open_inbox();
    export_.open();
    report_watchdog();
    if (options_.crash_limit > 0) recent_starts_ = starts_.record(crash_window_s);
    const CivilTime resumed = load_state(blob_crc);
    if (resumed.seconds == 0) {
      record_.blob_crc = blob_crc;
      if (blob_bytes_ > 0) begin_from_blob();
      if (log_) note(log_->resume({}), "log");
    }
    next_ = {resumed.seconds == 0 ? 0 : resumed.seconds + row_s};
    payload_.reset();
    history_.reset();
  }

  void check() override {
    (void)load_blob();
    load_history();
  }

  int run() override {
    service_.tell("READY=1");  // now: a plant that is away for a day must not look like a start that fails
    if (!wait_for_plant()) return 0;
    const CivilTime end = options_.until.value_or(CivilTime{std::numeric_limits<std::int64_t>::max()});
    const CivilTime present = next_row(now());
    CivilTime t = std::max(next_, present);
    if (t.seconds - present.seconds > row_s) {
      // The state comes from the future: its clock was wrong, or this one is. Waiting would leave the room alone.
      say("the state is {} s ahead of the clock; going on from the clock", t.seconds - present.seconds);
      t = present;
    }
    newest_row_ = next_;
    report_start(t);
    while (!stop_.raised() && t < end) {
      t = plant_clock_ ? run_cycles<T>(plant_, *plant_clock_, *controller_, *this, t, end)
                       : run_cycles<T>(plant_, beating_clock_, *controller_, *this, t, end);
      if (plant_clock_ && plant_clock_->stalled()) {
        say("the plant's clock stands still at row {}; is its server running?", t.seconds);
      }
    }
    next_ = t;
    if (committed_) export_.end(record_.row_time, *controller_, record_.trial);
    if (options_.crash_limit > 0) starts_.clear();
    return 0;
  }

  /// After each row: log it, commit it, show it. Order matters: the log first, then the commit that names its end.
  bool row(CivilTime t, const Expected<Reading<T>>& sensed, const Controller<T>& controller) {
    const bool clock_is_set = report_clock(t);
    controller_->report(Reason::map_differs, plant_.other_device(), t);
    report_bus(t);
    hal::fill_log_row<T>(log_row_, t, sensed, controller.decision(), controller.cycle().last_setpoint_degc);
    // A row of 1970 would stand before all others; what the clock cannot date is not logged.
    const bool logs = log_ && clock_is_set;
    hal::StoreResult<void> logged = logs ? log_->append(log_row_) : hal::StoreResult<void>{};
    if (logged && logs) logged = log_->sync();
    const bool exchanged = trial_.row(t, *controller_, record_.trial);
    if (exchanged && store_) store_->replay_replaced();
    if (exchanged) learning_exchanged_ = true;
    hal::StoreResult<void> committed = store_ ? store_->commit(state(t)) : hal::StoreResult<void>{};
    if (!committed && committed.error().fault == hal::StoreFault::unread) {
      resume_late();
      committed = store_->commit(state(t));
    }
    committed_ = committed_ || committed;
    if (committed) {
      learning_exchanged_ = false;
      trial_.committed();
    }
    note(logged ? committed : logged, logged ? "state" : "log");
    controller_->report(Reason::storage_failed, std::strcmp(storage_, "ok") != 0, t);
    beats_ = controller.cycle().ladder.beats(t);
    if (beats_) (void)plant_.beat();
    if (committed) export_.row(t, *controller_, record_.trial);
    write_status(t, sensed);
    service_.tell("WATCHDOG=1");  // only a row that came through every stage is a sign of life
    say_rung(controller.rung(t));
    if (options_.crash_limit > 0 && recent_starts_ > 0 && hal::monotonic_ns() - began_ns_ >= hour_s * 1'000'000'000) {
      starts_.clear();
      recent_starts_ = 0;
    }
    return !stop_.raised();
  }

  const Controller<T>& controller() const { return *controller_; }

  [[nodiscard]] std::uint64_t transitions() const override { return controller_->replay().total_pushed(); }

  /// Sizes of the durable state of this topology and build.
  static hal::StoreLayout layout() {
    return {.learning_bytes = sizeof(Learning),
            .row_bytes = sizeof(RowRecord<T>),
            .transition_bytes = sizeof(typename Ring::Row),
            .ring_capacity = Ring::capacity,
            .meaning = topology_hash<T>(NetworkWeights<T, float>::count) ^ units_hash<T>() ^
                       (std::uint64_t{state_version} << 32)};
  }

 private:
  static constexpr std::int64_t crash_window_s = 600, hour_s = 3600;
  static constexpr CivilTime built_after{1'704'067'200};  ///< 2024-01-01: no clock of a working box is before

  /// A watchdog that a late row would trip restarts a healthy daemon.
  void report_watchdog() const {
    constexpr double least_s = 2.0 * row_s;
    const double given_s = service_.watchdog_s();
    if (given_s <= 0 || given_s > least_s) return;
    say("the unit's WatchdogSec is {} s, and a row comes each {} s; set it above {} s", given_s, row_s, least_s);
  }

  /// What is known when control begins.
  void report_start(CivilTime t) {
    began_ns_ = hal::monotonic_ns();
    report_clock(t);
    if (options_.crash_limit > 0 && recent_starts_ >= options_.crash_limit) {
      say("{} starts within ten minutes; the schedule runs for an hour", recent_starts_);
      controller_->hold(Reason::crash_loop, t, hour_s);
    }
    if (state_lost_) controller_->hold(Reason::state_lost, t, 0);
    beats_ = next_.seconds > 0 && controller_->cycle().ladder.beats(t);  // where it goes on, before the first row too
  }

  /// A clock before this program was written, or a day before the last row, has not been set since power came back.
  /// Returns whether it can be right. A simulated plant may live in any year; a clock that was ahead and is right now
  /// is believed after a day.
  bool report_clock(CivilTime t) {
    constexpr std::int64_t day_s = 86400;
    const bool possible = plant_clock_ || t >= built_after;
    const bool behind = !plant_clock_ && t.seconds <= newest_row_.seconds - day_s;
    if (clock_is_behind_.lasts(possible && behind, t, day_s)) newest_row_ = t;
    const bool is_set = possible && (!behind || newest_row_ == t);
    controller_->report(Reason::clock_not_set, !is_set, t);
    if (is_set) newest_row_ = std::max(newest_row_, t);
    return is_set;
  }

  /// Alarms of the bus: what a person must put right, while control goes on as far as it can.
  void report_bus(CivilTime t) {
    controller_->report(Reason::map_refused, plant_.map_refused(), t);
    controller_->report(Reason::gateway_failed, plant_.gateway_failed(), t);
    const hal::Point* doubted = plant_.order_doubted();
    controller_->report(Reason::order_doubted, doubted != nullptr, t);
    if (doubted != nullptr && doubted->name != said_doubted_) {
      say("{}: its words make sense only in another order; airside probe shows which", doubted->name);
    }
    said_doubted_ = doubted != nullptr ? std::string_view(doubted->name) : std::string_view{};
  }

  /// One line whenever the rung or its reason changes.
  void say_rung(const OnRung& on) {
    if (on == said_rung_) return;
    say("{}: {}; {}", text_of(on.mode), rung_of(on.reason).why, rung_of(on.reason).way_out);
    said_rung_ = on;
  }

  /// The machine's clock, whose waiting goes on with the heartbeat.
  struct BeatingClock {
    Edge* edge;
    CivilTime now() const { return edge->system_clock_.now(); }
    bool sleep_until(CivilTime t) const {
      return edge->system_clock_.sleep_until(t, edge->site_.modbus->heartbeat_s, [this] { edge->beat_between_rows(); });
    }
  };

  /// The AHU takes over soon after this program is gone, hangs, or a person has asked for it: not first at a row.
  /// On a new connection everything is read before anything is written, as at a row.
  void beat_between_rows() {
    if (!beats_ || trial_.release_waits() || plant_.beat() || plant_.in_touch()) return;
    (void)plant_.sense();
    (void)plant_.beat();
  }

  CivilTime now() { return plant_clock_ ? plant_clock_->now() : system_clock_.now(); }

  /// Until the plant answers once: a clock that was never read must not decide where to begin. False: told to stop.
  bool wait_for_plant() {
    bool said = false;
    while (!stop_.raised()) {
      const Expected<Reading<T>> sensed = plant_.sense();
      if (sensed) return true;
      service_.tell("WATCHDOG=1");  // a poll that came to its end; rows begin with the first answer
      if (!said && sensed.error() == Fault::other_device) {
        say("{} is not the device that the point map describes; nothing is written to it", link_.description());
      } else if (!said) {
        say("no answer from {}; trying again", link_.description());
      }
      said = true;
      hal::sleep_until_ns(hal::monotonic_ns() + 100'000'000, stop_);
    }
    return false;
  }

  static std::span<const std::byte> bytes_of(const void* p, std::size_t n) {
    return {static_cast<const std::byte*>(p), n};
  }
  static std::span<std::byte> bytes_of(void* p, std::size_t n) { return {static_cast<std::byte*>(p), n}; }

  hal::StoredState state(CivilTime t) {
    // The cycle's part of the record is copied, the large parts are written from where they stand.
    record_.cycle = controller_->cycle();
    record_.decision = controller_->decision();
    record_.row_time = t;
    return {.learning = bytes_of(static_cast<const void*>(&controller_->learning()), sizeof(Learning)),
            .row = bytes_of(static_cast<const void*>(&record_), sizeof record_),
            .replay = bytes_of(static_cast<const void*>(&controller_->replay().slot(0)),
                               sizeof(typename Ring::Row) * static_cast<std::size_t>(Ring::capacity)),
            .replay_count = controller_->replay().total_pushed(),
            .log = log_ ? log_->position() : hal::LogPosition{},
            .learning_changed = starts_cycle(t) || !committed_ || learning_exchanged_};
  }

  void open_log() {
    if (site_.log_dir.empty()) return;
    hal::RowLogLimits limits;
    limits.max_files = site_.log_max_files;
    limits.max_file_bytes = static_cast<std::uint64_t>(site_.log_max_file_mb * 1e6);
    log_.emplace(site_.log_dir.c_str(), hal::counts_of<T>(), limits, options_.sync);
    if (log_->ready()) return;
    storage_ = "log cannot be written";
    say("log in {}: {}; each row tries again", site_.log_dir, hal::describe(log_->ready().error()));
  }

  void open_store() {
    if (site_.state_dir.empty()) return;
    auto opened = hal::DurableStore::open(site_.state_dir.c_str(), layout(), options_.sync);
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

  using Payload = BlobPayload<T, NetworkWeights<T, float>::count>;

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

  void begin_from_blob() {
    take_payload<T>(*controller_, *payload_);
    say("starting from {}", site_.weights_blob);
    if (!history_) load_history();
    if (!history_) return;
    HistoryReader<T> reader(*controller_, HistoryReader<T>::Head::leave);
    for (const hal::LogRow& row : history_->rows) {
      reader.row(row.time, Eigen::Map<const typename Reading<T>::Vector>(row.value.data()), row.setpoint_degc);
    }
    say("remembered {} transitions of {}", reader.transitions(), site_.history_log);
  }

  /// Loads the newest generation. Returns the time of its row, 0 if there is none that fits.
  CivilTime load_state(std::uint32_t blob_crc, bool late = false) {
    if (!store_) return {};
    auto& learning = controller_->learning();
    auto found =
        store_->load({.learning = bytes_of(static_cast<void*>(&learning), sizeof(Learning)),
                      .row = bytes_of(static_cast<void*>(&record_), sizeof record_),
                      .replay = bytes_of(static_cast<void*>(&controller_->replay().slot(0)),
                                         sizeof(typename Ring::Row) * static_cast<std::size_t>(Ring::capacity))});
    if (!found) {
      say("state in {}: {}", site_.state_dir, hal::describe(found.error()));
      return forget();
    }
    if (found->outcome == hal::LoadOutcome::none) {
      state_lost_ = found->damaged_records > 0;
      if (state_lost_) say("state in {}: no saved generation is whole", site_.state_dir);
      return forget();
    }
    if (record_.blob_crc != blob_crc) {
      say("the site names other weights than the state grew from; starting from them");
      const auto counters = record_.trial.counter;  // an old blob must not come in again by this way
      const CivilTime none = forget();
      record_.trial.counter = counters;
      return none;
    }
    controller_->cycle() = record_.cycle;
    controller_->replay().restore_count(found->replay_count);
    controller_->restore_decision(record_.decision);
    if (controller_->restored() != Fault::none) {
      say("saved weights are not finite; starting anew");
      return forget();
    }
    if (log_ && !late) note(log_->resume(found->log), "log");  // late, rows since the start stand there
    say("resuming after row {} ({}, generation {})", hal::civil_text(record_.row_time), hal::text_of(found->outcome),
        found->generation);
    return record_.row_time;
  }

  /// The state's medium came after the start. What it holds is worth more than what was learned since.
  void resume_late() {
    const std::uint32_t blob_crc = record_.blob_crc;
    if (load_state(blob_crc, true).seconds == 0) record_.blob_crc = blob_crc;
  }

  /// Undoes what load_state() may have overwritten.
  CivilTime forget() {
    controller_->configure(controller_->settings(), limits_, hal::box_kernels(), site_.seed);
    record_ = fresh_record();
    if (store_) store_->replay_replaced();
    return {};
  }

  static RowRecord<T> fresh_record() {
    return {.cycle = {}, .decision = Controller<T>::schedule_decision(), .row_time = {}, .trial = {}};
  }

  void note(const hal::StoreResult<void>& result, const char* what) {
    const char* before = storage_;
    storage_ = result ? "ok" : hal::text_of(result.error().fault);
    if (!result && std::strcmp(before, storage_) != 0) say("{}: {} ({})", what, storage_, result.error().step);
  }

  void write_status(CivilTime t, const Expected<Reading<T>>& sensed) {
    StatusSnapshot s{
        .site = site_.name, .topology = T::name, .rung = controller_->rung(t), .decision = controller_->decision()};
    s.fault = sensed ? s.decision.fault : sensed.error();
    s.setpoint_degc = controller_->cycle().last_setpoint_degc;
    if (sensed) s.room_temp_degc = {sensed->value.data(), static_cast<std::size_t>(Layout<T>::rooms)};
    s.target_degc = controller_->settings().target_degc;
    if (s.decision.fault_signal >= 0) s.fault_signal = names_[static_cast<std::size_t>(s.decision.fault_signal)];
    s.cycles = controller_->learning().cycles;
    s.rejected_updates = controller_->learning().rejected;
    s.replay_transitions = static_cast<std::uint64_t>(controller_->replay().size());
    s.generation = store_ ? store_->generation() : 0;
    s.has_weights = controller_->cycle().has_weights != 0;
    s.storage = storage_;
    const hal::LinkCounters& link = link_.counters();
    s.link_timeouts = link.timeouts;
    s.link_bad_frames = link.bad_frames;
    s.link_wrong_ids = link.wrong_ids;
    s.link_exceptions = link.exceptions;
    s.setpoint_writes = plant_.setpoint_writes();
    s.ladder = &controller_->cycle().ladder;
    s.trial = text_of(record_.trial.state);
    s.trial_refusal = text_of(record_.trial.refusal);
    s.pushed_crc = record_.trial.blob_crc;
    if (!plant_clock_) {
      s.row_late_ms = static_cast<double>(system_clock_.woke_ns() - system_clock_.due_ns()) * 1e-6;
      s.row_done_ms = static_cast<double>(hal::monotonic_ns() - system_clock_.due_ns()) * 1e-6;
    }
    s.ours_error_k = controller_->cycle().shadow.ours_k();
    s.schedule_error_k = controller_->cycle().shadow.schedule_k();
    (void)status_->write(t, s);
  }

  hal::SiteFile site_;
  LimitsTable<T> limits_;
  EdgeOptions options_;
  hal::StopFlag stop_;
  hal::ModbusLink link_;
  hal::ModbusPlant<T> plant_;
  hal::SystemClock system_clock_;
  BeatingClock beating_clock_{this};
  bool beats_ = false;  ///< as of the last row: the heartbeat goes on
  std::optional<hal::ModbusPlantClock> plant_clock_;
  std::unique_ptr<Controller<T>> controller_;
  std::unique_ptr<Payload> payload_;
  std::size_t blob_bytes_ = 0;
  std::optional<hal::Log> history_;  ///< until start() has ended
  std::optional<hal::DurableStore> store_;
  std::optional<hal::RowLog> log_;
  hal::LogRow log_row_;
  std::optional<StatusFile> status_;  ///< from start() on
  RowRecord<T> record_ = fresh_record();
  std::array<std::string, static_cast<std::size_t>(Layout<T>::signals)> names_;
  CivilTime next_;
  /// This process has committed once: until then the medium may hold weights that forget() discarded.
  bool committed_ = false;
  hal::StartLedger starts_;
  hal::ServiceManager service_;
  WeightsTrial<T> trial_;
  WeightsExport<T> export_;
  bool learning_exchanged_ = false;  ///< and not committed yet
  int recent_starts_ = 0;
  std::int64_t began_ns_ = 0;  ///< of this run
  CivilTime newest_row_;       ///< the latest that a clock which can be right has told
  Spell clock_is_behind_;
  bool state_lost_ = false;
  std::string_view said_doubted_;
  OnRung said_rung_;
  const char* storage_ = "ok";
};

}  // namespace airside::edge
