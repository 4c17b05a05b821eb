#pragma once
// How long a task of several unlike stages still takes, from what its first steps took.

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace airside::tools {

/// A part of a task: its number of steps, each of `weight` times the time of a step of weight 1.
struct Stage {
  std::string name;
  double steps = 0;
  double weight = 1;
  bool even = true;  ///< steps take the same time; if not, the stage is judged by its plan alone
};

/// Seconds of one unit of weight are measured over all steps so far; the stage that runs is judged the more by its own
/// steps the more of them are done. With w the weight, n the steps planned, k those done, t the seconds of the stage:
///   step = (t + p u w) / (k + p),  p = n / 10,  u = seconds so far / weight so far
///   left = (n - k) step, of an uneven stage n w u - t, and n w u of each later stage
/// What is shown may change by a factor of 2 in a twentieth of the time so far, and no faster.
/// Units: s, since the start.  Not thread-safe.
class StageClock {
 public:
  explicit StageClock(std::vector<Stage> stages) : stages_(std::move(stages)), done_(stages_.size(), 0.0) {}

  /// A stage is known better now.
  void expect(std::size_t number, Stage stage) { stages_.at(number) = std::move(stage); }
  /// The stages before are over, whatever they were planned to be.
  void enter(std::size_t stage, double now_s);
  /// Steps of the stage that runs.
  void advance(double steps, double now_s);

  /// 0 before the first step.
  double left_s() const { return left_s_; }
  /// Of the time that all will have taken.
  double share() const { return now_s_ + left_s_ > 0 ? now_s_ / (now_s_ + left_s_) : 0; }
  bool knows() const { return weight_so_far_ > 0; }
  const std::string& name() const { return stages_.at(at_).name; }

 private:
  double unsmoothed_left_s() const;

  std::vector<Stage> stages_;
  std::vector<double> done_;
  std::size_t at_ = 0;
  double entered_s_ = 0, now_s_ = 0, weight_so_far_ = 0, left_s_ = 0;
};

}  // namespace airside::tools
