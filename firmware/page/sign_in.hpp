#pragma once
// Who asks: cookies of sessions, keys of programs, and passwords, which are tried one at a time and not too often.

#include <cstdint>
#include <optional>
#include <string>

#include "firmware/page/auth/access_file.hpp"
#include "firmware/page/auth/lockout.hpp"
#include "firmware/page/auth/password_check.hpp"
#include "firmware/page/auth/sessions.hpp"
#include "firmware/page/http/audit_log.hpp"
#include "firmware/page/http/connection_table.hpp"
#include "firmware/page/http/request_check.hpp"

namespace airside::page {

/// The sender of a request.
struct Person {
  Role role = Role::none;
  Caller caller{};
  std::string name;  ///< for the audit log and the ledger: a role, or a key's name
};

class SignIn {
 public:
  /// `cookie`: its name.
  SignIn(const std::string& dir, std::string cookie, bool tls, AuditLog& log);

  /// Looks into the file again; where it has changed everybody is signed out.
  void refresh();
  Person identify(const RequestHead& head, std::int64_t now_ns);
  void sign_out(const RequestHead& head) { sessions_.end(cookie_of(head, cookie_)); }

  struct Start {
    int status = 200;  ///< 200: the verification has begun
    Refused why{"", ""};
    int retry_after_s = 0;
  };
  /// `body`: the role's name, a line's end, the password.
  Start begin(std::string_view body, const PeerAddress& from, std::int64_t now_ns);
  /// Of the verification that was begun: the session; or why it is to be tried again; or neither where the password was
  /// wrong. Once only.
  struct Outcome {
    const Session* session = nullptr;
    std::optional<Refused> put_off{};
  };
  std::optional<Outcome> finish(std::int64_t now_ns);
  int descriptor() const { return check_.descriptor(); }

  /// Value of Set-Cookie; of an ended session where there is none.
  std::string cookie_line(const Session* session) const;
  /// {role, rights, roles, token, trouble}, and the wish that waits in the inbox.
  std::string session_json(const Person& person, const std::string& run_token, const std::string& waiting) const;

 private:
  AuditLog& log_;
  AccessWatch watch_;
  Sessions sessions_;
  Lockout lockout_;
  PasswordCheck check_;
  std::string cookie_, said_;
  bool tls_;
  Role asked_role_ = Role::none;
  PeerAddress asked_from_{};
  std::uint64_t asked_generation_ = 0;  ///< of the file that the hash is from
};

}  // namespace airside::page
