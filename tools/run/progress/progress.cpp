#include "tools/run/progress/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace airside::tools {
namespace {

constexpr int default_columns = 80;
constexpr int narrowest_bar = 8, widest_bar = 40;
constexpr auto redraw_interval = std::chrono::milliseconds(100);

int columns_of(std::FILE* out) {
  winsize size{};
  if (ioctl(fileno(out), TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return default_columns;
  return size.ws_col;
}

}  // namespace

std::string duration_text(double seconds) {
  const auto s = static_cast<long long>(std::llround(std::max(0.0, seconds)));
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s % 3600 / 60);
}

Progress::Progress(std::string task, std::uint64_t total, std::FILE* out)
    : task_(std::move(task)),
      total_(std::max<std::uint64_t>(total, 1)),
      out_(out),
      terminal_(isatty(fileno(out)) == 1),
      start_(std::chrono::steady_clock::now()),
      last_draw_(start_ - redraw_interval) {
  show(true);
}

Progress::~Progress() {
  if (!finished_ && terminal_) {
    std::fputc('\n', out_);
    std::fflush(out_);
  }
}

double Progress::elapsed_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::advance(std::uint64_t steps) {
  const std::scoped_lock lock(mutex_);
  if (finished_) return;
  done_ = std::min(total_, done_ + std::min(steps, total_));
  show(false);
}

void Progress::set(std::uint64_t done) {
  const std::scoped_lock lock(mutex_);
  if (finished_ || done <= done_) return;
  done_ = std::min(total_, done);
  show(false);
}

void Progress::report(std::uint64_t done, double left_s, const std::string& stage) {
  const std::scoped_lock lock(mutex_);
  if (finished_) return;
  done_ = std::clamp(done, done_, total_);
  left_s_ = left_s;
  stage_ = stage;
  show(false);
}

void Progress::finish() {
  const std::scoped_lock lock(mutex_);
  if (finished_) return;
  done_ = total_;
  finished_ = true;
  const std::string took = duration_text(elapsed_s());
  fmt::print(out_, "{}{}: done in {}{}\n", terminal_ ? "\r" : "", task_, took, terminal_ ? "\x1b[K" : "");
  std::fflush(out_);
}

void Progress::show(bool force) {
  const double share = static_cast<double>(done_) / static_cast<double>(total_);
  const double elapsed = elapsed_s();
  // The first moments say nothing about the rest.
  std::string left;
  if (share > 0 && elapsed > 0.5)
    left = fmt::format("{} left", duration_text(left_s_ ? *left_s_ : elapsed * (1 - share) / share));
  if (!stage_.empty()) left += (left.empty() ? "(" : " (") + stage_ + ")";
  if (!terminal_) {
    const int tenth = static_cast<int>(share * 10 + 1e-9);
    if (force) {
      fmt::print(out_, "{}: started\n", task_);
    } else if (tenth > last_tenth_ && done_ < total_) {
      fmt::print(out_, "{}: {} %{}\n", task_, tenth * 10, left.empty() ? "" : ", " + left);
    }
    last_tenth_ = tenth;
    std::fflush(out_);
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (!force && now - last_draw_ < redraw_interval && done_ < total_) return;
  last_draw_ = now;
  const std::string tail = fmt::format(" {:3} %  {}", static_cast<int>(share * 100), left);
  const int space = columns_of(out_) - static_cast<int>(task_.size() + tail.size()) - 4;
  std::string bar;
  if (space >= narrowest_bar) {
    const int bar_width = std::min(space, widest_bar);
    const int full = static_cast<int>(std::lround(share * bar_width));
    bar = " [" + std::string(static_cast<std::size_t>(full), '#') +
          std::string(static_cast<std::size_t>(bar_width - full), '-') + "]";
  }
  fmt::print(out_, "\r{}{}{}\x1b[K", task_, bar, tail);
  std::fflush(out_);
}

}  // namespace airside::tools
