#pragma once
// How far a long task is, on the error stream: a bar with the time left on a terminal, a line every 10 % in a log.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>

namespace airside::tools {

/// One task of `total` steps. Safe to advance from several threads.
/// On a terminal the bar is redrawn in place, at most ten times a second; elsewhere whole lines are written.
class Progress {
 public:
  Progress(std::string task, std::uint64_t total, std::FILE* out = stderr);
  /// Ends the bar where it is when finish() was not reached, so that an error message starts on its own line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Counts `steps` more as done; beyond the total nothing happens.
  void advance(std::uint64_t steps = 1);
  /// Shows `done` of the total. Never goes back.
  void set(std::uint64_t done);
  /// The same, with the time left and the stage that runs as the caller knows them.
  void report(std::uint64_t done, double left_s, const std::string& stage);
  /// All done; prints the time it took. Further calls do nothing.
  void finish();

 private:
  void show(bool force);
  double elapsed_s() const;

  std::mutex mutex_;
  std::string task_;
  std::uint64_t total_;
  std::FILE* out_;
  bool terminal_;
  bool finished_ = false;
  std::uint64_t done_ = 0;
  std::optional<double> left_s_;
  std::string stage_;
  int last_tenth_ = 0;
  std::chrono::steady_clock::time_point start_, last_draw_;
};

/// "45 s", "3 min 20 s", "2 h 05 min".
std::string duration_text(double seconds);

}  // namespace airside::tools
