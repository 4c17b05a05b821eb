#include "firmware/page/sign_in.hpp"

#include <fmt/format.h>

#include <cmath>

#include "firmware/page/data/state_folder.hpp"

namespace airside::page {

SignIn::SignIn(const std::string& dir, std::string cookie, bool tls, AuditLog& log)
    : log_(log), watch_(dir), cookie_(std::move(cookie)), tls_(tls) {
  refresh();
}

void SignIn::refresh() {
  if (watch_.refresh()) sessions_.end_all();
  if (watch_.trouble() == said_) return;
  said_ = watch_.trouble();
  if (!said_.empty()) log_.say("nobody may do anything until this is put right: " + said_);
}

Person SignIn::identify(const RequestHead& head, std::int64_t now_ns) {
  refresh();
  Person person;
  person.caller.rights = watch_.of_anybody();
  person.name = "nobody who signed in";
  const std::string_view cookie = cookie_of(head, cookie_), key = bearer_of(head);
  if (!key.empty()) {
    const AccessKey* known = watch_.access().find_key(key);
    if (known == nullptr) return person;
    person.role = known->role;
    person.name = fmt::format("key \"{}\" of the {}", known->name, text_of(known->role));
    person.caller = {.rights = rights_of(known->role), .token = {}, .has_key = true};
  } else if (const Session* session = cookie.empty() ? nullptr : sessions_.find(cookie, now_ns)) {
    person.role = session->role;
    person.name = text_of(session->role);
    person.caller = {.rights = rights_of(session->role), .token = session->token, .has_key = false};
  }
  return person;
}

SignIn::Start SignIn::begin(std::string_view body, const PeerAddress& from, std::int64_t now_ns) {
  const std::size_t end = body.find('\n');
  const Role role = role_of(body.substr(0, end));
  if (end == std::string_view::npos || role == Role::none) return {400, refusals::sign_in_form};
  if (!watch_.trouble().empty()) return {503, refusals::passwords_unreadable};
  if (const double wait_s = lockout_.wait_s(from.prefix(), now_ns); wait_s > 0) {
    log_.refusal(fmt::format("sign-in from {} put off: {:.0f} s after too many wrong passwords", from.text, wait_s));
    return {429, refusals::passwords_locked, static_cast<int>(std::ceil(wait_s))};
  }
  const std::string& hash = watch_.access().password[static_cast<std::size_t>(role)];
  if (!check_.begin(hash, std::string(body.substr(end + 1)))) {
    return {503, refusals::sign_in_busy, 1};
  }
  asked_role_ = role;
  asked_from_ = from;
  asked_generation_ = watch_.generation();
  return {};
}

std::optional<SignIn::Outcome> SignIn::finish(std::int64_t now_ns) {
  const std::optional<PasswordResult> found = check_.result();
  if (!found) return {};
  refresh();
  const auto put_off = [this](const Refused& why) {
    log_.refusal(
        fmt::format("sign-in of the {} from {} put off: {}", text_of(asked_role_), asked_from_.text, why.text));
    return Outcome{nullptr, why};
  };
  // The hash is of passwords that hold no longer: the old one must not open a session that outlives it.
  if (watch_.generation() != asked_generation_) return put_off(refusals::passwords_changed);
  if (*found == PasswordResult::no_memory) return put_off(refusals::sign_in_no_memory);
  if (*found == PasswordResult::wrong) {
    lockout_.failed(asked_from_.prefix(), asked_role_, now_ns);
    log_.refusal(fmt::format("wrong password of the {} from {}", text_of(asked_role_), asked_from_.text));
    return Outcome{};
  }
  lockout_.succeeded(asked_from_.prefix(), asked_role_);
  log_.say(fmt::format("the {} has signed in from {}", text_of(asked_role_), asked_from_.text));
  return Outcome{&sessions_.begin(asked_role_, now_ns), {}};
}

std::string SignIn::cookie_line(const Session* session) const {
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict{}{}", cookie_, session == nullptr ? "" : session->cookie,
                     tls_ ? "; Secure" : "", session == nullptr ? "; Max-Age=0" : "");
}

std::string SignIn::session_json(const Person& person, const std::string& run_token, const std::string& waiting) const {
  nlohmann::json roles = nlohmann::json::array();
  for (const Role role : {Role::viewer, Role::operator_, Role::installer}) {
    if (!watch_.access().password[static_cast<std::size_t>(role)].empty()) roles.push_back(text_of(role));
  }
  const Rights& rights = person.caller.rights;
  return dumped({{"role", text_of(person.role)},
                 {"see", rights.see},
                 {"operate", rights.operate},
                 {"install", rights.install},
                 {"roles", roles},
                 {"token", person.caller.token.empty() ? run_token : std::string(person.caller.token)},
                 {"idle_s", Sessions::idle_s},
                 {"waiting", rights.see ? waiting : std::string()},
                 {"trouble", !watch_.trouble().empty()}});
}

}  // namespace airside::page
