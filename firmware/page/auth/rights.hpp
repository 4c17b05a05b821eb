#pragma once
// Who a request comes from, and what that person may do.

#include <cstdint>
#include <string_view>

namespace airside::page {

/// In rising order: an operator may do what a viewer may, an installer what an operator may.
enum class Role : std::uint8_t { none, viewer, operator_, installer };
constexpr int role_count = 4;

constexpr const char* text_of(Role role) {
  constexpr const char* names[role_count] = {"none", "viewer", "operator", "installer"};
  return names[static_cast<int>(role)];
}

/// Role::none for any other text.
constexpr Role role_of(std::string_view name) {
  for (const Role role : {Role::viewer, Role::operator_, Role::installer}) {
    if (name == text_of(role)) return role;
  }
  return Role::none;
}

/// What somebody may do.
struct Rights {
  bool see = false;      ///< status, logs, weights that are given out
  bool operate = false;  ///< release, hand-back, rollback, acknowledging alarms
  bool install = false;  ///< sending weights
};

/// Of a role that was proved by password or key.
constexpr Rights rights_of(Role role) {
  return {role >= Role::viewer, role >= Role::operator_, role >= Role::installer};
}

}  // namespace airside::page
