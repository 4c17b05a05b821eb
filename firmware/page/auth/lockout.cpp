#include "firmware/page/auth/lockout.hpp"

#include <algorithm>
#include <cmath>

namespace airside::page {
namespace {

double since_s(std::int64_t then_ns, std::int64_t now_ns) { return static_cast<double>(now_ns - then_ns) * 1e-9; }

}  // namespace

const Lockout::Place* Lockout::find(const Prefix& from) const {
  const auto at = std::ranges::find_if(places_, [&](const Place& p) { return p.all() > 0 && p.prefix == from; });
  return at == places_.end() ? nullptr : &*at;
}

double Lockout::wait_s(const Prefix& from, std::int64_t now_ns) const {
  const Place* place = find(from);
  const double own_s = place == nullptr ? 0 : std::max(0.0, since_s(now_ns, place->until_ns));
  const double credit = credit_ + since_s(credited_ns_, now_ns) * failures_a_minute / 60;
  const double all_s = credit >= 1 ? 0 : (1 - credit) * 60 / failures_a_minute;
  return std::max(own_s, all_s);
}

void Lockout::failed(const Prefix& from, Role role, std::int64_t now_ns) {
  credit_ = std::min(failures_a_minute, credit_ + since_s(credited_ns_, now_ns) * failures_a_minute / 60) - 1;
  credited_ns_ = now_ns;
  Place* place = find(from);
  if (place != nullptr && since_s(place->last_ns, now_ns) > forget_s) *place = {};
  if (place == nullptr) {
    place = &*std::ranges::min_element(places_, {}, [](const Place& p) { return p.all() == 0 ? 0 : p.last_ns; });
    *place = {};
  }
  place->prefix = from;
  place->failures[static_cast<std::size_t>(role)] += 1;
  place->last_ns = now_ns;
  const int beyond = place->all() - free_failures;
  if (beyond < 0) return;
  const double wait = std::min(longest_wait_s, first_wait_s * std::pow(2.0, std::min(beyond, 20)));
  place->until_ns = now_ns + static_cast<std::int64_t>(wait * 1e9);
}

void Lockout::succeeded(const Prefix& from, Role role) {
  if (Place* place = find(from); place != nullptr) place->failures[static_cast<std::size_t>(role)] = 0;
}

}  // namespace airside::page
