#include "firmware/page/http/audit_log.hpp"

#include <cstdio>

#include "hal/modbus/wire.hpp"

namespace airside::page {

void AuditLog::say(const std::string& text) const {
  std::string line = "airside-page: " + text;
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';  // no peer writes lines of its own
  }
  line += '\n';
  std::fwrite(line.data(), 1, line.size(), stderr);
}

void AuditLog::refusal(const std::string& text) {
  const std::int64_t minute = hal::monotonic_ns() / 60'000'000'000;
  if (minute != minute_) {
    if (unsaid_ > 0) say(std::to_string(unsaid_) + " more refusals that are not listed");
    minute_ = minute;
    said_ = unsaid_ = 0;
  }
  if (said_ == refusals_a_minute) {
    ++unsaid_;
    return;
  }
  ++said_;
  say(text);
}

}  // namespace airside::page
