// What airside-page does with a request whose head was judged.

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>
#include <vector>

#include "firmware/page/http/response.hpp"
#include "firmware/page/inbox/wishes.hpp"
#include "firmware/page/page_server.hpp"
#include "hal/modbus/wire.hpp"

namespace airside::page {
namespace {

MHD_Result add_header_line(void* lines, MHD_ValueKind, const char* name, std::size_t name_size, const char* value,
                           std::size_t value_size) {
  auto& list = *static_cast<std::vector<HeaderLine>*>(lines);
  list.push_back({{name, name_size}, value == nullptr ? std::string_view() : std::string_view(value, value_size)});
  return list.size() > max_header_lines ? MHD_NO : MHD_YES;
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// For the audit log.
const char* name_of(Route order) {
  switch (order) {
    case Route::release: return "release";
    case Route::hand_back: return "hand-back";
    case Route::points_read: return "reading of points";
    case Route::points_write: return "trial of a write";
    case Route::points_sign: return "sign-off";
    case Route::points_withdraw: return "withdrawal of a sign-off";
    case Route::rollback: return "rollback";
    default: return "alarm seen";
  }
}

/// A body as part of a line of the log.
std::string one_line(std::string_view body) {
  std::string line;
  for (const char c : body) line += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c;
  return line;
}

/// `4`: that alarm; `all 4`: those up to it, as who sends it has seen no later one; `all`: all of them.
std::optional<AlarmIds> alarms_of(std::string_view body) {
  if (body == "all") return AlarmIds{};
  const bool up_to = body.starts_with("all ");
  if (up_to) body.remove_prefix(4);
  std::uint64_t id = 0;
  const auto [end, error] = std::from_chars(body.data(), body.data() + body.size(), id);
  if (error != std::errc{} || end != body.data() + body.size() || id == 0) return {};
  return AlarmIds{.first = up_to ? 1 : id, .last = id};
}

}  // namespace

MHD_Result PageServer::begin(MHD_Connection* c, Connection& connection, const char* url, const char* method) {
  std::vector<HeaderLine> headers;
  MHD_get_connection_values_n(c, MHD_HEADER_KIND, &add_header_line, &headers);
  const std::string local = local_address_of(connection.socket);
  const RequestHead head{.method = method, .path = url, .headers = headers, .local_address = local};
  const Person person = sign_in_.identify(head, hal::monotonic_ns());
  const Verdict verdict = check_request(head, rules_, person.caller);
  if (verdict.status != 200) {
    if (std::strcmp(method, "POST") == 0) {
      log_.refusal(fmt::format("{} from {} refused: {} {}", std::strcmp(url, "/weights") == 0 ? "upload" : "order",
                               connection.peer.text, verdict.status, verdict.why.text));
    }
    return refuse(c, connection, verdict);
  }
  connection.route = verdict.route;
  connection.who = person.name;
  switch (verdict.route) {
    case Route::asset: return send_asset(c, connection, *verdict.file);
    case Route::session:
      return send_text(c, connection, sign_in_.session_json(person, rules_.token, waiting_wish(inbox_dir_)),
                       "application/json; charset=utf-8");
    case Route::token: {
      const std::string token(person.caller.token.empty() ? std::string_view(rules_.token) : person.caller.token);
      return send_text(c, connection, token + "\n", "text/plain; charset=utf-8");
    }
    case Route::logout: sign_in_.sign_out(head); [[fallthrough]];
    case Route::upload:
    case Route::login:
    case Route::alarm_seen:
    case Route::release:
    case Route::hand_back:
    case Route::rollback:
    case Route::points_read:
    case Route::points_write:
    case Route::points_sign:
    case Route::points_withdraw: return begin_body(c, connection, verdict.upload_bytes);
    default: break;
  }
  const Answer said = answers_.read(verdict.route, MHD_lookup_connection_value(c, MHD_GET_ARGUMENT_KIND, "span"));
  return answer(c, connection, said.status, said.response);
}

MHD_Result PageServer::send_asset(MHD_Connection* c, Connection& connection, const StaticFile& file) {
  int status = MHD_HTTP_OK;
  const auto line = [c](const char* name) { return MHD_lookup_connection_value(c, MHD_HEADER_KIND, name); };
  Response* response = asset_of(file, line("If-None-Match"), line("Accept-Encoding"), status);
  return answer(c, connection, status, response);
}

MHD_Result PageServer::send_text(MHD_Connection* c, Connection& connection, const std::string& text, const char* type) {
  Response* response = response_of(text);
  if (response == nullptr) return MHD_NO;
  MHD_add_response_header(response, "Content-Type", type);
  return answer(c, connection, MHD_HTTP_OK, response);
}

MHD_Result PageServer::put_off(MHD_Connection* c, Connection& connection, int status, const Refused& why, int after_s) {
  Response* response = json_of(refusal(status, why));
  if (response == nullptr) return MHD_NO;
  MHD_add_response_header(response, "Retry-After", std::to_string(after_s).c_str());
  return answer(c, connection, status, response);
}

MHD_Result PageServer::begin_body(MHD_Connection* c, Connection& connection, std::size_t bytes) {
  const auto wait = [&](int status, const Refused& why) {
    log_.refusal(fmt::format("upload from {} put off: {} {}", connection.peer.text, status, why.text));
    return put_off(c, connection, status, why, 15);
  };
  const Refusal* refusal = connection.route == Route::upload ? refusal_of(connection.peer) : nullptr;
  if (refusal != nullptr && hal::monotonic_ns() < refusal->until_ns) {
    return wait(429, refusals::weights_pause);
  }
  if (bytes > 0 && table_.begin_upload(connection, bytes, hal::monotonic_ns()) == nullptr) {
    return wait(503, refusals::upload_busy);
  }
  return MHD_YES;
}

MHD_Result PageServer::end_body(MHD_Connection* c, Connection& connection) {
  std::span<std::byte> body;
  if (Upload* upload = connection.upload; upload != nullptr) {
    ConnectionTable::end_upload(connection);  // its bytes are kept until the next one begins
    if (upload->got != upload->expected) return MHD_NO;
    body = std::span(upload->bytes).first(upload->got);
  }
  if (connection.route == Route::upload) return end_upload(c, connection, body);
  if (connection.route == Route::login) return begin_login(c, connection, body);
  return do_order(c, connection, text_of(body));
}

MHD_Result PageServer::end_upload(MHD_Connection* c, Connection& connection, std::span<const std::byte> blob) {
  const UploadDoor::Answer answered = door_.take(blob);
  const Said& said = answered.said;
  const std::string who = answered.log.empty() ? "nobody's signature" : answered.log;
  if (said.status == 202) {
    log_.say(fmt::format("upload from {} accepted: {} bytes, {}", connection.peer.text, blob.size(), who));
    answers_.ledger().note("uploaded", who, connection.who, answers_.site_time());
  } else {
    log_.refusal(fmt::format("upload from {} refused: {} {} ({} bytes, {})", connection.peer.text, said.status,
                             said.text, blob.size(), who));
  }
  if (said.status == 403 || said.status == 422) {
    Refusal* place = refusal_of(connection.peer);
    if (place == nullptr) place = &*std::ranges::min_element(refusals_, {}, &Refusal::until_ns);
    *place = {connection.peer, after(pause_after_refusal_s)};
  }
  return answer(c, connection, said.status, json_of(said));
}

MHD_Result PageServer::do_order(MHD_Connection* c, Connection& connection, std::string_view body) {
  Said said = refusal(400, refusals::body_unexpected);
  switch (connection.route) {
    case Route::release: said = ask_release(inbox_dir_, body); break;
    case Route::hand_back:
      if (body.empty()) said = ask_hand_back(inbox_dir_);
      break;
    case Route::rollback:
      if (body.empty()) said = ask_rollback(inbox_dir_);
      if (said.status == 202) answers_.ledger().note("rollback asked", "", connection.who, answers_.site_time());
      break;
    case Route::points_read:
      if (body.empty()) said = ask_readings(inbox_dir_);
      break;
    case Route::points_write:
      if (body.empty()) said = ask_write_check(inbox_dir_);
      break;
    case Route::points_sign: said = answers_.checkout().sign(body, connection.who); break;
    case Route::points_withdraw: said = answers_.checkout().withdraw(body); break;
    case Route::alarm_seen: {
      const auto ids = alarms_of(body);
      if (!ids) {
        said = refusal(400, refusals::alarm_form);
      } else if (answers_.ledger().see(*ids, connection.who, answers_.site_time())) {
        said = {200, "seen"};
      } else {
        said = refusal(404, refusals::alarm_unknown);
      }
      break;
    }
    case Route::logout: {
      Response* response = json_of({200, "signed out"});
      if (response == nullptr) return MHD_NO;
      MHD_add_response_header(response, "Set-Cookie", sign_in_.cookie_line(nullptr).c_str());
      return answer(c, connection, 200, response);
    }
    default: return MHD_NO;
  }
  if (said.status < 300) {
    log_.say(fmt::format("{} {} asked for by {} from {}", name_of(connection.route), one_line(body), connection.who,
                         connection.peer.text));
  } else {
    log_.refusal(fmt::format("{} from {} refused: {} {}", name_of(connection.route), connection.peer.text, said.status,
                             said.text));
  }
  return answer(c, connection, said.status, json_of(said));
}

MHD_Result PageServer::begin_login(MHD_Connection* c, Connection& connection, std::span<std::byte> body) {
  const SignIn::Start start = sign_in_.begin(text_of(body), connection.peer, hal::monotonic_ns());
  sodium_memzero(body.data(), body.size());
  if (start.status != 200) return put_off(c, connection, start.status, start.why, start.retry_after_s);
  connection.waits = true;
  login_ = c;
  table_.begin_answer(connection, hal::monotonic_ns());
  MHD_suspend_connection(c);  // others are served while argon2id works
  return MHD_YES;
}

void PageServer::resume_login() {
  auto outcome = sign_in_.finish(hal::monotonic_ns());
  if (!outcome) return;
  login_outcome_ = outcome;
  if (login_ != nullptr) MHD_resume_connection(login_);
}

MHD_Result PageServer::end_login(MHD_Connection* c, Connection& connection) {
  connection.waits = false;
  login_ = nullptr;
  if (!login_outcome_) return MHD_NO;  // the page is ending
  const SignIn::Outcome outcome = *login_outcome_;
  login_outcome_.reset();
  if (outcome.put_off) return put_off(c, connection, 503, *outcome.put_off, 1);
  if (outcome.session == nullptr) return answer(c, connection, 403, json_of(refusal(403, refusals::password_wrong)));
  Response* response = json_of({200, "signed in"});
  if (response == nullptr) return MHD_NO;
  MHD_add_response_header(response, "Set-Cookie", sign_in_.cookie_line(outcome.session).c_str());
  return answer(c, connection, 200, response);
}

PageServer::Refusal* PageServer::refusal_of(const PeerAddress& peer) {
  const auto at =
      std::ranges::find_if(refusals_, [&](const Refusal& r) { return r.until_ns != 0 && r.peer.is_same(peer); });
  return at == refusals_.end() ? nullptr : &*at;
}

MHD_Result PageServer::refuse(MHD_Connection* c, Connection& connection, const Verdict& verdict) {
  Said said = refusal(verdict.status, verdict.why);
  if (verdict.expected_bytes > 0) {
    said.found = std::to_string(verdict.found_bytes);
    said.expected = std::to_string(verdict.expected_bytes);
  }
  Response* response = json_of(said);
  if (*verdict.allow != '\0') MHD_add_response_header(response, "Allow", verdict.allow);
  return answer(c, connection, verdict.status, response);
}

MHD_Result PageServer::answer(MHD_Connection* c, Connection& connection, int status, Response* response) {
  if (response == nullptr) return MHD_NO;
  add_common_lines(response);
  table_.begin_answer(connection, hal::monotonic_ns());
  const MHD_Result queued = MHD_queue_response(c, static_cast<unsigned>(status), response);
  MHD_destroy_response(response);
  return queued;
}

}  // namespace airside::page
