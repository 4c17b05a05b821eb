#pragma once
// The one loop. Hardware and simulation, daemon and study run this same code; only plant, clock and sink differ.

#include <cstdint>
#include <tl/expected.hpp>

#include "airside/civil_time.hpp"
#include "airside/command.hpp"
#include "airside/fault.hpp"
#include "airside/plant.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/control_mode.hpp"

namespace airside {

/// First row instant at or after t.
constexpr CivilTime next_row(CivilTime t) {
  const std::int64_t rest = ((t.seconds % row_s) + row_s) % row_s;
  return {rest == 0 ? t.seconds : t.seconds + row_s - rest};
}

/// Runs rows from `from` until `until` (exclusive): every 6 min sense, each control cycle decide, actuate, learn.
/// `sink.row(t, sensed, controller)` logs the row and commits the state; it returns false to stop.
/// A row whose instant has passed while the program was away, or while it slept for that row because the machine was
/// suspended, is skipped, never made up for in a burst. A clock that was set back by more than clock_leap_s is
/// followed: waiting until it catches up would leave the room without control for that long. Returns the first instant
/// that was not run. Errors: none; a plant that cannot be read yields the schedule's command through the controller.
template <class Topology_, class Plant_, class Clock_, class Controller_, class Sink_>
requires Plant<Plant_, Topology_> && Clock<Clock_> CivilTime run_cycles(Plant_& plant, Clock_& clock,
                                                                        Controller_& controller, Sink_& sink,
                                                                        CivilTime from, CivilTime until) {
  CivilTime t = from;
  while (t < until) {
    if (!clock.sleep_until(t)) return t;
    if (const CivilTime woke = clock.woke(); woke.seconds - t.seconds >= row_s) {
      t = next_row(woke);
      continue;
    }
    const Expected<Reading<Topology_>> sensed = plant.sense();
    if (control_cycle(controller.settings()).starts(t)) {
      const auto decision = controller.decide(t, sensed);
      const Expected<Applied> applied = decision.mode == ControlMode::release
                                            ? Expected<Applied>(tl::unexpected(Fault::released))
                                            : plant.actuate(decision.command);
      controller.absorb(decision, applied);
    } else {
      controller.observe(t, sensed);
    }
    if (!sink.row(t, sensed, controller)) return {t.seconds + row_s};
    const CivilTime next{t.seconds + row_s};
    const CivilTime now = next_row(clock.now());
    t = now < next && next.seconds - now.seconds <= clock_leap_s ? next : now;
  }
  return t;
}

}  // namespace airside
