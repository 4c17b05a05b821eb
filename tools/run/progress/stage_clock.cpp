#include "tools/run/progress/stage_clock.hpp"

#include <algorithm>
#include <cmath>

namespace airside::tools {

void StageClock::enter(std::size_t stage, double now_s) {
  at_ = std::min(stage, stages_.size() - 1);
  entered_s_ = now_s;
  advance(0, now_s);
}

void StageClock::advance(double steps, double now_s) {
  const bool first = weight_so_far_ == 0;
  const double passed = std::max(0.0, now_s - now_s_);
  now_s_ = std::max(now_s_, now_s);
  done_[at_] += steps;
  weight_so_far_ += steps * stages_[at_].weight;
  if (!knows()) return;
  const double left = unsmoothed_left_s();
  if (first) {
    left_s_ = left;
    return;
  }
  const double before = std::max(left_s_ - passed, 0.01 * now_s_);
  const double factor = std::exp2(passed / std::max(0.5, 0.05 * now_s_));
  left_s_ = std::clamp(left, before / factor, before * factor);
}

double StageClock::unsmoothed_left_s() const {
  const double unit_s = now_s_ / weight_so_far_;
  const Stage& now = stages_[at_];
  const double done = done_[at_], prior = 0.1 * now.steps;
  const double step_s =
      done + prior > 0 ? (now_s_ - entered_s_ + prior * unit_s * now.weight) / (done + prior) : unit_s * now.weight;
  // A stage that outruns its plan goes on for a while.
  const double planned_s = now.steps * now.weight * unit_s, passed_s = now_s_ - entered_s_;
  double left = now.even ? std::max(now.steps - done, done > 0 ? 0.1 * (done - now.steps) : 0.0) * step_s
                         : std::max(planned_s - passed_s, 0.05 * passed_s);
  for (std::size_t i = at_ + 1; i < stages_.size(); ++i) left += stages_[i].steps * stages_[i].weight * unit_s;
  return left;
}

}  // namespace airside::tools
