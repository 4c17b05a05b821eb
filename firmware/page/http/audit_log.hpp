#pragma once
// What airside-page says: one line for each upload, to standard error, where the service manager adds the time. A peer
// that is refused a thousand times a second does not fill the journal.

#include <cstdint>
#include <string>

namespace airside::page {

class AuditLog {
 public:
  static constexpr int refusals_a_minute = 30;

  /// Always said.
  void say(const std::string& text) const;
  /// Said up to refusals_a_minute times a minute; the rest is counted, and the number said a minute later.
  void refusal(const std::string& text);

 private:
  std::int64_t minute_ = -1;
  int said_ = 0, unsaid_ = 0;
};

}  // namespace airside::page
