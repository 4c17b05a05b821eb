#include "tools/run/progress/staged_progress.hpp"

#include <cmath>

namespace airside::tools {

namespace {

constexpr std::uint64_t parts = 1000;

}  // namespace

double StagedProgress::now_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void StagedProgress::start(std::string task, std::vector<Stage> stages) {
  const std::scoped_lock lock(mutex_);
  if (out_ == nullptr) return;
  start_ = std::chrono::steady_clock::now();
  clock_ = std::make_unique<StageClock>(std::move(stages));
  bar_.reset();
  bar_ = std::make_unique<Progress>(std::move(task), parts, out_);
}

void StagedProgress::enter(std::size_t stage) {
  const std::scoped_lock lock(mutex_);
  if (!clock_) return;
  clock_->enter(stage, now_s());
  show();
}

void StagedProgress::expect(std::size_t number, Stage stage) {
  const std::scoped_lock lock(mutex_);
  if (clock_) clock_->expect(number, std::move(stage));
}

void StagedProgress::advance(double steps) {
  const std::scoped_lock lock(mutex_);
  if (!clock_) return;
  clock_->advance(steps, now_s());
  show();
}

void StagedProgress::finish() {
  const std::scoped_lock lock(mutex_);
  if (bar_) bar_->finish();
  bar_.reset();
  clock_.reset();
}

void StagedProgress::show() {
  if (!clock_->knows()) return;
  bar_->report(static_cast<std::uint64_t>(std::floor(clock_->share() * static_cast<double>(parts))), clock_->left_s(),
               clock_->name());
}

}  // namespace airside::tools
