#pragma once
// One EnergyPlus run, driven over a socket: the engine's callbacks wait for requests, let the driver act on
// the model's schedules, and answer with what the sensors show.

#include <memory>
#include <optional>
#include <string>

#include "sim/energyplus/protocol.hpp"
#include "sim/energyplus/run_config.hpp"
#include "sim/energyplus/worker/engine_api.hpp"
#include "sim/energyplus/worker/engine_names.hpp"
#include "sim/energyplus/worker/model_driver.hpp"

namespace airside::sim {

class Worker {
 public:
  Worker(RunConfig config, EngineApi api, int socket);

  /// Runs the engine from warm-up to the end of the run period.
  /// Errors: the engine's exit code; a name that the model has not is answered over the socket, then the process
  /// ends. A closed socket (the parent is gone) ends the process.
  int run();

  void begin_step();  ///< callback: before the weather of a zone step is set
  void end_step();    ///< callback: after a zone step has been reported

 private:
  void sense();
  void serve();
  void branch(const WorkerRequest& request);
  void check_clock(CivilTime step_start) const;
  void send(const WorkerReply& reply) const;
  [[noreturn]] void fail(const std::string& text) const;
  [[noreturn]] void leave() const;

  RunConfig config_;
  EngineApi api_;
  int socket_;
  EngineState state_ = nullptr;
  std::unique_ptr<ModelDriver> driver_;
  std::optional<EngineNames> engine_;  ///< once the engine has a state
  bool ready_ = false, running_ = false, greeted_ = false;
  CivilTime now_, until_;
  double setpoint_degc_;
  WorkerReply sensed_;
  int branch_pipe_ = -1;
};

}  // namespace airside::sim
