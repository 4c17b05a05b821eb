#include "firmware/edge/report/row_status.hpp"

#include <cmath>
#include <cstdint>

namespace airside::edge {

namespace {

/// What people ask of a site whose objective is "band".
template <Topology T>
void add_band(StatusSnapshot& s, const Expected<Reading<T>>& sensed, const Controller<T>& controller) {
  s.serves_band = controller.settings().objective == Objective::band;
  if (!s.serves_band) return;
  s.band_cycles = static_cast<std::uint64_t>(controller.cycle().band.learned());
  s.band_ready_cycles = static_cast<std::uint64_t>(controller.settings().demand.ready_cycles);
  if (!sensed) return;
  for (int i = 0; i < controller.settings().shape.vavs; ++i) {  // fmax passes over what is no number
    s.warmest_above_k = std::fmax(s.warmest_above_k, sensed->value[i] - sensed->zone_setpoint_degc(i));
    s.most_open_damper = std::fmax(s.most_open_damper, sensed->damper(i));
  }
}

/// Means of the rooms as they were read, so that they agree with the list of rooms; where one was not read, those of
/// the last decision, in which its last good value or the others' median stands in.
template <Topology T>
void add_rooms(StatusSnapshot& s, const Expected<Reading<T>>& sensed, const ControllerSettings& settings) {
  s.room_mean_degc = s.decision.room_mean_degc;
  s.held_degc = s.decision.held_degc;
  if (!sensed) return;
  s.room_temp_degc = {sensed->value.data(), static_cast<std::size_t>(settings.shape.vavs)};
  double sum = 0;
  for (const double room : s.room_temp_degc) sum += room;
  if (!std::isfinite(sum)) return;
  s.room_mean_degc = sum / settings.shape.vavs;
  s.held_degc = held_degc<T>(settings.held, settings.shape, sensed->value);
}

/// As Controller::control_mode(), but an AHU that was handed back is no longer released, though the next decision is
/// still to come.
template <Topology T>
ActiveMode mode_of_row(CivilTime t, const Controller<T>& controller) {
  const ActiveMode mode = controller.control_mode(t);
  const Reason since = controller.cycle().mode_arbiter.gravest(t);
  const bool handed_back = mode.mode == ControlMode::release && request_of(since).mode != ControlMode::release;
  return handed_back ? ActiveMode{request_of(since).mode, since} : mode;
}

}  // namespace

template <Topology T>
StatusSnapshot row_status(CivilTime t, const Expected<Reading<T>>& sensed, const Controller<T>& controller,
                          const hal::ModbusPlant<T>& plant) {
  StatusSnapshot s{
      .site = {}, .topology = {}, .control_mode = mode_of_row<T>(t, controller), .decision = controller.decision()};
  s.fault = sensed ? s.decision.fault : sensed.error();
  // To the controller whatever cannot be used is no number; people want to know why.
  const int signal = s.decision.fault_signal;
  if (s.fault == Fault::not_finite && signal >= 0 && plant.signal_fault(signal) != Fault::none) {
    s.fault = plant.signal_fault(signal);
  }
  s.setpoint_degc = controller.cycle().last_setpoint_degc;
  add_rooms<T>(s, sensed, controller.settings());
  s.target_degc = controller.settings().target_degc;
  s.hold = controller.settings().held.rule;
  s.cycles = controller.learning().cycles;
  s.rejected_updates = controller.learning().rejected;
  s.replay_transitions = static_cast<std::uint64_t>(controller.replay().size());
  s.has_weights = controller.cycle().has_weights != 0;
  const hal::LinkCounters& link = plant.link().counters();
  s.link_timeouts = link.timeouts;
  s.link_bad_frames = link.bad_frames;
  s.link_wrong_ids = link.wrong_ids;
  s.link_exceptions = link.exceptions;
  s.setpoint_writes = plant.setpoint_writes();
  s.mode_arbiter = &controller.cycle().mode_arbiter;
  s.ours_error_k = controller.cycle().shadow.ours_k();
  s.schedule_error_k = controller.cycle().shadow.schedule_k();
  s.candidates = &controller.candidates();
  add_band<T>(s, sensed, controller);
  return s;
}

#define AIRSIDE_INSTANTIATE(Tag) /* NOLINTNEXTLINE(bugprone-macro-parentheses): a type */                   \
  template StatusSnapshot row_status<Tag>(CivilTime, const Expected<Reading<Tag>>&, const Controller<Tag>&, \
                                          const hal::ModbusPlant<Tag>&);
AIRSIDE_FOR_EACH_TOPOLOGY(AIRSIDE_INSTANTIATE)
#undef AIRSIDE_INSTANTIATE

}  // namespace airside::edge
