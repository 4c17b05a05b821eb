#include "firmware/edge/daemon.hpp"

#include <algorithm>
#include <limits>

#include "airside/topologies.hpp"
#include "firmware/edge/report/row_status.hpp"
#include "firmware/edge/report/say.hpp"
#include "hal/modbus/wire.hpp"
#include "hal/site/site_log.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/weights/blob_file.hpp"

namespace airside::edge {

// Every build must read what every other has saved: strict or not, 32 or 64 bits. Where one of these changes on
// purpose, state_version does too.
static_assert(sizeof(LearningState<FiveZone, float>) == 710848 && sizeof(RowRecord<FiveZone>) == 13056);

template <Topology T>
Daemon<T>::Daemon(const hal::SiteFile& site, const hal::PointMap& points, const DaemonOptions& options,
                  hal::StopFlag stop)
    : site_(site),
      limits_(hal::signal_limits<T>(points, shape_in<T>(parse_shape(site.topology.c_str())), site.stand_ins)),
      options_(options),
      stop_(stop),
      link_(hal::link_settings(*site.modbus, options.backoff_first_s)),
      plant_(points, link_, {.utc_offset_s = std::nullopt, .stand_ins = site.stand_ins},
             shape_in<T>(parse_shape(site.topology.c_str()))),
      system_clock_(stop, std::nullopt, options.clock_speed),
      controller_(std::make_unique<Controller<T>>()),
      state_(site_, hal::counts_of(hal::counts_of(parse_shape(site.topology.c_str())), points, site.stand_ins),
             options.sync, *controller_),
      status_(site_.state_dir),
      readings_(points, site_.inbox_dir, site_.state_dir),
      crash_loop_(site.state_dir, options.crash_limit, options.sync) {
  plant_.follow(system_clock_);
  hal::refuse_contradiction(site, points);
  if (const std::string warning = hal::warning_of(points); !warning.empty()) say("{}: {}", points.file(), warning);
  controller_->configure(hal::controller_settings(site, points), limits_, hal::box_kernels(), site.seed);
  if (site.clock == hal::ClockSource::plant) plant_clock_.emplace(points, link_, stop, options.stall_s);
  for (int i = 0; i < Layout<T>::signals; ++i) names_[static_cast<std::size_t>(i)] = hal::point_name(signal_id<T>(i));
}

template <Topology T>
void Daemon<T>::start() {
  state_.open();
  say_watchdog(service_.watchdog_s());
  crash_loop_.start();
  const CivilTime last = state_.resume();
  next_ = {last.seconds == 0 ? 0 : last.seconds + row_s};
  clock_report_.begin(std::max(next_, state_.believed()), plant_clock_.has_value());
  system_clock_.go_on_from(last);
  plant_.follow(system_clock_);
}

template <Topology T>
int Daemon<T>::run() {
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
  begin_control(t);
  while (!stop_.raised() && t < end) t = run_until_disturbed(t, end);
  next_ = t;
  state_.end();
  return ended();
}

/// Rows from t on, until the end, a stop, or a plant's clock that stands still or was set back. Returns the next row.
template <Topology T>
CivilTime Daemon<T>::run_until_disturbed(CivilTime t, CivilTime end) {
  if (!plant_clock_) return run_cycles<T>(asked_plant_, beating_clock_, *controller_, *this, t, end);
  t = run_cycles<T>(asked_plant_, *plant_clock_, *controller_, *this, t, end);
  if (plant_clock_->stalled()) say("the plant's clock stands still at row {}; is its server running?", t.seconds);
  if (!plant_clock_->set_back()) return t;
  PlantClockReport::set_back(t, plant_clock_->woke());
  return next_row(plant_clock_->now());
}

template <Topology T>
bool Daemon<T>::row(CivilTime t, const Expected<Reading<T>>& sensed, const Controller<T>& controller) {
  const bool clock_is_set = report_clock(t);
  controller_->report(Reason::map_differs, plant_.other_device(), t);
  report_bus(t);
  state_.row(t, sensed, clock_is_set);  // one of 1970 would sort before all others
  const bool storage_is_well = state_.is_well() && status_.is_well() && crash_loop_.is_kept();
  controller_->report(Reason::storage_failed, !storage_is_well, t);
  if (state_.taken_over()) controller_->hold(Reason::two_masters, t, 0);
  beats_ = controller.cycle().mode_arbiter.beats(t);
  if (beats_) (void)plant_.beat();
  state_.give_weights(t);
  if (plant_clock_) plant_clock_report_.row(plant_clock_->jumps());
  last_row_ = t;
  first_row_ = {};
  last_sensed_ = sensed;
  note_met(t);
  write_status();
  if (readings_.wanted()) read_points(t, sensed.has_value());
  service_.tell("WATCHDOG=1");  // only a row that came through every stage is a sign of life
  report_.say_mode(controller.control_mode(t), state_.storage_remedy());
  crash_loop_.row();
  return !stop_.raised();
}

template <Topology T>
int Daemon<T>::ended() {
  crash_loop_.end();
  // Else it would be read as running until it is old. Where another daemon has the folder, the status is its.
  if (!state_.taken_over()) write_status(plant_clock_ ? plant_clock_->woke() : system_clock_.now());
  return 0;
}

/// What is known when control begins.
template <Topology T>
void Daemon<T>::begin_control(CivilTime t) {
  crash_loop_.begin();
  controller_->tick(t);  // before it is known whether the clock has been set since the last row
  report_clock(t);
  if (crash_loop_.is_met()) controller_->hold(Reason::crash_loop, t, seconds_per_hour);
  if (state_.state_lost()) controller_->hold(Reason::state_lost, t, 0);
  first_row_ = t;
  note_met(t);
  write_status();  // what is there may say that the daemon has stopped
  // Where it goes on, before the first row too.
  beats_ = next_.seconds > 0 && controller_->cycle().mode_arbiter.beats(t);
}

template <Topology T>
bool Daemon<T>::report_clock(CivilTime t) {
  const bool is_set = clock_report_.is_set(t);
  controller_->report(Reason::clock_not_set, !is_set, t);
  return is_set;
}

/// Alarms of the bus: what a person must put right, while control goes on as far as it can.
template <Topology T>
void Daemon<T>::report_bus(CivilTime t) {
  controller_->report(Reason::map_refused, plant_.map_refused(), t);
  controller_->report(Reason::gateway_failed, plant_.gateway_failed(), t);
  const hal::Point* doubted = plant_.order_doubted();
  controller_->report(Reason::order_doubted, doubted != nullptr, t);
  report_.say_doubted(doubted);
}

/// The AHU takes over soon after this program is gone, hangs, or a person has asked for it: not first at a row.
/// On a new connection everything is read before anything is written, as at a row; and no attempt that fails here may
/// leave the link waiting when the row is due.
template <Topology T>
void Daemon<T>::beat_between_rows() {
  const double left_s = static_cast<double>(system_clock_.due_ns() - hal::monotonic_ns()) * 1e-9;
  // A wall clock that was set back makes one wait longer than a row, never than two cycles: no sign of a hang.
  if (left_s > row_s) service_.tell("WATCHDOG=1");
  // A whole map on a slow line takes seconds; the row is not to wait for them.
  if (left_s > 30 + link_.failure_costs_s() && readings_.wanted()) read_points(now(), plant_.in_touch());
  if (!beats_ || state_.release_waits() || left_s < link_.failure_costs_s()) return;
  plant_.keep_alive();
  if (plant_.beat() || plant_.in_touch()) return;
  (void)plant_.sense();
  (void)plant_.beat();
}

/// For whoever checks the points. A write is tried where the box is in control alone, and between what it may write.
template <Topology T>
void Daemon<T>::read_points(CivilTime now, bool answers) {
  if (readings_.take_write_wish()) {
    const ControllerSettings& s = controller_->settings();
    const bool may_write = beats_ && !state_.taken_over() && !state_.release_waits();
    const double step_k = std::min(0.5, s.limit_change_k);
    readings_.note(may_write ? plant_.check_write(step_k, s.limit_min_degc, s.limit_max_degc)
                             : hal::WriteCheck{.fault = Fault::released},
                   now);
  }
  readings_.read(link_, now, answers);
}

/// Until the plant answers once: a clock that was never read must not decide where to begin. False: a stop came first.
template <Topology T>
bool Daemon<T>::wait_for_plant() {
  constexpr std::int64_t every_ns = 60'000'000'000;  // people judge by its age whether the daemon runs
  bool said = false;
  std::int64_t written_ns = 0;
  while (!stop_.raised()) {
    const Expected<Reading<T>> sensed = plant_.sense();
    last_sensed_ = sensed;
    if (sensed) return true;
    service_.tell("WATCHDOG=1");  // a poll that came to its end; rows begin with the first answer
    if (!said && sensed.error() == Fault::other_device) {
      say("{} is not the device that the point map describes; nothing is written to it", link_.description());
    } else if (!said) {
      say("no answer from {}; trying again", link_.description());
    }
    if (!said || hal::monotonic_ns() - written_ns >= every_ns) {
      note_met(system_clock_.now());
      write_status();  // what is there may say that the daemon has stopped
      written_ns = hal::monotonic_ns();
    }
    said = true;
    hal::sleep_until_ns(hal::monotonic_ns() + 100'000'000, stop_);
  }
  return false;
}

/// What lasts beside the mode arbiter's reasons, and since when.
template <Topology T>
void Daemon<T>::note_met(CivilTime t) {
  Reason met = Reason::none;
  if (const Reason decided = controller_->control_mode(t).reason;
      decided == Reason::signal_lost || decided == Reason::forecast_invalid) {
    met = decided;
  }
  if (!last_sensed_) met = last_sensed_.error() == Fault::other_device ? Reason::map_differs : Reason::no_reading;
  if (met != met_) met_since_ = t;
  met_ = met;
}

/// Of the last row; `stopped_at` at an orderly end.
template <Topology T>
void Daemon<T>::write_status(CivilTime stopped_at) {
  if (last_row_.seconds == 0) last_row_ = next_.seconds != 0 ? next_ : system_clock_.now();  // before the first row
  StatusSnapshot s = row_status<T>(last_row_, last_sensed_, *controller_, plant_);
  s.site = site_.name;
  s.topology = site_.topology;
  if (s.decision.fault_signal >= 0) s.fault_signal = names_[static_cast<std::size_t>(s.decision.fault_signal)];
  s.generation = state_.generation();
  s.lost_until = state_.lost_until();
  s.release_ends = state_.release_ends();
  s.storage = state_.storage();
  s.storage_remedy = state_.storage_remedy();
  s.first_row = first_row_;
  s.met = met_;
  s.met_since = met_since_;
  if (state_.is_well() && !crash_loop_.is_kept()) s.storage = "starts cannot be written";
  if (state_.is_well() && !status_.is_well()) s.storage = "status cannot be written";
  s.trial = text_of(state_.trial().state);
  s.trial_refusal = text_of(state_.trial().refusal);
  s.trial_refusal_field = state_.trial().refusal_field.data();
  s.pushed_crc = state_.trial().blob_crc;
  s.clock = plant_clock_report_.text();
  s.stopped_at = stopped_at;
  if (!plant_clock_ && stopped_at.seconds == 0 && system_clock_.woke_ns() != 0) {
    s.row_late_ms = static_cast<double>(system_clock_.woke_ns() - system_clock_.due_ns()) * 1e-6;
    s.row_done_ms = static_cast<double>(hal::monotonic_ns() - system_clock_.due_ns()) * 1e-6;
  }
  (void)status_.write(last_row_, s);
}

#define AIRSIDE_INSTANTIATE(Tag) template class Daemon<Tag>;
AIRSIDE_FOR_EACH_TOPOLOGY(AIRSIDE_INSTANTIATE)
#undef AIRSIDE_INSTANTIATE

std::unique_ptr<AnyDaemon> make_daemon(const hal::SiteFile& site, const hal::PointMap& points,
                                       const DaemonOptions& options, hal::StopFlag stop) {
  std::unique_ptr<AnyDaemon> daemon;
  with_topology(site.topology.c_str(),
                [&]<class T>(T) { daemon = std::make_unique<Daemon<T>>(site, points, options, stop); });
  return daemon;
}

}  // namespace airside::edge
