#include "sim/energyplus/worker/worker.hpp"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

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

}  // namespace

Worker::Worker(RunConfig config, EngineApi api, int socket)
    : config_(std::move(config)),
      api_(api),
      socket_(socket),
      driver_(config_.own_control ? own_driver(config_) : external_driver(config_)),
      now_{config_.start_s - lead_s},
      until_{config_.start_s},
      setpoint_degc_(config_.setpoint_degc) {}

int Worker::run() {
  active = this;
  state_ = api_.stateNew();
  api_.setConsoleOutputState(state_, 0);
  api_.setEnergyPlusRootDirectory(state_, config_.engine_folder.c_str());
  api_.registerErrorCallback(state_, on_message);
  api_.callbackBeginZoneTimestepBeforeSetCurrentWeather(state_, on_begin);
  api_.callbackEndOfZoneTimeStepAfterZoneReporting(state_, on_end);
  engine_.emplace(api_, state_);
  driver_->request_variables(*engine_);
  const char* arguments[] = {"energyplus",         "-d", config_.run_folder.c_str(), "-w", config_.weather.c_str(),
                             config_.model.c_str()};
  return api_.energyplus(state_, 6, arguments);
}

void Worker::begin_step() {
  if (!ready_) {
    if (api_.apiDataFullyReady(state_) != 1) return;
    try {
      driver_->find_handles(*engine_);
    } catch (const NameError& error) {
      fail(error.what());  // no exception passes through the engine
    }
    ready_ = true;
  }
  if (api_.kindOfSim(state_) != 3) return;
  if (api_.warmupFlag(state_) != 0) {
    const int second = api_.hour(state_) * 3600 + (api_.zoneTimeStepNum(state_) - 1) * config_.step_s;
    driver_->warm_up(*engine_, CivilTime{config_.start_s - lead_s + second}, setpoint_degc_);
    return;
  }
  running_ = true;
  if (now_.seconds < config_.start_s) {
    driver_->warm_up(*engine_, now_, setpoint_degc_);
    return;
  }
  if (!greeted_) {
    greeted_ = true;
    sense();
    send(sensed_);
  }
  if (now_.seconds >= config_.end_s) return;  // the engine calls once more after the last step
  if (now_ >= until_) serve();
  driver_->step(*engine_, now_, setpoint_degc_);
}

void Worker::end_step() {
  if (!ready_ || api_.kindOfSim(state_) != 3) return;
  driver_->read_truth(*engine_);
  if (api_.warmupFlag(state_) != 0 || !running_ || now_.seconds >= config_.end_s) return;
  check_clock(now_);
  now_.seconds += config_.step_s;
  if (now_.seconds <= config_.start_s) return;
  if (branch_pipe_ >= 0) {
    if (now_ < until_) return;
    const double mean = driver_->mean_room_temp_degc();
    const bool sent = write(branch_pipe_, &mean, sizeof mean) == static_cast<ssize_t>(sizeof mean);
    _exit(sent ? 0 : 1);
  }
  sense();
  if (now_ >= until_) send(sensed_);
}

void Worker::sense() {
  sensed_.time_s = now_.seconds;
  driver_->sense(*engine_, sensed_);
  sensed_.rain = engine_->raining() ? 1.0 : 0.0;
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
