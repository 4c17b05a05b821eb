// Rows 54 to 58 of the fault matrix over real sockets: floods, slow peers, long bodies, paths, markup, other people's
// web pages.

#include "page_http/page_rig.hpp"
#include "support/sanitized.hpp"

namespace airside::page {
namespace {

/// What must hold of every answer.
void expect_guarded(const std::string& answer) {
  for (const char* line : {"X-Content-Type-Options: nosniff", "Content-Security-Policy: default-src 'none'",
                           "Cache-Control: no-store", "Connection: close", "X-Frame-Options: DENY"}) {
    EXPECT_NE(answer.find(line), std::string::npos) << line << " in\n" << answer;
  }
  EXPECT_EQ(answer.find("Access-Control"), std::string::npos) << answer;
}

TEST_F(PageRig, Row54SlowPeersAreCutByADeadlineInAllAndNeverHoldMoreThanTheirShare) {
  ASSERT_TRUE(start()) << read("said.txt");
  const std::size_t idle = descriptors();
  const double began = now_s();
  std::vector<std::unique_ptr<Peer>> heads;
  // One address has its share, and nobody needs a place that another holds.
  for (const char* from : {"127.0.0.2", "127.0.0.2", "127.0.0.2", "127.0.0.2", "127.0.0.3", "127.0.0.3", "127.0.0.3",
                           "127.0.0.4", "127.0.0.4", "127.0.0.4"}) {
    heads.push_back(std::make_unique<Peer>(port, from));
  }
  Peer fifth(port, "127.0.0.2");
  EXPECT_EQ(fifth.receive(2), "") << "a peer's fifth socket is closed without an answer";
  EXPECT_TRUE(fifth.closed());
  Peer body(port, "127.0.0.5");
  ASSERT_TRUE(body.send(post_head(100000)));
  const double body_began = now_s();
  EXPECT_EQ(status_of(ask(get("/status.json"), "127.0.0.6")), 200) << "others are served meanwhile";
  EXPECT_LE(descriptors(), idle + 16);
  double first_closed = 0, last_closed = 0;
  std::size_t open = heads.size(), sent = 0;
  const std::string line = "GET /status.json HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow: " + std::string(200, 'a');
  while (now_s() < began + 9 && open > 0) {
    for (auto& peer : heads) {
      if (!peer) continue;
      peer->send(line.substr(sent, 1));
      if (!peer->closed()) continue;
      peer.reset();
      --open;
      last_closed = now_s() - began;
      if (first_closed == 0) first_closed = last_closed;
    }
    ++sent;
    body.send("x");
    sleep_s(0.05);
  }
  EXPECT_EQ(open, 0u);
  EXPECT_GT(sent, 10u) << "they were busy all the time";
  EXPECT_GT(first_closed, 4.5);
  EXPECT_LT(last_closed, 7.0) << "5 s, and what a busy machine adds";
  while (!body.closed() && now_s() < body_began + 14) {
    body.send("x");
    sleep_s(0.05);
  }
  EXPECT_GT(now_s() - body_began, 9.5);
  EXPECT_LT(now_s() - body_began, 12.5);
  EXPECT_LE(descriptors(), idle);
  EXPECT_TRUE(inbox_is_empty());
  EXPECT_NE(read("said.txt").find("upload from 127.0.0.5 broke off"), std::string::npos) << read("said.txt");
}

TEST_F(PageRig, Row54AFloodLeavesDescriptorsAndMemoryAsTheyWere) {
  ASSERT_TRUE(start()) << read("said.txt");
  int served = 0;
  const auto flood = [this, &served](int rounds) {
    std::size_t most = 0;
    for (int round = 0; round < rounds; ++round) {
      std::vector<std::unique_ptr<Peer>> peers;
      for (int i = 0; i < 40; ++i) {
        peers.push_back(std::make_unique<Peer>(port, "127.0.0." + std::to_string(2 + i % 10)));
        peers.back()->send(i % 2 == 0 ? get("/status.json") : std::string("\x16\x03\x01 no HTTP\r\n\r\n"));
      }
      most = std::max(most, descriptors());
      for (auto& peer : peers) served += status_of(peer->receive()) == 200;
    }
    return most;
  };
  const std::size_t idle = descriptors();
  flood(5);
  const long before = memory_kb();
  // Besides the 16 that are held: one that waits for a place, one that is being turned away (twice while it is handed
  // over), and the file that is being served.
  EXPECT_LE(flood(25), idle + 16 + 4);
  EXPECT_GT(served, 30 * 10);
  EXPECT_EQ(status_of(ask(get("/status.json"), "127.0.0.20")), 200);
  const double until = now_s() + 8;
  while (descriptors() > idle && now_s() < until) sleep_s(0.02);
  EXPECT_LE(descriptors(), idle);
  if (!sanitized) {
    EXPECT_LE(memory_kb(), before + 256);
  }
}

TEST_F(PageRig, Row54WithoutPeersInHasteAreAllServed) {
  ASSERT_TRUE(start()) << read("said.txt");
  for (int i = 0; i < 40; ++i) ASSERT_EQ(status_of(ask(get("/status.json"))), 200) << i;
  Peer slow(port);
  const std::string request = get("/status.json");
  for (std::size_t i = 0; i < request.size(); i += 8) {
    ASSERT_TRUE(slow.send(request.substr(i, 8)));
    sleep_s(0.1);
  }
  EXPECT_EQ(status_of(slow.receive()), 200);
}

TEST_F(PageRig, Row55ALongBodyIsRefusedBeforeAnyOfItIsRead) {
  ASSERT_TRUE(start()) << read("said.txt");
  for (const std::size_t bytes : {WeightBlob<FiveZone>::max_bytes + 1, std::size_t{1} << 40}) {
    const std::string answer = ask(post_head(bytes));  // no byte of the body is ever sent
    EXPECT_EQ(status_of(answer), 413) << answer;
    expect_guarded(answer);
  }
  const std::string chunked = ask("POST /weights HTTP/1.1\r\nHost: " + host() + "\r\nX-Airside-Token: " + token +
                                  "\r\nTransfer-Encoding: chunked\r\n\r\n");
  EXPECT_EQ(status_of(chunked), 411) << chunked;
  EXPECT_EQ(status_of(ask("GET /status.json HTTP/1.1\r\nHost: " + host() + "\r\nContent-Length: 9\r\n\r\n")), 400);
  const std::string long_head = "GET /status.json HTTP/1.1\r\nHost: " + host() + "\r\nX: " + std::string(20000, 'x');
  EXPECT_EQ(status_of(ask(long_head)) / 100, 4);
  EXPECT_TRUE(inbox_is_empty());
}

TEST_F(PageRig, Row55ABodyThatEndsEarlyOrGoesOnIsNotTaken) {
  ASSERT_TRUE(start()) << read("said.txt");
  const Bytes blob = signed_blob();
  {
    Peer peer(port);
    peer.send(post_head(blob.size()));
    peer.send(Bytes(blob.begin(), blob.end() - 1));
    peer.end();
    EXPECT_EQ(peer.receive(), "");
    EXPECT_TRUE(peer.closed()) << "not only when its time is over";
  }
  EXPECT_TRUE(inbox_is_empty());
  Bytes longer = blob;
  longer.resize(blob.size() + 1000);
  Peer peer(port);
  peer.send(post_head(blob.size()));
  peer.send(longer);
  const double until = now_s() + 5;
  while (!fs::exists(folder / "inbox/page.blob") && now_s() < until) sleep_s(0.01);
  EXPECT_EQ(read("inbox/page.blob").size(), blob.size()) << "what was announced is taken, what follows is nobody's";
}

TEST_F(PageRig, Row55WithoutTheLongestBlobOfTheRoomIsTaken) {
  ASSERT_TRUE(start()) << read("said.txt");
  const Bytes blob = signed_blob();
  ASSERT_EQ(blob.size(), WeightBlob<FiveZone>::max_bytes);
  const std::string answer = ask(post(blob));
  EXPECT_EQ(status_of(answer), 202) << answer;
  expect_guarded(answer);
  EXPECT_EQ(read("inbox/page.blob"), std::string(reinterpret_cast<const char*>(blob.data()), blob.size()));
  EXPECT_NE(read("said.txt")
                .find("upload from 127.0.0.1 accepted: " + std::to_string(blob.size()) + " bytes, key " +
                      hal::hex_of(ann.open.id) + " (ann), counter 10"),
            std::string::npos)
      << read("said.txt");
}

TEST_F(PageRig, Row56NoPathLeadsToAFile) {
  ASSERT_TRUE(start()) << read("said.txt");
  write("secret.txt", "the secret");
  write("state/row.a", "the secret");
  for (const char* path :
       {"/../secret.txt", "/state/row.a", "/row.a", "/../../../../etc/passwd", "/%2e%2e/secret.txt", "/..%2fsecret.txt",
        "/status.json/../row.a", "/status.json%00", "/%73tatus.json", "//etc/passwd", "/./status.json",
        "/weights.blob.new", "/\\..\\secret.txt", "/status.json;x", "/web/app.js"}) {
    const std::string answer = ask(get(path));
    EXPECT_EQ(status_of(answer), 404) << path << '\n' << answer;
    EXPECT_EQ(answer.find("secret"), std::string::npos) << path;
    expect_guarded(answer);
  }
  fs::remove(folder / "state/status.json");
  fs::create_symlink(folder / "secret.txt", folder / "state/status.json");
  fs::create_symlink(folder / "secret.txt", folder / "state/weights.blob");
  EXPECT_EQ(status_of(ask(get("/status.json"))), 503) << "no link is followed";
  EXPECT_EQ(status_of(ask(get("/weights.blob"))), 404);
}

TEST_F(PageRig, Row56WithoutTheThreeReadablePathsAnswer) {
  ASSERT_TRUE(start()) << read("said.txt");
  write("state/weights.blob", "bytes of weights");
  for (const char* path : {"/status.json", "/status.json?now", "/weights.blob", "/token"}) {
    const std::string answer = ask(get(path));
    EXPECT_EQ(status_of(answer), 200) << path << '\n' << answer;
    expect_guarded(answer);
  }
  EXPECT_EQ(body_of(ask(get("/weights.blob"))), "bytes of weights");
  const std::string head = ask("HEAD /weights.blob HTTP/1.1\r\nHost: " + host() + "\r\n\r\n");
  EXPECT_EQ(status_of(head), 200);
  EXPECT_EQ(body_of(head), "");
}

TEST_F(PageRig, Row57MarkupInANameNeitherStartsNorIsServed) {
  for (const char* name : {"<script>alert(1)</script>", "Room & Co", "a\\u003cb", "tab\\there"}) {
    write_site("", name);
    Child refused({std::string(AIRSIDE_BIN_DIR) + "/airside-page", "--site", folder / "site.toml", "--port", "0"},
                  folder / "refused.txt");
    EXPECT_EQ(refused.wait(20), 1) << name;
  }
  EXPECT_NE(read("refused.txt").find("site.name"), std::string::npos) << read("refused.txt");
  ASSERT_TRUE(start()) << read("said.txt");
  write("state/status.json", R"({"site":"<script>alert(1)</script>","why":"a & b"})");
  const std::string answer = ask(get("/status.json"));
  EXPECT_EQ(body_of(answer), R"({"site":"\u003cscript\u003ealert(1)\u003c/script\u003e","why":"a \u0026 b"})");
  EXPECT_NE(answer.find("Content-Type: application/json"), std::string::npos);
  expect_guarded(answer);
  const std::string echo = ask("GET /<script>alert(1)</script> HTTP/1.1\r\nHost: " + host() + "\r\n\r\n");
  EXPECT_EQ(echo.find("<script"), std::string::npos) << echo;
}

TEST_F(PageRig, Row57WithoutAPlainStatusIsServedByteForByte) {
  ASSERT_TRUE(start()) << read("said.txt");
  EXPECT_EQ(body_of(ask(get("/status.json"))), read("state/status.json"));
  const std::string umlauts = "{\"site\":\"B\xc3\xbcro (3) - a.b_c/d\",\"room_temp_degc\":[25.25,null]}\n";
  write("state/status.json", umlauts);
  EXPECT_EQ(body_of(ask(get("/status.json"))), umlauts);
}

TEST_F(PageRig, Row58OtherPeoplesWebPagesChangeNothing) {
  ASSERT_TRUE(start()) << read("said.txt");
  const Bytes blob = signed_blob();
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string request = post(blob);
    return request.replace(request.find(from), from.size(), to);
  };
  const std::string own_host = "Host: " + host();
  EXPECT_EQ(status_of(ask(replaced(own_host, "Host: evil.example"))), 421) << "a name that was pointed at us";
  EXPECT_EQ(status_of(ask("GET /status.json HTTP/1.1\r\nHost: evil.example:" + std::to_string(port) + "\r\n\r\n")),
            421);
  EXPECT_EQ(status_of(ask("GET /token HTTP/1.1\r\nHost: evil.example\r\n\r\n")), 421) << "nor is the token told";
  EXPECT_EQ(status_of(ask(post(blob, "Origin: http://evil.example\r\n"))), 403);
  EXPECT_EQ(status_of(ask(post(blob, "Origin: null\r\n"))), 403);
  EXPECT_EQ(status_of(ask(replaced("X-Airside-Token: " + token, "Content-Type: text/plain"))), 403)
      << "a form of another page has no line of its own";
  EXPECT_EQ(status_of(ask(replaced(token, std::string(32, '0')))), 403);
  const std::string preflight = ask("OPTIONS /weights HTTP/1.1\r\nHost: " + host() +
                                    "\r\nOrigin: http://evil.example\r\nAccess-Control-Request-Method: POST\r\n"
                                    "Access-Control-Request-Headers: x-airside-token\r\n\r\n");
  EXPECT_EQ(status_of(preflight), 405);
  expect_guarded(preflight);
  for (const char* method : {"GET", "HEAD", "PUT", "DELETE"}) {
    EXPECT_EQ(status_of(ask(std::string(method) + " /weights HTTP/1.1\r\nHost: " + host() + "\r\n\r\n")), 405)
        << method;
  }
  EXPECT_TRUE(inbox_is_empty());
  EXPECT_NE(read("said.txt").find("upload from 127.0.0.1 refused: 421"), std::string::npos) << read("said.txt");
  EXPECT_NE(read("said.txt").find("upload from 127.0.0.1 refused: 403"), std::string::npos);
}

TEST_F(PageRig, Row58WithoutTheBoxsOwnPageAndNamedHostsAreServed) {
  ASSERT_TRUE(start("names = [\"ahu-3.example.org\"]")) << read("said.txt");
  for (const std::string& own : {host(), "localhost:" + std::to_string(port), std::string("ahu-3.example.org")}) {
    EXPECT_EQ(status_of(ask("GET /status.json HTTP/1.1\r\nHost: " + own + "\r\n\r\n")), 200) << own;
  }
  EXPECT_EQ(status_of(ask(post(signed_blob(), "Origin: http://" + host() + "\r\n"))), 202);
}

}  // namespace
}  // namespace airside::page
