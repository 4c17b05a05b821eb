#pragma once
// Who may sign in: one file of mode 600, lines `password ROLE HASH` and `key ROLE DIGEST NAME`.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/page/auth/rights.hpp"

namespace airside::page {

/// A key of a program: 64 hex digits that it sends; here only what BLAKE2b makes of them.
struct AccessKey {
  Role role = Role::none;
  std::string digest;  ///< 64 hex digits
  std::string name;    ///< for people
};

/// What the file says.
struct Access {
  static constexpr const char* file_name = "access";
  static constexpr const char* first_line = "airside-page-access-1";
  static constexpr std::uint64_t max_bytes = 16384;
  static constexpr std::size_t max_keys = 32;

  std::array<std::string, role_count> password{};  ///< argon2id hash by role; "": none
  std::vector<AccessKey> keys;

  bool has_password() const;
  /// What somebody may do who has not signed in: where there is no password and no key, read and send weights, as a
  /// page without this file; else read, unless viewers have a password.
  Rights of_anybody() const;
  /// Role of a program's key, and its name. Role::none for any other text.
  const AccessKey* find_key(std::string_view key) const;
  std::string text() const;
};

/// The hash of a new password: argon2id with 19 MiB and two passes, as fits a small box beside its control.
/// Errors: std::runtime_error without that memory.
std::string hash_of_password(const std::string& password);
/// Whether `password` has that hash. Errors: std::runtime_error without the memory.
bool is_password(const std::string& password, const std::string& hash);
/// Digest of a program's key as the file has it.
std::string digest_of_key(std::string_view key);

/// Reads `dir`/access; what is not there is an empty Access.
/// Errors: InputError for another owner's or group's rights to it, and for any line that is not as above.
Access read_access(const std::string& dir);
/// Replaces it for good, a power cut included: mode 600, owned by whom the folder is owned. Errors: InputError.
void write_access(const std::string& dir, const Access& access);

/// The file, read again where it has changed. Where it cannot be read nobody may do anything.
class AccessWatch {
 public:
  explicit AccessWatch(std::string dir) : dir_(std::move(dir)) { refresh(); }

  /// True: it has changed, so every session ends.
  bool refresh();
  const Access& access() const { return access_; }
  /// Of the file: rises with each change.
  std::uint64_t generation() const { return generation_; }
  Rights of_anybody() const { return trouble_.empty() ? access_.of_anybody() : Rights{}; }
  /// Why it cannot be read; empty where it can.
  const std::string& trouble() const { return trouble_; }

 private:
  std::string dir_, trouble_;
  Access access_;
  std::uint64_t generation_ = 0;
  std::array<std::int64_t, 3> seen_{-1, -1, -1};  ///< inode, time of change, size
};

}  // namespace airside::page
