#pragma once
// What is acted on and read in a model, step by step: of the project's own twin, or of a model that somebody else
// wrote.

#include <memory>

#include "airside/civil_time.hpp"
#include "sim/energyplus/protocol.hpp"
#include "sim/energyplus/run_config.hpp"
#include "sim/energyplus/worker/engine_names.hpp"

namespace airside::sim {

class ModelDriver {
 public:
  virtual ~ModelDriver() = default;

  /// Before the engine runs.
  virtual void request_variables(const EngineNames& engine) = 0;
  /// Errors: NameError.
  virtual void find_handles(const EngineNames& engine) = 0;
  /// Acts for a step of warm-up that begins at t; changes no state.
  virtual void warm_up(const EngineNames& engine, CivilTime t, double setpoint_degc) = 0;
  /// Acts for the step that begins at t.
  virtual void step(const EngineNames& engine, CivilTime t, double setpoint_degc) = 0;
  /// Takes the true temperatures at a step's end.
  virtual void read_truth(const EngineNames& engine) = 0;
  /// What the sensors show; draws their noise.
  virtual void sense(const EngineNames& engine, WorkerReply& shown) = 0;
  virtual double mean_room_temp_degc() const = 0;
};

/// Loops beside the engine command dampers, fan coils and people.
std::unique_ptr<ModelDriver> external_driver(const RunConfig& config);
/// The model's own thermostats and terminals run.
std::unique_ptr<ModelDriver> own_driver(const RunConfig& config);

}  // namespace airside::sim
