#pragma once
// Progress of a task of several stages, with the time that all of them still take.

#include <chrono>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tools/run/progress/progress.hpp"
#include "tools/run/progress/stage_clock.hpp"

namespace airside::tools {

/// Nothing is shown before start(), nor ever without a stream. Safe to advance from several threads.
class StagedProgress {
 public:
  /// A null pointer: silent.
  explicit StagedProgress(std::FILE* out) : out_(out) {}

  /// Begins a task; one that ran is given up.
  void start(std::string task, std::vector<Stage> stages);
  void enter(std::size_t stage);
  /// A stage is known better now.
  void expect(std::size_t number, Stage stage);
  void advance(double steps = 1);
  /// All done; prints the time it took.
  void finish();

 private:
  void show();
  double now_s() const;

  std::mutex mutex_;
  std::FILE* out_;
  std::unique_ptr<StageClock> clock_;
  std::unique_ptr<Progress> bar_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace airside::tools
