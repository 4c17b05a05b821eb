// The judgement of a request's head, case by case: first doubt first.

#include <gtest/gtest.h>

#include <array>

#include "firmware/page/http/request_check.hpp"

namespace airside::page {
namespace {

using Lines = std::vector<HeaderLine>;
constexpr const char* token = "0123456789abcdef";

RequestRules rules(bool tls = false) {
  return {.names = {"ahu-3.example.org"}, .token = token, .max_upload_bytes = 1000, .tls = tls};
}
/// What anybody may do where no password is set.
const Caller anybody{.rights = {.see = true, .operate = false, .install = true}, .token = {}, .has_key = false};

Verdict judged(std::string_view method, std::string_view path, const Lines& lines, bool tls = false,
               std::string_view local = "127.0.0.1") {
  return check_request({.method = method, .path = path, .headers = lines, .local_address = local}, rules(tls), anybody);
}
int status_for(const Caller& caller, std::string_view method, std::string_view path, Lines more = {}) {
  more.insert(more.begin(), {"Host", "127.0.0.1"});
  return check_request({.method = method, .path = path, .headers = more, .local_address = "127.0.0.1"}, rules(), caller)
      .status;
}
int status_with_host(std::string_view host, std::string_view local = "127.0.0.1") {
  const Lines lines{{"Host", host}};
  return judged("GET", "/status.json", lines, false, local).status;
}
Lines upload_lines() { return {{"Host", "127.0.0.1:8350"}, {"x-airside-token", token}, {"Content-Length", "1000"}}; }

TEST(RequestCheck, TakesHostsThatAreThisBoxAndNoOthers) {
  for (const char* own :
       {"127.0.0.1", "127.0.0.1:8350", "localhost", "LocalHost:1", "ahu-3.example.org", "AHU-3.Example.ORG:8350"}) {
    EXPECT_EQ(status_with_host(own), 200) << own;
  }
  for (const char* other : {"", "evil.example", "127.0.0.1.evil.example", "127.0.0.2", "ahu-3.example.org.",
                            "localhost:port", "localhost:99999", "127.0.0.1:8350:1", "x@127.0.0.1", "[::1]",
                            "[127.0.0.1", " 127.0.0.1", "127.1", "0.0.0.0", "::1", "[]", ":"}) {
    EXPECT_EQ(status_with_host(other), 421) << other;
  }
  EXPECT_EQ(status_with_host("[::1]:8350", "::1"), 200);
  EXPECT_EQ(status_with_host("192.168.1.30", "192.168.1.30"), 200);
  EXPECT_EQ(status_with_host("192.168.1.30", "::ffff:192.168.1.30"), 200) << "one address in both writings";
  EXPECT_EQ(status_with_host("localhost", "192.168.1.30"), 421) << "that is another machine's name for itself";
  EXPECT_EQ(status_with_host(std::string_view("127.0.0.1\0.x", 12)), 421);
}

TEST(RequestCheck, WantsHostOnce) {
  EXPECT_EQ(judged("GET", "/status.json", {}).status, 400);
  const Lines twice{{"Host", "127.0.0.1"}, {"host", "127.0.0.1"}};
  EXPECT_EQ(judged("GET", "/status.json", twice).status, 400);
}

TEST(RequestCheck, KnowsPathsByTheirBytes) {
  const Lines lines{{"Host", "127.0.0.1"}};
  EXPECT_EQ(judged("GET", "/status.json", lines).route, Route::status);
  EXPECT_EQ(judged("HEAD", "/weights.blob", lines).route, Route::weights);
  EXPECT_EQ(judged("GET", "/token", lines).route, Route::token);
  EXPECT_EQ(judged("GET", "/", lines).route, Route::asset);
  ASSERT_NE(judged("GET", "/app.js", lines).file, nullptr);
  EXPECT_EQ(judged("GET", "/app.js", lines).file->path, "/app.js");
  for (const char* path : {"", "/index.html", "/app.js/", "/texts/", "/texts/../app.js", "/status", "/status.json/",
                           "//status.json", "/./status.json", "/status.json ", "/../status.json", "/status%2ejson",
                           "status.json", "http://127.0.0.1/status.json", "*"}) {
    EXPECT_EQ(judged("GET", path, lines).status, 404) << path;
  }
}

TEST(RequestCheck, KnowsOneMethodAPath) {
  const Lines lines{{"Host", "127.0.0.1"}};
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "CONNECT", "get", ""}) {
    const Verdict v = judged(method, "/status.json", lines);
    EXPECT_EQ(v.status, 405) << method;
    EXPECT_STREQ(v.allow, "GET, HEAD");
  }
  for (const char* method : {"GET", "HEAD", "PUT", "OPTIONS"}) {
    const Verdict v = judged(method, "/weights", upload_lines());
    EXPECT_EQ(v.status, 405) << method;
    EXPECT_STREQ(v.allow, "POST");
  }
}

