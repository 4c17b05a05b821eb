#pragma once
// A program under test as a process of its own: started, killed, waited for.

#include <csignal>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace airside::closed_loop {

/// Runs from construction on; killed at destruction if it still does.
class Child {
 public:
  /// `program` and arguments; output and complaints are appended to the file `says`.
  Child(const std::vector<std::string>& command, std::filesystem::path says);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void signal(int number) const;
  int pid() const { return pid_; }
  /// Exit code, 128 + signal where it died of one; nothing if it still runs after `timeout_s`.
  std::optional<int> wait(double timeout_s);
  bool running() { return !wait(0).has_value(); }
  /// Everything that it has said.
  std::string said() const;

 private:
  int pid_ = -1;
  std::optional<int> code_;
  std::filesystem::path says_;
};

/// s of the monotonic clock.
double now_s();
void sleep_s(double seconds);

}  // namespace airside::closed_loop
