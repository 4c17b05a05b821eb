#pragma once
// What a person does on the box itself: the first password, and keys for programs.

#include <string>

#include "firmware/page/auth/rights.hpp"

namespace airside::page {

/// Reads a password (twice from a terminal, without echo; one line from anything else) and keeps its hash in `dir`.
/// Errors: InputError for one that is too short, too long or not repeated, or a folder that cannot be written.
void set_password(const std::string& dir, Role role);
/// Takes a role's password away.
void clear_password(const std::string& dir, Role role);
/// Draws a key with the rights of `role` and prints it, once; the folder keeps its digest under `name`.
void new_key(const std::string& dir, Role role, const std::string& name);

}  // namespace airside::page