TEST(RequestCheck, TakesAnUploadOfAtMostABlobsLength) {
  const Verdict v = judged("POST", "/weights", upload_lines());
  EXPECT_EQ(v.status, 200);
  EXPECT_EQ(v.route, Route::upload);
  EXPECT_EQ(v.upload_bytes, 1000u);
  const auto with_length = [](const char* text) {
    Lines lines = upload_lines();
    lines[2].value = text;
    return judged("POST", "/weights", lines).status;
  };
  EXPECT_EQ(with_length("1001"), 413);
  EXPECT_EQ(with_length("999999999999999999"), 413);
  for (const char* text : {"", "-1", "+5", "5 ", " 5", "0x10", "5,5", "1e3", "18446744073709551617", "0"}) {
    EXPECT_EQ(with_length(text), 400) << text;
  }
  Lines lines = upload_lines();
  lines.push_back({"Content-Length", "1000"});
  EXPECT_EQ(judged("POST", "/weights", lines).status, 400);
  lines = upload_lines();
  lines.push_back({"Transfer-Encoding", "chunked"});
  EXPECT_EQ(judged("POST", "/weights", lines).status, 411);
  lines = upload_lines();
  lines.pop_back();
  EXPECT_EQ(judged("POST", "/weights", lines).status, 411);
}

TEST(RequestCheck, WantsTheTokenOfThisRunOnce) {
  const auto with_token = [](Lines more) {
    Lines lines{{"Host", "127.0.0.1"}, {"Content-Length", "10"}};
    lines.insert(lines.end(), more.begin(), more.end());
    return judged("POST", "/weights", lines).status;
  };
  EXPECT_EQ(with_token({{token_header, token}}), 200);
  EXPECT_EQ(with_token({}), 403);
  EXPECT_EQ(with_token({{token_header, ""}}), 403);
  EXPECT_EQ(with_token({{token_header, "0123456789abcdee"}}), 403);
  EXPECT_EQ(with_token({{token_header, "0123456789abcdef0"}}), 403);
  EXPECT_EQ(with_token({{token_header, token}, {token_header, token}}), 403);
  RequestRules none = rules();
  none.token.clear();
  const Lines lines{{"Host", "127.0.0.1"}, {"Content-Length", "10"}, {token_header, ""}};
  EXPECT_EQ(check_request({"POST", "/weights", lines, "127.0.0.1"}, none, anybody).status, 403)
      << "no token is no open door";
}

TEST(RequestCheck, GivesEachRoleItsRightsAndNoMore) {
  const Lines with_token{{token_header, token}, {"Content-Length", "1"}};
  struct Row {
    const char* method;
    const char* path;
    bool anybody, viewer, operator_, installer;
  };
  for (const Row& row : std::to_array<Row>({{"GET", "/", true, true, true, true},
                                            {"GET", "/session.json", true, true, true, true},
                                            {"GET", "/status.json", false, true, true, true},
                                            {"GET", "/trends.csv", false, true, true, true},
                                            {"GET", "/metrics", false, true, true, true},
                                            {"GET", "/weights.blob", false, true, true, true},
                                            {"POST", "/login", true, true, true, true},
                                            {"POST", "/release", false, false, true, true},
                                            {"POST", "/hand-back", false, false, true, true},
                                            {"POST", "/rollback", false, false, true, true},
                                            {"POST", "/alarms/seen", false, false, true, true},
                                            {"GET", "/gap.json", false, true, true, true},
                                            {"GET", "/points.json", false, true, true, true},
                                            {"GET", "/points.csv", false, true, true, true},
                                            {"POST", "/points/read", false, false, true, true},
                                            {"POST", "/points/write", false, false, false, true},
                                            {"POST", "/points/sign", false, false, false, true},
                                            {"POST", "/points/withdraw", false, false, false, true},
                                            {"POST", "/weights", false, false, false, true}})) {
    const auto may = [&](Role role) {
      const Caller caller{.rights = rights_of(role), .token = {}, .has_key = false};
      const int status = status_for(caller, row.method, row.path, *row.method == 'P' ? with_token : Lines{});
      EXPECT_TRUE(status == 200 || status == 401) << row.path << " " << text_of(role) << " " << status;
      return status == 200;
    };
    EXPECT_EQ(may(Role::none), row.anybody) << row.path;
    EXPECT_EQ(may(Role::viewer), row.viewer) << row.path;
    EXPECT_EQ(may(Role::operator_), row.operator_) << row.path;
    EXPECT_EQ(may(Role::installer), row.installer) << row.path;
  }
  EXPECT_EQ(status_for(anybody, "POST", "/points/sign", with_token), 401) << "without any password nobody signs";
}

