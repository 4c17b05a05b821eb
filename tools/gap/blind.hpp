#pragma once
// Rooms in which something is hidden on purpose: "measured" data with an answer that the workflow does not see.

#include <cstdint>
#include <string>
#include <vector>

#include "hal/log_csv.hpp"
#include "sim/effect.hpp"
#include "sim/rc_room.hpp"
#include "sim/weather.hpp"

namespace airside::tools::gap {

/// What is hidden.
struct Hidden {
  std::string effect;  ///< name of a file of sim/effects, or of something that the library does not have
  int place = 0;
  double magnitude = 0;
};

/// How the measured room is run.
struct MeasuredRun {
  CivilTime start;
  int days = 14;
  std::uint64_t seed = 1;    ///< of people, outages, noise
  bool feedback = true;      ///< the setpoint holds the rooms at target, boxes modulate; else a varied schedule
  double missing_share = 0;  ///< of values that never arrive
};

/// The room that stands for the real one: perturbed, and of another structure than the workflow's.
sim::RcRoom measured_room(const sim::RcRoom& twin, std::uint64_t seed, bool feedback);

/// The room with something hidden in it. `lag_s` of sensors and drop-outs are put on the log afterwards.
/// Errors: std::invalid_argument for an effect that nobody can hide in an RC room.
sim::RcRoom hide(sim::RcRoom room, const std::vector<Hidden>& hidden, const std::vector<sim::Effect>& effects);

/// What that room logs.
std::vector<hal::LogRow> measure(const sim::RcRoom& room, std::shared_ptr<const sim::Weather> weather,
                                 const MeasuredRun& run, const std::vector<Hidden>& hidden = {});

}  // namespace airside::tools::gap
