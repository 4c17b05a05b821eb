#pragma once
// Who has signed in: in memory alone, so that a restart of the page signs everybody out.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "firmware/page/auth/rights.hpp"

namespace airside::page {

struct Session {
  Role role = Role::none;  ///< none: a free place
  std::string cookie;      ///< 64 hex digits
  std::string token;       ///< 32 hex digits, which every change has to bring beside the cookie
  std::int64_t begun_ns = 0, used_ns = 0;
};

class Sessions {
 public:
  static constexpr std::size_t max_sessions = 16;
  static constexpr double idle_s = 1800, longest_s = 12 * 3600;

  /// A new one. Of the lowest role that is signed in, the one that has been idle longest makes room.
  const Session& begin(Role role, std::int64_t now_ns);
  /// The session of a cookie, which is used by that; null where there is none. Its time does not tell which differs.
  const Session* find(std::string_view cookie, std::int64_t now_ns);
  void end(std::string_view cookie);
  void end_all();

 private:
  std::array<Session, max_sessions> sessions_;
};

/// Random hex digits. Errors: std::runtime_error without a source of random numbers.
std::string random_hex(std::size_t bytes);

}  // namespace airside::page
