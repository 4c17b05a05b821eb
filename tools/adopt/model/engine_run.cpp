#include "tools/adopt/model/engine_run.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "hal/text/input_error.hpp"
#include "hal/text/unfinished.hpp"
#include "sim/energyplus/words.hpp"

namespace airside::tools {

namespace {

/// The child's status of waitpid(); ended by force after the limit.
int status_of(pid_t child, int limit_s, bool& killed) {
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::seconds(limit_s);
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (!killed && Clock::now() > until) {
      kill(child, SIGKILL);
      killed = true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return status;
}

}  // namespace

EngineRun run_engine_program(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                             const std::filesystem::path& folder, int limit_s) {
  const std::string log = (folder / "engine.log").string();
  std::vector<std::string> words = {program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = -1;
  const int failed = posix_spawn(&child, words[0].c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) {
    throw hal::InputError(program.string(), std::string("a program that does not start: ") + std::strerror(failed),
                          "a program of the EnergyPlus engine", "run tools/setup again: the install is incomplete");
  }
  int status = 0;
  bool killed = false;
  {
    const hal::UnfinishedChild unfinished(child);
    status = status_of(child, limit_s, killed);
  }
  if (killed) return {false, "was ended after " + std::to_string(limit_s) + " s"};
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {true, {}};
  return {false, sim::ending_text(status) + sim::engine_words(folder / "eplusout.err", folder / "engine.log")};
}

}  // namespace airside::tools
