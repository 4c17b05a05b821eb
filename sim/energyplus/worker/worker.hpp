#pragma once
// One EnergyPlus run, driven over a socket: the engine's callbacks wait for requests, step the room loops, act on
// the model's schedules and answer with what the sensors show.

#include <cstdint>
#include <string>
#include <vector>

#include "sim/energyplus/protocol.hpp"
#include "sim/energyplus/rooms.hpp"
#include "sim/energyplus/run_config.hpp"
#include "sim/energyplus/worker/engine_api.hpp"

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
  struct Handles {
    std::vector<int> zone_temps, vav_on, dampers, fcu_on, occupancy;
    int supply_setpoint = -1, supply_temp = -1, mau_temp = -1, outdoor_temp = -1;
    int fan_energy = -1, plant_energy = -1;
  };

  void request_variables();
  void find_handles();
  int variable(const std::string& name, const std::string& key);
  int schedule(const std::string& name);
  int meter(const std::string& name);
  void act(const RoomCommands& commands);
  void read_truth();
  void sense();
  void serve();
  void branch(const WorkerRequest& request);
  void check_clock(CivilTime step_start) const;
  double mean_room_temp() const;
  void send(const WorkerReply& reply) const;
  [[noreturn]] void fail(const std::string& text) const;
  [[noreturn]] void leave() const;

  RunConfig config_;
  EngineApi api_;
  int socket_;
  EngineState state_ = nullptr;
  int vavs_, fcus_;
  RoomLoops loops_;
  Handles handles_;
  bool ready_ = false, running_ = false, greeted_ = false;
  CivilTime now_, until_;
  double setpoint_degc_;
  std::vector<double> room_temps_, fcu_temps_;
  WorkerReply sensed_;
  int branch_pipe_ = -1;
};

}  // namespace airside::sim
