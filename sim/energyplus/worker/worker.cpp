#include "sim/energyplus/worker/worker.hpp"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <numeric>

namespace airside::sim {
namespace {

Worker* active = nullptr;  // the engine's callbacks carry no pointer of ours

void on_begin(EngineState) { active->begin_step(); }
void on_end(EngineState) { active->end_step(); }

/// The engine's own words go to the log at once: its file may not be flushed when it crashes.
void on_message(int severity, const char* message) {
  if (severity < 3) return;
  const std::string line = std::string(severity == 4 ? "** Fatal ** " : "** Severe ** ") + message + "\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, line.data(), line.size());
}

std::string placed(std::string pattern, int place) {
  const auto mark = pattern.find('#');
  if (mark != std::string::npos) pattern.replace(mark, 1, std::to_string(place));
  return pattern;
}

constexpr const char* zone_temp_variable = "Zone Mean Air Temperature";
constexpr const char* node_temp_variable = "System Node Temperature";
constexpr const char* outdoor_temp_variable = "Site Outdoor Air Drybulb Temperature";

}  // namespace

Worker::Worker(RunConfig config, EngineApi api, int socket)
    : config_(std::move(config)),
      api_(api),
      socket_(socket),
      vavs_(static_cast<int>(config_.names.interior_zones.size())),
      fcus_(static_cast<int>(config_.names.perimeter_zones.size())),
      loops_(config_.rooms, vavs_, fcus_, config_.seed, config_.setpoint_degc),
      now_{config_.start_s - lead_s},
      until_{config_.start_s},
      setpoint_degc_(config_.setpoint_degc),
      room_temps_(static_cast<std::size_t>(vavs_), 24.0),
      fcu_temps_(static_cast<std::size_t>(fcus_), 25.0) {}

int Worker::run() {
  active = this;
  state_ = api_.stateNew();
  api_.setConsoleOutputState(state_, 0);
  api_.setEnergyPlusRootDirectory(state_, config_.engine_folder.c_str());
  api_.registerErrorCallback(state_, on_message);
  api_.callbackBeginZoneTimestepBeforeSetCurrentWeather(state_, on_begin);
  api_.callbackEndOfZoneTimeStepAfterZoneReporting(state_, on_end);
  request_variables();
  const char* arguments[] = {"energyplus",         "-d", config_.run_folder.c_str(), "-w", config_.weather.c_str(),
                             config_.model.c_str()};
  return api_.energyplus(state_, 6, arguments);
}

void Worker::request_variables() {
  for (const auto& zone : config_.names.interior_zones) api_.requestVariable(state_, zone_temp_variable, zone.c_str());
  for (const auto& zone : config_.names.perimeter_zones) api_.requestVariable(state_, zone_temp_variable, zone.c_str());
  for (const auto& node : {config_.names.supply_air_node, config_.names.mau_outlet_node})
    api_.requestVariable(state_, node_temp_variable, node.c_str());
  api_.requestVariable(state_, outdoor_temp_variable, "Environment");
}

int Worker::variable(const std::string& name, const std::string& key) {
  const int handle = api_.getVariableHandle(state_, name.c_str(), key.c_str());
  if (handle < 0) fail("no output variable '" + name + "' of '" + key + "'");
  return handle;
}

int Worker::schedule(const std::string& name) {
  const int handle = api_.getActuatorHandle(state_, "Schedule:Constant", "Schedule Value", name.c_str());
  if (handle < 0) fail("no schedule to act on, 'Schedule:Constant' named '" + name + "'");
  return handle;
}

int Worker::meter(const std::string& name) {
  const int handle = api_.getMeterHandle(state_, name.c_str());
  if (handle < 0) fail("no meter '" + name + "'");
  return handle;
}

void Worker::find_handles() {
  const ModelNames& names = config_.names;
  for (const auto& zone : names.interior_zones) handles_.zone_temps.push_back(variable(zone_temp_variable, zone));
  for (const auto& zone : names.perimeter_zones) handles_.zone_temps.push_back(variable(zone_temp_variable, zone));
  handles_.supply_temp = variable(node_temp_variable, names.supply_air_node);
  handles_.mau_temp = variable(node_temp_variable, names.mau_outlet_node);
  handles_.outdoor_temp = variable(outdoor_temp_variable, "Environment");
  handles_.fan_energy = meter("Electricity:HVAC");
  handles_.plant_energy = meter("Electricity:Plant");
  handles_.supply_setpoint = schedule(names.supply_setpoint_schedule);
  for (int i = 1; i <= vavs_; ++i) {
    handles_.vav_on.push_back(schedule(placed(names.vav_on_schedule, i)));
    handles_.dampers.push_back(schedule(placed(names.vav_damper_schedule, i)));
    handles_.occupancy.push_back(schedule(placed(names.interior_occupancy_schedule, i)));
  }
  for (int i = 1; i <= fcus_; ++i) {
    handles_.fcu_on.push_back(schedule(placed(names.fcu_on_schedule, i)));
    handles_.occupancy.push_back(schedule(placed(names.perimeter_occupancy_schedule, i)));
  }
}

void Worker::begin_step() {
  if (!ready_) {
    if (api_.apiDataFullyReady(state_) != 1) return;
    find_handles();
    ready_ = true;
  }
  if (api_.kindOfSim(state_) != 3) return;
  if (api_.warmupFlag(state_) != 0) {
    const int second = api_.hour(state_) * 3600 + (api_.zoneTimeStepNum(state_) - 1) * config_.step_s;
    act(loops_.warm_up(CivilTime{config_.start_s - lead_s + second}, setpoint_degc_, fcu_temps_));
    return;
  }
  running_ = true;
  if (now_.seconds < config_.start_s) {
    act(loops_.warm_up(now_, setpoint_degc_, fcu_temps_));
    return;
  }
  if (!greeted_) {
    greeted_ = true;
    sense();
    send(sensed_);
  }
  if (now_.seconds >= config_.end_s) return;  // the engine calls once more after the last step
  if (now_ >= until_) serve();
  act(loops_.step(now_, config_.step_s, setpoint_degc_, fcu_temps_));
}

void Worker::end_step() {
  if (!ready_ || api_.kindOfSim(state_) != 3) return;
  read_truth();
  if (api_.warmupFlag(state_) != 0 || !running_ || now_.seconds >= config_.end_s) return;
  check_clock(now_);
  now_.seconds += config_.step_s;
  if (now_.seconds <= config_.start_s) return;
  if (branch_pipe_ >= 0) {
    if (now_ < until_) return;
    const double mean = mean_room_temp();
    const bool sent = write(branch_pipe_, &mean, sizeof mean) == static_cast<ssize_t>(sizeof mean);
    _exit(sent ? 0 : 1);
  }
  sense();
  if (now_ >= until_) send(sensed_);
}

void Worker::act(const RoomCommands& commands) {
  api_.setActuatorValue(state_, handles_.supply_setpoint, commands.supply_setpoint_degc);
  const auto each = [this](const std::vector<int>& handles, const std::vector<double>& values) {
    for (std::size_t i = 0; i < handles.size(); ++i) api_.setActuatorValue(state_, handles[i], values[i]);
  };
  each(handles_.vav_on, commands.vav_on);
  each(handles_.fcu_on, commands.fcu_on);
  each(handles_.dampers, config_.rooms.dampers);
  each(handles_.occupancy, commands.occupancy);
}

void Worker::read_truth() {
  const auto temp = [this](std::size_t i) { return api_.getVariableValue(state_, handles_.zone_temps[i]); };
  for (std::size_t i = 0; i < room_temps_.size(); ++i) room_temps_[i] = temp(i);
  for (std::size_t i = 0; i < fcu_temps_.size(); ++i) fcu_temps_[i] = temp(room_temps_.size() + i);
}

void Worker::sense() {
  const auto kw = [this](int meter) { return api_.getMeterValue(state_, meter) / config_.step_s / 1000.0; };
  const auto temp = [this](int handle) { return loops_.sensed_degc(api_.getVariableValue(state_, handle)); };
  sensed_.time_s = now_.seconds;
  sensed_.vavs = vavs_;
  sensed_.fcus = fcus_;
  for (std::size_t i = 0; i < room_temps_.size(); ++i) {
    sensed_.true_room_temp_degc[i] = room_temps_[i];
    sensed_.room_temp_degc[i] = loops_.sensed_degc(room_temps_[i]);
    sensed_.vav_on[i] = loops_.commands().vav_on[i];
  }
  for (std::size_t i = 0; i < fcu_temps_.size(); ++i) {
    sensed_.fcu_temp_degc[i] = loops_.sensed_degc(fcu_temps_[i]);
    sensed_.fcu_on[i] = loops_.commands().fcu_on[i];
  }
  sensed_.fan_kw = kw(handles_.fan_energy);
  sensed_.plant_kw = kw(handles_.plant_energy);
  sensed_.mau_temp_degc = temp(handles_.mau_temp);
  sensed_.outdoor_temp_degc = temp(handles_.outdoor_temp);
  sensed_.supply_temp_degc =
      loops_.sensed_degc(api_.getVariableValue(state_, handles_.supply_temp) - config_.rooms.supply_bias_k);
  sensed_.rain = api_.isRaining(state_) != 0 ? 1.0 : 0.0;
  sensed_.setpoint_degc = setpoint_degc_;
}

void Worker::serve() {
  for (;;) {
    WorkerRequest request;
    const ssize_t got = recv(socket_, &request, sizeof request, 0);
    if (got <= 0) leave();
    if (got != static_cast<ssize_t>(sizeof request) || request.magic != protocol_magic)
      fail("a request of another version of airside");
    if (request.until_s <= now_.seconds || request.until_s > config_.end_s)
      fail("a request for a time outside the run");
    if (request.kind == RequestKind::branch) {
      branch(request);
      if (branch_pipe_ < 0) continue;
    } else {
      until_.seconds = request.until_s;
      setpoint_degc_ = request.setpoint_degc;
    }
    return;
  }
}

void Worker::branch(const WorkerRequest& request) {
  int ends[2];
  if (pipe(ends) != 0) fail("no pipe for a branch: " + std::string(std::strerror(errno)));
  const pid_t child = fork();
  if (child < 0) fail("no process for a branch: " + std::string(std::strerror(errno)));
  if (child == 0) {
    close(ends[0]);
    close(socket_);
    branch_pipe_ = ends[1];
    until_.seconds = request.until_s;
    setpoint_degc_ = request.setpoint_degc;
    return;
  }
  close(ends[1]);
  WorkerReply reply;
  reply.kind = ReplyKind::branch;
  const bool came = read(ends[0], &reply.branch_mean_degc, sizeof(double)) == static_cast<ssize_t>(sizeof(double));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!came) fail("a branch of the simulation that died");
  reply.time_s = request.until_s;
  send(reply);
}

void Worker::check_clock(CivilTime step_start) const {
  const int second = api_.hour(state_) * 3600 + (api_.zoneTimeStepNum(state_) - 1) * config_.step_s;
  if (second != step_start.second_of_day())
    fail("the engine's clock at second " + std::to_string(second) + " of the day, ours at " +
         std::to_string(step_start.second_of_day()));
}

double Worker::mean_room_temp() const { return std::accumulate(room_temps_.begin(), room_temps_.end(), 0.0) / vavs_; }

void Worker::send(const WorkerReply& reply) const {
  if (::send(socket_, &reply, sizeof reply, MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof reply)) leave();
}

void Worker::fail(const std::string& text) const {
  WorkerReply reply;
  reply.kind = ReplyKind::error;
  std::copy_n(text.data(), std::min(text.size(), reply.text.size() - 1), reply.text.data());
  ::send(socket_, &reply, sizeof reply, MSG_NOSIGNAL);
  _exit(1);
}

void Worker::leave() const {
  std::error_code ignored;
  if (branch_pipe_ < 0) std::filesystem::remove_all(config_.run_folder, ignored);
  _exit(0);
}

}  // namespace airside::sim
