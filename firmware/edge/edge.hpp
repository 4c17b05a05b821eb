#pragma once
// The daemon's wiring for one topology: plant, clock, controller, memory, status. Everything is made in the constructor
// and start(); run() allocates nothing.

#include <algorithm>
#include <csignal>
#include <memory>
#include <optional>
#include <string>

#include "airside/controller/cycle.hpp"
#include "airside/controller/instances.hpp"
#include "firmware/edge/daemon.hpp"
#include "firmware/edge/edge_memory.hpp"
#include "firmware/edge/plant_clock_report.hpp"
#include "firmware/edge/row_status.hpp"
#include "firmware/edge/say.hpp"
#include "hal/modbus/plant.hpp"
#include "hal/modbus/plant_clock.hpp"
#include "hal/modbus/wire.hpp"
#include "hal/points/signal_limits.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/storage/start_ledger.hpp"
#include "hal/system/service_manager.hpp"

namespace airside::edge {

template <Topology T>
class Edge final : public Daemon {
 public:
  Edge(const hal::SiteFile& site, const hal::PointMap& points, const DaemonOptions& options, hal::StopFlag stop)
      : site_(site),
        limits_(hal::signal_limits<T>(points)),
        options_(options),
        stop_(stop),
        link_(hal::link_settings(*site.modbus, options.backoff_first_s)),
        plant_(points, link_, {.utc_offset_s = std::nullopt, .clock_speed = options.clock_speed}),
        system_clock_(stop, std::nullopt, options.clock_speed),
        controller_(std::make_unique<Controller<T>>()),
        memory_(site_, options.sync, *controller_),
        status_(site_.state_dir),
        starts_(site.state_dir, options.sync) {
    hal::refuse_contradiction(site, points);
    if (const std::string warning = hal::warning_of(points); !warning.empty()) say("{}: {}", points.file(), warning);
    controller_->configure(hal::controller_settings(site, points), limits_, hal::box_kernels(), site.seed);
    if (site.clock == hal::ClockSource::plant) plant_clock_.emplace(points, link_, stop, options.stall_s);
    for (int i = 0; i < Layout<T>::signals; ++i) names_[static_cast<std::size_t>(i)] = hal::point_name(signal_id<T>(i));
  }

  void start() override {
    memory_.open();
    report_watchdog();
    if (options_.crash_limit > 0) recent_starts_ = starts_.record(crash_window_s);
    if (!starts_.is_kept() && !site_.state_dir.empty()) {
      say("starts in {} cannot be written; a crash loop would not be seen", site_.state_dir);
    }
    const CivilTime last = memory_.resume();
    next_ = {last.seconds == 0 ? 0 : last.seconds + row_s};
  }

  std::string check() override { return memory_.check(); }

  int run() override {
    service_.tell("READY=1");  // now: a plant that is away for a day must not look like a start that fails
    if (!wait_for_plant()) return ended();
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
      t = plant_clock_ ? run_cycles<T>(asked_plant_, *plant_clock_, *controller_, *this, t, end)
                       : run_cycles<T>(asked_plant_, beating_clock_, *controller_, *this, t, end);
      if (plant_clock_ && plant_clock_->stalled()) {
        say("the plant's clock stands still at row {}; is its server running?", t.seconds);
      }
      if (plant_clock_ && plant_clock_->set_back()) {
        PlantClockReport::set_back(t, plant_clock_->woke());
        t = next_row(plant_clock_->now());
      }
    }
    next_ = t;
    memory_.end();
    return ended();
  }

  /// After each row: remember it, show it.
  bool row(CivilTime t, const Expected<Reading<T>>& sensed, const Controller<T>& controller) {
    const bool clock_is_set = report_clock(t);
    controller_->report(Reason::map_differs, plant_.other_device(), t);
    report_bus(t);
    memory_.row(t, sensed, clock_is_set);  // one of 1970 would stand before all others
    controller_->report(Reason::storage_failed, !memory_.is_well() || !status_.is_well(), t);
    if (memory_.taken_over()) controller_->hold(Reason::two_masters, t, 0);
    beats_ = controller.cycle().mode_arbiter.beats(t);
    if (beats_) (void)plant_.beat();
    memory_.give_weights(t);
    if (plant_clock_) clock_report_.row(plant_clock_->jumps());
    last_row_ = t;
    last_sensed_ = sensed;
    write_status();
    service_.tell("WATCHDOG=1");  // only a row that came through every stage is a sign of life
    say_mode(controller.control_mode(t));
    if (options_.crash_limit > 0 && recent_starts_ > 0 && hal::monotonic_ns() - began_ns_ >= hour_s * 1'000'000'000) {
      starts_.clear();
      recent_starts_ = 0;
    }
    return !stop_.raised();
  }

  const Controller<T>& controller() const { return *controller_; }

  [[nodiscard]] std::uint64_t transitions() const override { return controller_->replay().total_pushed(); }

