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

}  // namespace

template <Topology T>
StatusSnapshot row_status(CivilTime t, const Expected<Reading<T>>& sensed, const Controller<T>& controller,
                          const hal::ModbusPlant<T>& plant) {
  StatusSnapshot s{
      .site = {}, .topology = {}, .control_mode = controller.control_mode(t), .decision = controller.decision()};
  s.fault = sensed ? s.decision.fault : sensed.error();
  // To the controller whatever cannot be used is no number; people want to know why.
  const int signal = s.decision.fault_signal;
  if (s.fault == Fault::not_finite && signal >= 0 && plant.signal_fault(signal) != Fault::none) {
    s.fault = plant.signal_fault(signal);
  }
  s.setpoint_degc = controller.cycle().last_setpoint_degc;
  if (sensed) s.room_temp_degc = {sensed->value.data(), static_cast<std::size_t>(controller.settings().shape.vavs)};
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
