#include "firmware/edge/crash_loop.hpp"

#include "airside/civil_time.hpp"
#include "firmware/edge/report/say.hpp"
#include "hal/modbus/wire.hpp"

namespace airside::edge {

void CrashLoop::start() {
  if (limit_ > 0) recent_starts_ = starts_.record(window_s);
  if (!is_kept()) say("starts in {} cannot be written; a crash loop would not be seen", state_dir_);
}

bool CrashLoop::is_met() const {
  if (limit_ <= 0 || recent_starts_ < limit_) return false;
  say("{} starts within ten minutes; the schedule runs for an hour", recent_starts_);
  return true;
}

void CrashLoop::begin() { began_ns_ = hal::monotonic_ns(); }

void CrashLoop::row() {
  if (limit_ <= 0) return;
  if (recent_starts_ > 0 && hal::monotonic_ns() - began_ns_ >= seconds_per_hour * 1'000'000'000) {
    starts_.clear();
    recent_starts_ = 0;
  }
  if (!is_kept()) starts_.keep();
}

void CrashLoop::end() {
  if (limit_ > 0) starts_.clear();
}

}  // namespace airside::edge
