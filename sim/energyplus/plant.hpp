#pragma once
// The EnergyPlus twin as a plant: one engine in one child process a run, so that runs side by side stay
// bit-identical to runs alone.

#include <memory>
#include <vector>

#include "sim/energyplus/options.hpp"
#include "sim/plant_model.hpp"

namespace airside::sim {

class EnergyPlusProcess;
class RunFolder;
struct WorkerReply;

class EnergyPlusPlant final : public PlantModel {
 public:
  /// Composes and checks the model, starts the engine and runs its warm-up; time() is then midnight of the start
  /// day.  Cost: about 1.5 s.
  /// Errors: hal::InputError for an absent engine, options, files, a model that lacks a name;
  /// std::runtime_error with the engine's own words when it gives up.
  explicit EnergyPlusPlant(const EnergyPlusOptions& options);
  ~EnergyPlusPlant() override;

  CivilTime time() const override { return time_; }
  int step_s() const override { return options_.step_min * 60; }
  /// Errors also: hal::InputError for a time before time(), off the time step, or after end().
  void advance_to(CivilTime t) override;
  void set_setpoint(double setpoint_degc) override;
  const Sensors& sensors() const override { return sensors_; }
  std::string description() const override;

  /// Midnight after the last simulated day.
  CivilTime end() const { return end_; }
  /// Room temperatures without sensor noise or rounding. degC.
  const std::vector<double>& true_room_temps_degc() const { return true_room_temps_degc_; }
  double true_mean_room_temp_degc() const;

  /// The true mean room temperature at `until` if the setpoint were held from now on: simulated in a forked copy
  /// of the engine, with the same people and weather to come. This run does not notice.
  /// Units: degC.  Cost: about 4 ms and the steps.  Errors: as advance_to().
  double branch_mean_room_temp_degc(double setpoint_degc, CivilTime until);

  /// The worker's process, for tests that end it.
  int worker_pid() const;

 private:
  void check_time(CivilTime t) const;
  void take(const WorkerReply& reply);

  EnergyPlusOptions options_;
  CivilTime time_, end_;
  double setpoint_degc_;
  Sensors sensors_;
  std::vector<double> true_room_temps_degc_;
  std::unique_ptr<RunFolder> folder_;
  std::unique_ptr<EnergyPlusProcess> process_;
};

/// The setpoint within [low, high] that brings the true mean room temperature to the target `ahead_s`, a control cycle,
/// from now: what a controller with perfect foresight would choose, the floor of every comparison. Secant steps on
/// branches, to 0.001 K, at most 7.  Units: degC.  Cost: about 30 ms.
double full_forecast_setpoint(EnergyPlusPlant& plant, double target_degc, double low_degc, double high_degc,
                              int ahead_s = default_cycle.seconds());

}  // namespace airside::sim
