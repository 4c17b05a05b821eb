// Heads of HTTP requests: what is answered came to a name of the box, by a route and method of the table, and an upload
// brings the token, no other page's Origin, and one length that fits.

#include <algorithm>

#include "firmware/page/http/request_check.hpp"
#include "fuzz/target.hpp"

namespace airside::fuzz {
namespace {

std::string small(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
  }
  return out;
}

std::string_view take_until(std::string_view& text, char end) {
  const std::string_view front = text.substr(0, text.find(end));
  text.remove_prefix(std::min(text.size(), front.size() + 1));
  return front;
}

/// The values of a line, in order.
std::vector<std::string_view> values(std::span<const page::HeaderLine> lines, std::string_view name) {
  std::vector<std::string_view> found;
  for (const page::HeaderLine& line : lines) {
    if (small(line.name) == small(name)) found.push_back(line.value);
  }
  return found;
}

/// Input: a byte of choices, then `METHOD PATH` and `NAME: VALUE`, one a line.
bool judge(View input) {
  static constexpr const char* locals[] = {"127.0.0.1", "::1", "192.168.1.20", "::ffff:192.168.1.20", "fe80::1", ""};
  Cursor in(input);
  const unsigned choice = in.byte();
  std::string_view text = text_of(in.rest());
  page::RequestHead head;
  head.local_address = locals[choice / 2 % 6];
  head.method = take_until(text, ' ');
  head.path = take_until(text, '\n');
  std::vector<page::HeaderLine> lines;
  while (!text.empty()) {
    std::string_view line = take_until(text, '\n');
    const std::string_view name = take_until(line, ':');
    while (line.starts_with(' ')) line.remove_prefix(1);
    lines.push_back({name, line});
  }
  head.headers = lines;
  const page::RequestRules rules{{"box301.example"}, "0123456789abcdef", 1000, choice % 2 != 0};
  // Nobody, somebody without a session, an operator with one, an installer's program.
  const page::Caller callers[] = {{.rights = {}, .token = {}, .has_key = false},
                                  {.rights = {true, false, true}, .token = {}, .has_key = false},
                                  {.rights = {true, true, false}, .token = "fedcba9876543210", .has_key = false},
                                  {.rights = {true, true, true}, .token = {}, .has_key = true}};
  const page::Caller& caller = callers[choice / 16 % 4];
  (void)page::cookie_of(head, "airside-8350");
  (void)page::bearer_of(head);
  const page::Verdict verdict = page::check_request(head, rules, caller);
  if (verdict.status != 200) {
    FUZZ_CLAIM(verdict.status >= 400 && verdict.status < 500 && verdict.upload_bytes == 0);
    FUZZ_CLAIM(verdict.why.code[0] != '\0' && verdict.why.text[0] != '\0');
    FUZZ_CLAIM((verdict.status == 413) == (verdict.found_bytes > verdict.expected_bytes));
    FUZZ_CLAIM(verdict.route == page::Route::none && (verdict.status == 405) == (verdict.allow[0] != '\0'));
    return false;
  }
  const auto hosts = values(lines, "Host");
  FUZZ_CLAIM(hosts.size() == 1 && lines.size() <= page::max_header_lines);
  std::string host = small(hosts[0]);
  if (const auto colon = host.rfind(':'); colon != std::string::npos && (host[0] != '[' || host[colon - 1] == ']')) {
    FUZZ_CLAIM(colon + 1 < host.size() && std::all_of(host.begin() + static_cast<std::ptrdiff_t>(colon) + 1, host.end(),
                                                      [](char c) { return c >= '0' && c <= '9'; }));
    host.resize(colon);
  }
  if (host.starts_with('[')) host = host.substr(1, host.size() - 2);
  const std::string_view local = head.local_address;
  const bool loopback = local == "127.0.0.1" || local == "::1";
  const bool by_number =
      !host.empty() && host.find_first_not_of("0123456789abcdef:.") == std::string::npos && !local.empty();
  FUZZ_CLAIM(host == "box301.example" || (host == "localhost" && loopback) || by_number);
  if (by_number && host.find(':') == std::string::npos) FUZZ_CLAIM(local.ends_with(host));
  FUZZ_CLAIM(values(lines, "Transfer-Encoding").empty());
  if (verdict.route < page::Route::upload) {
    FUZZ_CLAIM(head.method == "GET" || head.method == "HEAD");
    FUZZ_CLAIM((verdict.route == page::Route::asset) == (verdict.file != nullptr));
    FUZZ_CLAIM(caller.rights.see || verdict.route == page::Route::asset || head.path == "/token" ||
               head.path == "/session.json");
    FUZZ_CLAIM(verdict.upload_bytes == 0);
    return true;
  }
  FUZZ_CLAIM(head.method == "POST");
  const std::string_view token = caller.token.empty() ? std::string_view(rules.token) : caller.token;
  FUZZ_CLAIM(caller.has_key || values(lines, page::token_header) == std::vector<std::string_view>{token});
  const auto origins = values(lines, "Origin");
  FUZZ_CLAIM(origins.empty() ||
             (origins.size() == 1 && small(origins[0]).substr(rules.tls ? 8 : 7) == small(hosts[0])));
  if (verdict.route != page::Route::upload) {
    FUZZ_CLAIM(caller.rights.operate || head.path == "/login" || head.path == "/logout");
    FUZZ_CLAIM(verdict.upload_bytes <= page::max_order_bytes);
    return true;
  }
  FUZZ_CLAIM(head.path == "/weights" && caller.rights.install);
  FUZZ_CLAIM(verdict.upload_bytes > 0 && verdict.upload_bytes <= rules.max_upload_bytes);
  FUZZ_CLAIM(values(lines, "Content-Length").size() == 1);
  return true;
}

std::vector<Bytes> seeds() {
  const auto with = [](char choice, const std::string& text) { return bytes_of(choice + text); };
  return {with('\x18', "GET /status.json\nHost: 127.0.0.1:8080\n"),
          with('\0', "GET /\nHost: 127.0.0.1\nCookie: a=b; airside-8350=0123\n"),
          with('\x24', "POST /release\nHost: 127.0.0.1\nX-Airside-Token: fedcba9876543210\nContent-Length: 1\n"),
          with('\x30', "POST /weights\nHost: 127.0.0.1\nAuthorization: Bearer 01\nContent-Length: 900\n"),
          with('\0', "POST /login\nHost: 127.0.0.1\nX-Airside-Token: 0123456789abcdef\nContent-Length: 30\n"),
          with('\2', "HEAD /token\nHost: [::1]\nAccept: */*\n"),
          with('\x18', "GET /weights.blob\nHost: box301.example\n"),
          with('\x18',
               "POST /weights\nHost: localhost\nOrigin: http://localhost\nX-Airside-Token: 0123456789abcdef\n"
               "Content-Length: 900\n"),
          with('\x19',
               "POST /weights\nHost: localhost:1\nOrigin: https://localhost:1\nX-Airside-Token: 0123456789abcdef\n"
               "Content-Length: 1000\n"),
          with('\0', "GET /../etc/passwd\nHost: evil.example\n"),
          with('\6', "PUT /weights\nHost: 192.168.1.20\n")};
}

std::vector<std::string> words() {
  return {"GET ",
          "HEAD ",
          "POST ",
          "/status.json",
          "/weights.blob",
          "/weights",
          "/token",
          "/release",
          "/login",
          "/session.json",
          "/app.js",
          "Cookie: airside-8350=",
          "Authorization: Bearer ",
          "fedcba9876543210",
          "Host: ",
          "Origin: ",
          "X-Airside-Token: ",
          "Content-Length: ",
          "Transfer-Encoding: chunked",
          "0123456789abcdef",
          "localhost",
          "box301.example",
          "127.0.0.1",
          "[::1]",
          "[::ffff:127.0.0.1]",
          "192.168.1.20",
          ":65536",
          "http://",
          "https://"};
}

}  // namespace

const Target http_request{"http_request", 700, judge, nullptr, seeds, words};

}  // namespace airside::fuzz