 private:
  static constexpr std::int64_t crash_window_s = 600, hour_s = 3600;
  static constexpr CivilTime built_after{1'704'067'200};  ///< 2024-01-01: no clock of a working box is before

  /// An orderly end is no crash, whatever came before it.
  int ended() {
    if (options_.crash_limit > 0) starts_.clear();
    // Else it would be read as running until it is old. Where another daemon has the folder, the status is its.
    if (!memory_.taken_over()) write_status(plant_clock_ ? plant_clock_->woke() : system_clock_.now());
    return 0;
  }

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
    controller_->tick(t);  // before it is known whether the clock has been set since the last row
    report_clock(t);
    if (options_.crash_limit > 0 && recent_starts_ >= options_.crash_limit) {
      say("{} starts within ten minutes; the schedule runs for an hour", recent_starts_);
      controller_->hold(Reason::crash_loop, t, hour_s);
    }
    if (memory_.state_lost()) controller_->hold(Reason::state_lost, t, 0);
    beats_ =
        next_.seconds > 0 && controller_->cycle().mode_arbiter.beats(t);  // where it goes on, before the first row too
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

  /// One line whenever the control mode or its reason changes.
  void say_mode(const ActiveMode& on) {
    if (on == said_mode_) return;
    say("{}: {}; {}", text_of(on.mode), why_of(on), way_out_of(on));
    said_mode_ = on;
  }

  /// The AHU, unless a person wants it back: the row that finds his wish comes after its own write.
  struct AskedPlant {
    Edge* edge;
    Expected<Reading<T>> sense() const { return edge->plant_.sense(); }
    Expected<Applied> actuate(const Command& command) const {
      if (edge->memory_.release_waits()) return tl::unexpected(Fault::released);
      return edge->plant_.actuate(command);
    }
  };

  /// The machine's clock, whose waiting goes on with the heartbeat.
  struct BeatingClock {
    Edge* edge;
    CivilTime now() const { return edge->system_clock_.now(); }
    bool sleep_until(CivilTime t) const {
      return edge->system_clock_.sleep_until(t, edge->site_.modbus->heartbeat_s, [this] { edge->beat_between_rows(); });
    }
    CivilTime woke() const { return edge->system_clock_.woke(); }
  };

  /// The AHU takes over soon after this program is gone, hangs, or a person has asked for it: not first at a row.
  /// On a new connection everything is read before anything is written, as at a row; and no attempt that fails here may
  /// leave the link waiting when the row is due.
  void beat_between_rows() {
    const double left_s = static_cast<double>(system_clock_.due_ns() - hal::monotonic_ns()) * 1e-9;
    // A wall clock that was set back makes one wait longer than a row, never than two cycles: no sign of a hang.
    if (left_s > row_s) service_.tell("WATCHDOG=1");
    if (!beats_ || memory_.release_waits() || left_s < link_.failure_costs_s()) return;
    if (plant_.beat() || plant_.in_touch()) return;
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
      last_sensed_ = tl::unexpected(sensed.error());
      if (!said) write_status();  // what is there may say that the daemon has stopped
      said = true;
      hal::sleep_until_ns(hal::monotonic_ns() + 100'000'000, stop_);
    }
    return false;
  }

  /// Of the last row; `stopped_at` at an orderly end.
  void write_status(CivilTime stopped_at = {}) {
    if (last_row_.seconds == 0) last_row_ = next_.seconds != 0 ? next_ : system_clock_.now();  // before the first row
    StatusSnapshot s = row_status<T>(last_row_, last_sensed_, *controller_, plant_);
    s.site = site_.name;
    if (s.decision.fault_signal >= 0) s.fault_signal = names_[static_cast<std::size_t>(s.decision.fault_signal)];
    s.generation = memory_.generation();
    s.lost_until = memory_.lost_until();
    s.storage = memory_.is_well() && !status_.is_well() ? "status cannot be written" : memory_.storage();
    s.trial = text_of(memory_.trial().state);
    s.trial_refusal = text_of(memory_.trial().refusal);
    s.trial_refusal_field = memory_.trial().refusal_field.data();
    s.pushed_crc = memory_.trial().blob_crc;
    s.clock = clock_report_.text();
    s.stopped_at = stopped_at;
    if (!plant_clock_ && stopped_at.seconds == 0 && system_clock_.woke_ns() != 0) {
      s.row_late_ms = static_cast<double>(system_clock_.woke_ns() - system_clock_.due_ns()) * 1e-6;
      s.row_done_ms = static_cast<double>(hal::monotonic_ns() - system_clock_.due_ns()) * 1e-6;
    }
    (void)status_.write(last_row_, s);
  }

  hal::SiteFile site_;
  LimitsTable<T> limits_;
  DaemonOptions options_;
  hal::StopFlag stop_;
  hal::ModbusLink link_;
  hal::ModbusPlant<T> plant_;
  hal::SystemClock system_clock_;
  BeatingClock beating_clock_{this};
  AskedPlant asked_plant_{this};
  bool beats_ = false;  ///< as of the last row: the heartbeat goes on
  std::optional<hal::ModbusPlantClock> plant_clock_;
  std::unique_ptr<Controller<T>> controller_;
  EdgeMemory<T> memory_;
  StatusFile status_;
  std::array<std::string, static_cast<std::size_t>(Layout<T>::signals)> names_;
  CivilTime next_;
  hal::StartLedger starts_;
  hal::ServiceManager service_;
  CivilTime last_row_;
  Expected<Reading<T>> last_sensed_ = tl::unexpected(Fault::no_reading);
  int recent_starts_ = 0;
  std::int64_t began_ns_ = 0;  ///< of this run
  CivilTime newest_row_;       ///< the latest that a clock which can be right has told
  PersistentCondition clock_is_behind_;
  PlantClockReport clock_report_;
  std::string_view said_doubted_;
  ActiveMode said_mode_;
};

}  // namespace airside::edge