TEST(RequestCheck, WantsTheTokenOfTheSessionWhereThereIsOne) {
  const Caller person{.rights = rights_of(Role::operator_), .token = "fedcba9876543210", .has_key = false};
  EXPECT_EQ(status_for(person, "POST", "/release", {{token_header, "fedcba9876543210"}}), 200);
  EXPECT_EQ(status_for(person, "POST", "/release", {{token_header, token}}), 403) << "the run's token is no session's";
  EXPECT_EQ(status_for(person, "POST", "/release"), 403);
  const Caller program{.rights = rights_of(Role::operator_), .token = {}, .has_key = true};
  EXPECT_EQ(status_for(program, "POST", "/release"), 200) << "no browser sends a key by itself";
  EXPECT_EQ(status_for(program, "POST", "/release", {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(status_for(program, "POST", "/release", {{"Content-Length", "1025"}}), 413);
  EXPECT_EQ(status_for(program, "GET", "/release"), 405);
}

TEST(RequestCheck, FindsCookieAndKey) {
  const auto cookie = [](const Lines& lines) { return cookie_of({"GET", "/", lines, "127.0.0.1"}, "airside-1"); };
  EXPECT_EQ(cookie({{"Cookie", "airside-1=abc"}}), "abc");
  EXPECT_EQ(cookie({{"cookie", "x=1; airside-1=abc; y=2"}}), "abc");
  EXPECT_EQ(cookie({{"Cookie", "xairside-1=abc; airside-10=d; airside-1"}}), "");
  EXPECT_EQ(cookie({{"Cookie", "airside-1=a"}, {"Cookie", "airside-1=b"}}), "")
      << "which of both counts is not guessed";
  const auto key = [](const Lines& lines) { return bearer_of({"GET", "/", lines, "127.0.0.1"}); };
  EXPECT_EQ(key({{"Authorization", "Bearer abc"}}), "abc");
  EXPECT_EQ(key({{"Authorization", "bearer abc"}}), "abc");
  EXPECT_EQ(key({{"Authorization", "Basic abc"}}), "");
  EXPECT_EQ(key({{"Authorization", "Bearer "}}), "");
}

TEST(RequestCheck, TakesAnOriginThatIsTheHostItself) {
  const auto with_origin = [](const char* origin, bool tls = false) {
    Lines lines = upload_lines();
    lines.push_back({"Origin", origin});
    return judged("POST", "/weights", lines, tls).status;
  };
  EXPECT_EQ(with_origin("http://127.0.0.1:8350"), 200);
  EXPECT_EQ(with_origin("https://127.0.0.1:8350", true), 200);
  for (const char* origin : {"null", "", "https://127.0.0.1:8350", "http://127.0.0.1", "http://127.0.0.1:8350/",
                             "http://evil.example", "http://127.0.0.1:8350.evil.example", "127.0.0.1:8350"}) {
    EXPECT_EQ(with_origin(origin), 403) << origin;
  }
  EXPECT_EQ(with_origin("http://127.0.0.1:8350", true), 403);
  Lines lines = upload_lines();
  lines.push_back({"Origin", "http://127.0.0.1:8350"});
  lines.push_back({"Origin", "http://127.0.0.1:8350"});
  EXPECT_EQ(judged("POST", "/weights", lines).status, 400);
}

TEST(RequestCheck, RefusesBodiesWhereNoneBelongsAndTooManyLines) {
  EXPECT_EQ(judged("GET", "/status.json", {{"Host", "127.0.0.1"}, {"Content-Length", "0"}}).status, 200);
  EXPECT_EQ(judged("GET", "/status.json", {{"Host", "127.0.0.1"}, {"Content-Length", "1"}}).status, 400);
  EXPECT_EQ(judged("GET", "/status.json", {{"Host", "127.0.0.1"}, {"Transfer-Encoding", "chunked"}}).status, 400);
  Lines many{{"Host", "127.0.0.1"}};
  while (many.size() < max_header_lines) many.push_back({"A", "b"});
  EXPECT_EQ(judged("GET", "/status.json", many).status, 200);
  many.push_back({"A", "b"});
  EXPECT_EQ(judged("GET", "/status.json", many).status, 431);
}

}  // namespace
}  // namespace airside::page
