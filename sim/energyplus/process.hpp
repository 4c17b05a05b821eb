#pragma once
// The child process that holds one EnergyPlus run, and its folder under TMPDIR. The child ends with its owner; a
// child that dies is reported in the engine's own words.

#include <filesystem>
#include <optional>
#include <string>

#include "hal/text/unfinished.hpp"
#include "sim/energyplus/protocol.hpp"
#include "sim/energyplus/run_config.hpp"

namespace airside::sim {

/// A new empty folder under TMPDIR, removed with its owner, and where a signal ends the program.
class RunFolder {
 public:
  /// Errors: hal::InputError when TMPDIR cannot be written to.
  RunFolder();
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::optional<hal::UnfinishedPath> unfinished_;
};

class EnergyPlusProcess {
 public:
  /// Starts the worker on a run whose model and weather are in place; `name` is for messages.
  /// Errors: std::runtime_error when the process cannot be started.
  EnergyPlusProcess(const RunConfig& config, std::string name);
  ~EnergyPlusProcess();
  EnergyPlusProcess(const EnergyPlusProcess&) = delete;
  EnergyPlusProcess& operator=(const EnergyPlusProcess&) = delete;

  /// The next message of the worker.
  /// Errors: std::runtime_error with the engine's Severe and Fatal lines when the worker has died;
  /// hal::InputError when it refused the model.
  WorkerReply receive();
  /// Sends a request and waits for its answer. Errors: as receive().
  WorkerReply exchange(const WorkerRequest& request);

  int pid() const { return pid_; }

 private:
  [[noreturn]] void report_death();

  RunConfig config_;
  std::string name_;
  int socket_ = -1;
  int pid_ = -1;
  std::optional<hal::UnfinishedChild> unfinished_;
};

}  // namespace airside::sim
