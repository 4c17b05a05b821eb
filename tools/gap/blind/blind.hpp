#pragma once
// Rooms in which something is hidden on purpose: "measured" data with an answer that the workflow does not see.
// This file: what every measuring engine shares, and RC rooms. EnergyPlus: blind_energyplus.hpp.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/log/log_csv.hpp"
#include "sim/effects/effect.hpp"
#include "sim/plant_model.hpp"
#include "sim/rc/rc_room.hpp"
#include "sim/weather/weather.hpp"

namespace airside::tools::gap {

class TestCommands;

/// What is hidden.
struct Hidden {
  std::string effect;  ///< name of a file of sim/effects/library, or of something that the library does not have
  int place = 0;       ///< -1: outside the library, and at no place
  double magnitude = 0;
};

/// Names of what no file of sim/effects/library can express, one a kind:
///   fcu_dial              the dial of a fan coil's thermostat, K
///   odd_heater            a heater in one zone that switches by itself in the evening and at night, W
///   escape_door           a door of one zone to the outside stands open for some hours of some days, 1/h
///   ahu_time_switch       the AHU rests for some hours of every night, h from 1:30 on
///   hot_gas_bypass        the chiller takes power as at this share of full load where there is less load
const std::vector<std::string>& outside_kinds();

/// How the measured room is run.
struct MeasuredRun {
  CivilTime start;
  int days = 14;
  std::uint64_t seed = 1;    ///< of people, outages, noise
  bool feedback = true;      ///< the setpoint holds the rooms at target, boxes modulate; else a varied schedule
  double missing_share = 0;  ///< of values that never arrive
  /// Of what is commanded and of what never arrives; none: `seed`. Runs that share it share their commands, as far as
  /// no feedback makes them.
  std::optional<std::uint64_t> command_seed = std::nullopt;
  std::shared_ptr<const TestCommands> tests = nullptr;  ///< done in its last days; none: operated as ever
  int passive_days = 0;                                 ///< of its days, those before the tests; 0: all
  std::uint64_t commands() const { return command_seed.value_or(seed); }
};

/// Days that a measured room has lived before its log begins.
constexpr int measured_lead_days = 3;

/// The setpoint that is sent in a run: with feedback an integral controller on the mean of the shown room
/// temperatures, else a schedule that changes four times a day. Two decimals.
class MeasuredOperator {
 public:
  explicit MeasuredOperator(const MeasuredRun& run) : run_(run) {}
  /// At the start of a cycle.
  double setpoint_degc(CivilTime t, const std::vector<double>& shown_room_temp_degc);

 private:
  MeasuredRun run_;
  double integral_degc_ = 23;
};

/// What wrong sensors make of what right ones show. State: a lagging sensor remembers.
class WrongSensors {
 public:
  /// `changes`: their common operations on sensors count, all others are ignored.
  WrongSensors(std::vector<sim::EffectChange> changes, CivilTime log_start);
  /// Call at every row, in order.
  void apply(sim::Sensors& sensors, CivilTime t);

 private:
  std::vector<sim::EffectChange> changes_;
  CivilTime log_start_;
  std::vector<double> lagging_;  ///< one a change; NaN before the first row
};

/// A row of what is shown. Values that never arrive are missing.
hal::LogRow measured_row(const sim::Sensors& shown, CivilTime t, double setpoint_degc, const MeasuredRun& run);

/// The library's effect, nullptr for what lies outside.
const sim::Effect* find_effect(const std::vector<sim::Effect>& effects, const std::string& name);
/// "vav_flow@3", "odd_heater@3", "ahu_time_switch".
std::string id_of(const Hidden& hidden, const std::vector<sim::Effect>& effects);

/// The room with something hidden in it; what is at the logger and not in the room (a lag of a sensor) measure() adds.
/// Errors: std::invalid_argument for an effect that nobody can hide in an RC room.
sim::RcRoom hide(sim::RcRoom room, const std::vector<Hidden>& hidden, const std::vector<sim::Effect>& effects);

/// Whether hide() can: not what only the weather file could tell.
bool rc_can_hide(const sim::Effect& effect);

/// What that room logs.
std::vector<hal::LogRow> measure(const sim::RcRoom& room, std::shared_ptr<const sim::Weather> weather,
                                 const MeasuredRun& run, const std::vector<Hidden>& hidden = {});

}  // namespace airside::tools::gap
