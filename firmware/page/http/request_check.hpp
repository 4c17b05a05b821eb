#pragma once
// Which requests airside-page answers at all: the whole judgement of a request's head, as one function without I/O.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/page/auth/rights.hpp"
#include "firmware/page/http/refusals.hpp"
#include "firmware/page/http/static_files.hpp"

namespace airside::page {

/// What can be asked for.
enum class Route : std::uint8_t {
  none,
  asset,  ///< a file of the page itself
  status,
  site,
  alarms,
  weights_facts,
  trends,
  trends_csv,
  gap,
  points,
  points_csv,
  metrics,
  weights,
  session,
  token,
  upload,  ///< what follows changes something
  login,
  logout,
  alarm_seen,
  release,
  hand_back,
  rollback,
  points_read,
  points_write,
  points_sign,
  points_withdraw,
};

struct HeaderLine {
  std::string_view name, value;
};

/// The head of a request as it came; texts may hold any bytes.
struct RequestHead {
  std::string_view method;
  std::string_view path;  ///< as sent, without the query
  std::span<const HeaderLine> headers;
  std::string_view local_address;  ///< numeric, at which the peer has reached us
};

/// What requests are held against.
struct RequestRules {
  std::vector<std::string> names;  ///< host names in small letters
  std::string token;               ///< of this run
  std::size_t max_upload_bytes = 0;
  bool tls = false;
};

/// Who asks, as far as cookie or key prove it.
struct Caller {
  Rights rights{};
  std::string_view token;  ///< of the session; empty: the run's counts
  bool has_key = false;    ///< a program with a key of its own: no browser, so no token is asked for
};

struct Verdict {
  int status = 200;  ///< HTTP; anything else is a refusal
  Route route = Route::none;
  const StaticFile* file = nullptr;  ///< of Route::asset
  Refused why{"", ""};               ///< of a refusal; a fixed text that repeats nothing of the request
  const char* allow = "";            ///< methods of the path, for 405
  std::size_t upload_bytes = 0;      ///< length of the body that may follow; 0: none
  std::uint64_t found_bytes = 0, expected_bytes = 0;  ///< of a body that is too long, and the longest; else 0
};

constexpr std::size_t max_header_lines = 64;
constexpr std::size_t max_order_bytes = 1024;  ///< of a body that is no upload
constexpr const char* token_header = "X-Airside-Token";

/// Value of the cookie `name`; empty where the request has none, or several lines of cookies.
std::string_view cookie_of(const RequestHead& head, std::string_view name);
/// The key of a line `Authorization: Bearer KEY`; empty without one.
std::string_view bearer_of(const RequestHead& head);

/// Judges a head, first doubt first: too many lines (431), lines that must not be doubled (400), Host (400, 421), path
/// (404), method (405), the caller's rights (401), and for what changes something Origin and token (403), then its
/// length (411, 400, 413, before any of it is read). A GET that brings a body is refused (400).
/// Host is an address of this machine that the peer has reached, `localhost` if that is a loopback one, or one of
/// `names`: a name that somebody else's server has pointed at us is none of them. Origin, where there is one, must be
/// the very scheme and host of the request.
/// Cost: linear in the head.  Source: docs/box-and-safety.md, rows 55, 56, 58.
Verdict check_request(const RequestHead& head, const RequestRules& rules, const Caller& caller);

}  // namespace airside::page
