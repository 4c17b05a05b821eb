#include "firmware/page/auth/sessions.hpp"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

namespace airside::page {
namespace {

bool is_over(const Session& s, std::int64_t now_ns) {
  const auto since_s = [now_ns](std::int64_t then_ns) { return static_cast<double>(now_ns - then_ns) * 1e-9; };
  return since_s(s.used_ns) > Sessions::idle_s || since_s(s.begun_ns) > Sessions::longest_s;
}

}  // namespace

std::string random_hex(std::size_t bytes) {
  if (sodium_init() < 0) throw std::runtime_error("libsodium finds no source of random numbers");
  std::vector<unsigned char> drawn(bytes);
  randombytes_buf(drawn.data(), drawn.size());
  std::vector<char> hex(2 * bytes + 1);
  sodium_bin2hex(hex.data(), hex.size(), drawn.data(), drawn.size());
  return hex.data();
}

const Session& Sessions::begin(Role role, std::int64_t now_ns) {
  for (Session& s : sessions_) {
    if (s.role != Role::none && is_over(s, now_ns)) s = {};
  }
  // A free place is below every role; viewers, whose password many have, cannot push an installer out.
  const auto place =
      std::ranges::min_element(sessions_, {}, [](const Session& s) { return std::pair(s.role, s.used_ns); });
  *place = {role, random_hex(32), random_hex(16), now_ns, now_ns};
  return *place;
}

const Session* Sessions::find(std::string_view cookie, std::int64_t now_ns) {
  Session* found = nullptr;
  for (Session& s : sessions_) {
    if (s.role == Role::none || s.cookie.size() != cookie.size()) continue;
    if (sodium_memcmp(s.cookie.data(), cookie.data(), cookie.size()) == 0) found = &s;
  }
  if (found == nullptr) return nullptr;
  if (is_over(*found, now_ns)) {
    *found = {};
    return nullptr;
  }
  found->used_ns = now_ns;
  return found;
}

void Sessions::end(std::string_view cookie) {
  for (Session& s : sessions_) {
    if (s.role != Role::none && s.cookie == cookie) s = {};
  }
}

void Sessions::end_all() { sessions_.fill({}); }

}  // namespace airside::page
