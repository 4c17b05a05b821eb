#include "firmware/page/http/request_check.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

namespace airside::page {
namespace {

char small_letter(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same_word(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, {}, small_letter, small_letter);
}

enum class Right : std::uint8_t { anybody, see, operate, install, sign_off };

/// All routes there are but the page's own files. No part of a request ever names a file.
struct Entry {
  std::string_view path;
  Route route;
  Right right;
};
constexpr auto routes = std::to_array<Entry>({
    {"/status.json", Route::status, Right::see},
    {"/site.json", Route::site, Right::see},
    {"/alarms.json", Route::alarms, Right::see},
    {"/weights.json", Route::weights_facts, Right::see},
    {"/trends.json", Route::trends, Right::see},
    {"/trends.csv", Route::trends_csv, Right::see},
    {"/gap.json", Route::gap, Right::see},
    {"/points.json", Route::points, Right::see},
    {"/points.csv", Route::points_csv, Right::see},
    {"/metrics", Route::metrics, Right::see},
    {"/weights.blob", Route::weights, Right::see},
    {"/session.json", Route::session, Right::anybody},
    {"/token", Route::token, Right::anybody},
    {"/weights", Route::upload, Right::install},
    {"/login", Route::login, Right::anybody},
    {"/logout", Route::logout, Right::anybody},
    {"/alarms/seen", Route::alarm_seen, Right::operate},
    {"/release", Route::release, Right::operate},
    {"/hand-back", Route::hand_back, Right::operate},
    {"/rollback", Route::rollback, Right::operate},
    {"/points/read", Route::points_read, Right::operate},
    {"/points/write", Route::points_write, Right::sign_off},
    {"/points/sign", Route::points_sign, Right::sign_off},
    {"/points/withdraw", Route::points_withdraw, Right::sign_off},
});

constexpr bool changes_something(Route route) { return route >= Route::upload; }

/// Value of the line `name`, how often it occurs.
struct Found {
  std::string_view value;
  int times = 0;
};
Found find(std::span<const HeaderLine> headers, std::string_view name) {
  Found found;
  for (const HeaderLine& line : headers) {
    if (!same_word(line.name, name)) continue;
    if (found.times++ == 0) found.value = line.value;
  }
  return found;
}

std::optional<std::uint64_t> number_of(std::string_view digits) {
  if (digits.empty() || digits.size() > 18) return std::nullopt;
  std::uint64_t n = 0;
  for (const char c : digits) {
    if (c < '0' || c > '9') return std::nullopt;
    n = 10 * n + static_cast<std::uint64_t>(c - '0');
  }
  return n;
}

/// The host of `host`, `host:port`, `[v6]` or `[v6]:port`, without brackets; empty if it is none of them.
std::string_view host_of(std::string_view value) {
  std::string_view host = value, rest;
  if (value.starts_with('[')) {
    const std::size_t end = value.find(']');
    if (end == std::string_view::npos) return {};
    host = value.substr(1, end - 1);
    rest = value.substr(end + 1);
  } else if (const std::size_t colon = value.find(':'); colon != std::string_view::npos) {
    host = value.substr(0, colon);
    rest = value.substr(colon);
  }
  if (rest.empty()) return host;
  const auto port = number_of(rest.substr(1));
  return rest.front() == ':' && port && *port <= 65535 ? host : std::string_view{};
}

/// A numeric address, IPv4 as the IPv6 address that stands for it.
using Address = std::array<std::uint8_t, 16>;
std::optional<Address> address_of(std::string_view text) {
  std::array<char, INET6_ADDRSTRLEN> word{};
  if (text.empty() || text.size() >= word.size() || text.find('\0') != std::string_view::npos) return std::nullopt;
  std::ranges::copy(text, word.begin());
  Address address{};
  if (::inet_pton(AF_INET6, word.data(), address.data()) == 1) return address;
  address[10] = address[11] = 0xFF;
  if (::inet_pton(AF_INET, word.data(), address.data() + 12) == 1) return address;
  return std::nullopt;
}

bool is_loopback(const Address& a) {
  constexpr Address six{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  const bool mapped = std::all_of(a.begin(), a.begin() + 10, [](auto b) { return b == 0; }) && a[10] == 0xFF;
  return a == six || (mapped && a[11] == 0xFF && a[12] == 127);
}

bool is_our_host(std::string_view host, std::string_view local_address, const RequestRules& rules) {
  const auto local = address_of(local_address);
  if (const auto address = address_of(host)) return local && *address == *local;
  if (same_word(host, "localhost")) return local && is_loopback(*local);
  return std::ranges::any_of(rules.names, [host](const std::string& name) { return same_word(host, name); });
}

/// `http://host:port` of the very host that was asked.
bool is_own_origin(std::string_view origin, std::string_view host, bool tls) {
  const std::string_view scheme = tls ? "https://" : "http://";
  return origin.starts_with(scheme) && same_word(origin.substr(scheme.size()), host);
}

/// In a time that does not tell where they differ.
bool is_token(std::string_view given, std::string_view token) {
  if (token.empty() || given.size() != token.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < token.size(); ++i) {
    difference |= static_cast<unsigned>(static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(token[i]));
  }
  return difference == 0;
}

Verdict refuse(int status, const Refused& why, const char* allow = "") {
  return {.status = status, .why = why, .allow = allow};
}

Verdict refuse_length(const Refused& why, std::uint64_t found_bytes, std::uint64_t expected_bytes) {
  return {.status = 413, .why = why, .found_bytes = found_bytes, .expected_bytes = expected_bytes};
}

/// Null: the caller may.
const Refused* missing_right(Right right, const Rights& rights) {
  switch (right) {
    case Right::anybody: return nullptr;
    case Right::see: return rights.see ? nullptr : &refusals::sign_in_viewer;
    case Right::operate: return rights.operate ? nullptr : &refusals::sign_in_operator;
    case Right::sign_off:  // without a password everybody may send what is signed, and do nothing else
      return rights.operate && rights.install ? nullptr : &refusals::sign_in_installer;
    case Right::install: return rights.install ? nullptr : &refusals::sign_in_installer;
  }
  return &refusals::nobody_may;  // uncovered: the switch is complete
}

/// That the request was made on purpose, by the page that we gave out or by a program.
Verdict check_origin(const RequestHead& head, const RequestRules& rules, const Caller& caller, std::string_view host) {
  const Found origin = find(head.headers, "Origin"), token = find(head.headers, token_header);
  if (origin.times > 1) return refuse(400, refusals::origin_twice);
  if (origin.times == 1 && !is_own_origin(origin.value, host, rules.tls)) {
    return refuse(403, refusals::origin_other);
  }
  const std::string_view expected = caller.token.empty() ? std::string_view(rules.token) : caller.token;
  if (!caller.has_key && (token.times != 1 || !is_token(token.value, expected))) {
    return refuse(403, refusals::token_missing);
  }
  return {};
}

Verdict check_upload(const RequestHead& head, const RequestRules& rules) {
  const Found length = find(head.headers, "Content-Length");
  if (find(head.headers, "Transfer-Encoding").times > 0 || length.times == 0) {
    return refuse(411, refusals::length_missing);
  }
  const auto bytes = number_of(length.value);
  if (length.times > 1 || !bytes) return refuse(400, refusals::length_wrong);
  if (*bytes > rules.max_upload_bytes) {
    return refuse_length(refusals::weights_too_large, *bytes, rules.max_upload_bytes);
  }
  if (*bytes == 0) return refuse(400, refusals::weights_empty);
  return {.route = Route::upload, .upload_bytes = static_cast<std::size_t>(*bytes)};
}

/// A short body, or none.
Verdict check_order(const RequestHead& head, Route route) {
  const Found length = find(head.headers, "Content-Length");
  if (find(head.headers, "Transfer-Encoding").times > 0) {
    return refuse(411, refusals::length_missing);
  }
  const auto bytes = length.times == 0 ? std::optional<std::uint64_t>(0) : number_of(length.value);
  if (length.times > 1 || !bytes) return refuse(400, refusals::length_wrong);
  if (*bytes > max_order_bytes) return refuse_length(refusals::body_too_large, *bytes, max_order_bytes);
  return {.route = route, .upload_bytes = static_cast<std::size_t>(*bytes)};
}

Verdict check_read(const RequestHead& head, Route route, const StaticFile* file) {
  const Found length = find(head.headers, "Content-Length");
  const bool empty = length.times == 0 || (length.times == 1 && number_of(length.value) == std::uint64_t{0});
  if (find(head.headers, "Transfer-Encoding").times > 0 || !empty) return refuse(400, refusals::body_unexpected);
  return {.route = route, .file = file};
}

}  // namespace

std::string_view cookie_of(const RequestHead& head, std::string_view name) {
  const Found line = find(head.headers, "Cookie");
  if (line.times != 1) return {};
  std::string_view rest = line.value;
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find(';'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    while (rest.starts_with(' ')) rest.remove_prefix(1);
    if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=') {
      return pair.substr(name.size() + 1);
    }
  }
  return {};
}

std::string_view bearer_of(const RequestHead& head) {
  constexpr std::string_view scheme = "Bearer ";
  const Found line = find(head.headers, "Authorization");
  if (line.times != 1 || line.value.size() <= scheme.size()) return {};
  return same_word(line.value.substr(0, scheme.size()), scheme) ? line.value.substr(scheme.size()) : std::string_view{};
}

Verdict check_request(const RequestHead& head, const RequestRules& rules, const Caller& caller) {
  if (head.headers.size() > max_header_lines) return refuse(431, refusals::too_many_headers);
  const Found host = find(head.headers, "Host");
  if (host.times != 1) return refuse(400, refusals::host_missing);
  if (!is_our_host(host_of(host.value), head.local_address, rules)) {
    return refuse(421, refusals::host_unknown);
  }
  const StaticFile* file = find_static_file(head.path);
  const auto* entry = std::ranges::find(routes, head.path, &Entry::path);
  if (file == nullptr && entry == routes.end()) return refuse(404, refusals::no_page);
  const Route route = file != nullptr ? Route::asset : entry->route;
  const bool changes = changes_something(route);
  const bool reads = head.method == "GET" || head.method == "HEAD";
  if (changes ? head.method != "POST" : !reads) {
    return refuse(405, refusals::wrong_method, changes ? "POST" : "GET, HEAD");
  }
  const Refused* missing = missing_right(file != nullptr ? Right::anybody : entry->right, caller.rights);
  if (missing != nullptr) return refuse(401, *missing);
  if (!changes) return check_read(head, route, file);
  const Verdict origin = check_origin(head, rules, caller, host.value);
  if (origin.status != 200) return origin;
  return route == Route::upload ? check_upload(head, rules) : check_order(head, route);
}

}  // namespace airside::page
