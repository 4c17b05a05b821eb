#pragma once
// How often passwords may be tried: a few times from one place, and not without end from all together.

#include <array>
#include <cstdint>
#include <numeric>
#include <utility>

#include "firmware/page/auth/rights.hpp"

namespace airside::page {

/// By network prefix, in each by role: who knows one password gets no free tries at another. Places are forgotten when
/// their time is over or when newer ones need the table.
class Lockout {
 public:
  static constexpr int free_failures = 5;                            ///< from one prefix, before it has to wait
  static constexpr double first_wait_s = 30, longest_wait_s = 3600;  ///< doubled by each further failure
  static constexpr double forget_s = 4 * 3600;                       ///< without a failure
  static constexpr double failures_a_minute = 20;                    ///< of all prefixes; then everybody waits
  using Prefix = std::array<std::uint8_t, 16>;

  /// s until somebody from there may try; 0: now.
  double wait_s(const Prefix& from, std::int64_t now_ns) const;
  void failed(const Prefix& from, Role role, std::int64_t now_ns);
  /// Forgets the failures from there at that role's password alone.
  void succeeded(const Prefix& from, Role role);

 private:
  struct Place {
    Prefix prefix{};
    std::array<int, role_count> failures{};  ///< by role
    std::int64_t last_ns = 0, until_ns = 0;
    /// 0: the place is free.
    int all() const { return std::accumulate(failures.begin(), failures.end(), 0); }
  };
  const Place* find(const Prefix& from) const;
  Place* find(const Prefix& from) { return const_cast<Place*>(std::as_const(*this).find(from)); }

  std::array<Place, 64> places_{};
  double credit_ = failures_a_minute;  ///< of the failures of all
  std::int64_t credited_ns_ = 0;
};

}  // namespace airside::page
