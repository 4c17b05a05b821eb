#include "support/child.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <ctime>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace airside::closed_loop {

Child::Child(const std::vector<std::string>& command, std::filesystem::path says) : says_(std::move(says)) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("fork");
  if (pid_ > 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that dies leaves nothing behind
  const int out = ::open(says_.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  ::dup2(out, 1);
  ::dup2(out, 2);
  ::execv(arguments.front(), arguments.data());
  ::_exit(127);
}

Child::~Child() {
  if (!running()) return;
  signal(SIGKILL);
  (void)wait(10);
}

void Child::signal(int number) const {
  if (!code_) ::kill(pid_, number);
}

std::optional<int> Child::wait(double timeout_s) {
  const double deadline_s = now_s() + timeout_s;
  while (!code_) {
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) == pid_) {
      code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      break;
    }
    if (now_s() >= deadline_s) return std::nullopt;
    sleep_s(0.001);
  }
  return code_;
}

std::string Child::said() const {
  std::ifstream in(says_);
  return {std::istreambuf_iterator<char>(in), {}};
}

double now_s() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void sleep_s(double seconds) {
  const auto whole = static_cast<std::time_t>(seconds);
  const timespec t{whole, static_cast<long>((seconds - static_cast<double>(whole)) * 1e9)};
  nanosleep(&t, nullptr);
}

}  // namespace airside::closed_loop
