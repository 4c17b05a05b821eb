#pragma once
// The mode arbiter: the highest control mode that any active reason asks for wins. Every reason says why it is there
// and how it ends (mode_table.hpp).

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "airside/civil_time.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/supervision/mode_table.hpp"

namespace airside {

/// Which reasons are active and until when. Plain bytes: part of the durable state.
class ModeArbiter {
 public:
  /// Keeps `reason` from t for `seconds`, or for ever where only a person ends it. Called again it begins anew.
  constexpr void hold(Reason reason, CivilTime t, std::int64_t seconds) {
    if (reason == Reason::none) return;
    if (!active(reason, t)) since(reason) = t.seconds;
    until(reason) = request_of(reason).for_person ? for_ever : t.seconds + seconds;
  }
  /// Active until the next set(reason, false).
  constexpr void set(Reason reason, bool is_so, CivilTime t) {
    if (reason == Reason::none) return;
    if (!is_so) {
      until(reason) = 0;
    } else {
      if (!active(reason, t)) since(reason) = t.seconds;
      until(reason) = for_ever;
    }
  }
  /// A person gives the AHU back: everything that waits for one ends, and every override.
  constexpr void hand_back() {
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      if (r == Reason::map_differs) continue;  // no operator can make it the right device
      if (request_of(r).for_person || request_of(r).mode == ControlMode::release) until(r) = 0;
    }
  }
  /// Ends everything that does not keep the AHU released. What is known of the clock stays: limits are moved by it.
  constexpr void keep_only_releases() {
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      if (request_of(r).mode != ControlMode::release && r != Reason::clock_not_set) until(r) = 0;
    }
  }
  /// Follows the clock to t. What keeps the AHU released on another mode arbiter, which has followed it there, keeps it
  /// on this one at least as long, and so does a crash loop; and what the other knows of the clock holds here.
  constexpr void join_releases(const ModeArbiter& other, CivilTime t) {
    tick(t);
    set(Reason::clock_not_set, other.active(Reason::clock_not_set, t), t);
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      const auto at = static_cast<std::size_t>(i);
      if (request_of(r).mode != ControlMode::release && r != Reason::crash_loop) continue;
      if (!other.active(r, t) || other.until_s_[at] <= until(r)) continue;
      since(r) = other.since_s_[at];
      until(r) = other.until_s_[at];
    }
  }
  /// Follows the clock: where it is set back, what began later is moved with it, so that no time limit grows; and
  /// where one that was never set is set at last, so that none shrinks.
  constexpr void tick(CivilTime t) {
    const bool set_back = t.seconds < last_s_ - clock_leap_s;
    const bool set_at_last = t.seconds > last_s_ + clock_leap_s && active(Reason::clock_not_set, t);
    if (last_s_ != never && (set_back || set_at_last)) {
      const std::int64_t moved_s = t.seconds - last_s_;
      for (int i = 1; i < reason_count; ++i) {
        const auto r = static_cast<Reason>(i);
        if (until(r) == 0) continue;
        since(r) += moved_s;
        if (until(r) != for_ever) until(r) += moved_s;
      }
    }
    last_s_ = t.seconds;
  }

  constexpr bool active(Reason reason, CivilTime t) const {
    return until_s_[static_cast<std::size_t>(reason)] > t.seconds;
  }
  constexpr std::int64_t since_s(Reason reason) const { return since_s_[static_cast<std::size_t>(reason)]; }

  /// The gravest active reason: of the highest control mode, the one with the highest number.
  constexpr Reason gravest(CivilTime t) const {
    Reason found = Reason::none;
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      if (!active(r, t)) continue;
      if (request_of(r).mode < request_of(found).mode) continue;  // uncovered: so far numbers rise with the modes
      found = r;
    }
    return found;
  }
  constexpr ControlMode mode(CivilTime t) const { return request_of(gravest(t)).mode; }
  /// Whether the heartbeat may go on: no active reason forbids it.
  constexpr bool beats(CivilTime t) const {
    for (int i = 1; i < reason_count; ++i) {
      const auto r = static_cast<Reason>(i);
      if (active(r, t) && !request_of(r).beats) return false;
    }
    return true;
  }

 private:
  static constexpr std::int64_t for_ever = std::numeric_limits<std::int64_t>::max();
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::min() + clock_leap_s;

  constexpr std::int64_t& until(Reason r) { return until_s_[static_cast<std::size_t>(r)]; }
  constexpr std::int64_t& since(Reason r) { return since_s_[static_cast<std::size_t>(r)]; }

  std::array<std::int64_t, reason_count> until_s_{};  ///< 0: not active
  std::array<std::int64_t, reason_count> since_s_{};
  std::int64_t last_s_ = never;
};

}  // namespace airside
