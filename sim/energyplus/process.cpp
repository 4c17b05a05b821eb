#include "sim/energyplus/process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/words.hpp"

namespace airside::sim {
RunFolder::RunFolder() {
  std::error_code failed;
  const std::filesystem::path base = std::filesystem::temp_directory_path(failed);
  std::string pattern = (base / "airside-energyplus-XXXXXX").string();
  if (failed || mkdtemp(pattern.data()) == nullptr) {
    const char* named = std::getenv("TMPDIR");
    throw hal::InputError("TMPDIR", std::string(named != nullptr ? named : "/tmp") + ", where no folder can be made",
                          "a folder that can be written to, for the run's files", "name another in TMPDIR");
  }
  path_ = pattern;
  unfinished_.emplace(path_.string());
}

RunFolder::~RunFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

EnergyPlusProcess::EnergyPlusProcess(const RunConfig& config, std::string name)
    : config_(config), name_(std::move(name)) {
  const std::filesystem::path folder = config_.run_folder;
  const std::string program = find_energyplus_worker().string();
  const std::string run_file = (folder / "run.json").string();
  const std::string log_file = (folder / "worker.log").string();
  write_run_config(config_, run_file);

  // Close-on-exec at both ends: another run started meanwhile must not keep this one's socket open.
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    throw std::runtime_error("EnergyPlus: no socket for the worker: " + std::string(std::strerror(errno)));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log_file.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  posix_spawn_file_actions_adddup2(&actions, ends[1], worker_socket);
  std::string arguments[] = {program, run_file};
  char* argv[] = {arguments[0].data(), arguments[1].data(), nullptr};
  const int failed = posix_spawn(&pid_, program.c_str(), &actions, nullptr, argv, environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  socket_ = ends[0];
  if (failed != 0) {
    close(socket_);
    throw std::runtime_error(program + ": found that it does not start (" + std::strerror(failed) +
                             "); expected the worker program; build the target airside-energyplus");
  }
  unfinished_.emplace(pid_);
}

EnergyPlusProcess::~EnergyPlusProcess() {
  close(socket_);
  unfinished_.reset();
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
}

WorkerReply EnergyPlusProcess::exchange(const WorkerRequest& request) {
  if (send(socket_, &request, sizeof request, MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof request)) report_death();
  return receive();
}

WorkerReply EnergyPlusProcess::receive() {
  WorkerReply reply;
  ssize_t got = -1;
  do {
    got = recv(socket_, &reply, sizeof reply, 0);
  } while (got < 0 && errno == EINTR);
  if (got <= 0) report_death();
  if (got != static_cast<ssize_t>(sizeof reply) || reply.magic != protocol_magic) {
    throw std::runtime_error(
        "EnergyPlus: found an answer of another version of airside-energyplus; expected this build's; build again");
  }
  if (reply.kind == ReplyKind::error) {
    reply.text.back() = '\0';
    throw hal::InputError(
        "EnergyPlus run of " + name_, std::string(reply.text.data()), "a model and an engine that offer it",
        config_.own_control ? "correct [twin.names] in the site file"
                            : "compare the model's names with ModelNames, and the model with sim/models/twin.epJSON");
  }
  return reply;
}

void EnergyPlusProcess::report_death() {
  std::string how = "is gone";
  int status = 0;
  unfinished_.reset();
  if (pid_ > 0 && waitpid(pid_, &status, 0) == pid_) {
    how = ending_text(status);
    pid_ = -1;
  }
  const std::filesystem::path folder = config_.run_folder;
  throw std::runtime_error("EnergyPlus run of " + name_ + ": the engine's process " + how +
                           engine_words(folder / "eplusout.err", folder / "worker.log"));
}

}  // namespace airside::sim
