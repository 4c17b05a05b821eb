#include "tools/run/child_jobs.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <stdexcept>

#include "hal/text/unfinished.hpp"

namespace airside::tools {

namespace {

struct Child {
  pid_t pid;
  int pipe;
  std::size_t job;
  std::string text;
  hal::UnfinishedChild unfinished;
};

/// First character of a child's answer.
constexpr char succeeded = '+', failed = '-';

[[noreturn]] void answer(int pipe, const std::string& text) {
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = ::write(pipe, text.data() + sent, text.size() - sent);
    if (n <= 0) ::_exit(1);
    sent += static_cast<std::size_t>(n);
  }
  ::_exit(0);
}

Child start(std::size_t job, const std::function<std::string(std::size_t)>& work) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) throw std::runtime_error("no pipe for a child process");
  std::fflush(nullptr);
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) throw std::runtime_error("no child process could be started");
  if (pid == 0) {
    hal::forget_unfinished();
    // SIGKILL of the parent too ends its children, by a signal at which they still remove what is unfinished.
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(1);
    ::close(ends[0]);
    std::string text;
    try {
      text = succeeded + work(job);
    } catch (const std::exception& e) {
      text = failed + std::string(e.what());
    }
    answer(ends[1], text);
  }
  ::close(ends[1]);
  return {pid, ends[0], job, {}, hal::UnfinishedChild(pid)};
}

/// Reads what is there. True once the child has closed its end.
bool drain(Child& child) {
  std::array<char, 65536> buffer{};
  const ssize_t n = ::read(child.pipe, buffer.data(), buffer.size());
  if (n > 0) child.text.append(buffer.data(), static_cast<std::size_t>(n));
  return n == 0 || (n < 0 && errno != EINTR);
}

}  // namespace

std::vector<std::string> run_children(std::size_t count, int jobs, const std::function<std::string(std::size_t)>& work,
                                      const std::function<std::string(std::size_t)>& name,
                                      const std::function<void()>& done) {
  std::vector<std::string> texts(count);
  std::vector<Child> running;
  std::string first_failure;
  std::size_t next = 0;
  while ((next < count && first_failure.empty()) || !running.empty()) {
    while (next < count && first_failure.empty() && std::ssize(running) < jobs) running.push_back(start(next++, work));
    std::vector<pollfd> waiting;
    for (const Child& child : running) waiting.push_back({child.pipe, POLLIN, 0});
    if (::poll(waiting.data(), waiting.size(), -1) < 0) continue;
    for (std::size_t i = running.size(); i-- > 0;) {
      if (waiting[i].revents == 0 || !drain(running[i])) continue;
      Child child = std::move(running[i]);
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
      ::close(child.pipe);
      child.unfinished.release();
      int status = 0;
      while (::waitpid(child.pid, &status, 0) < 0 && errno == EINTR) {
      }
      // An answer that was cut off by the child's death begins like a whole one.
      const bool whole = WIFEXITED(status) && WEXITSTATUS(status) == 0 && !child.text.empty();
      const bool good = whole && child.text.front() == succeeded;
      if (good) {
        texts[child.job] = child.text.substr(1);
      } else if (first_failure.empty()) {
        first_failure = name(child.job) + ": " + (whole ? child.text.substr(1) : "its process died");
      }
      done();
    }
  }
  if (!first_failure.empty()) throw std::runtime_error(first_failure);
  return texts;
}

}  // namespace airside::tools
