// Which bodies get into the inbox, which settings the page starts with, and how it ends.

#include <sys/stat.h>

#include "page_http/page_rig.hpp"

namespace airside::page {
namespace {

TEST_F(PageRig, TakesNoBlobThatNoKnownKeySigned) {
  ASSERT_TRUE(start()) << read("said.txt");
  Bytes by_stranger = plain_blob(), changed = signed_blob();
  hal::sign_blob(by_stranger, hal::make_key("mallory"), 10);
  changed[500] ^= std::byte{1};
  int address = 30;
  for (const Bytes& blob : {plain_blob(), by_stranger, changed, Bytes(300, std::byte{'x'})}) {
    const std::string from = "127.0.0." + std::to_string(++address);
    const std::string answer = ask(post(blob), from);
    EXPECT_EQ(status_of(answer), 403) << answer;
    EXPECT_EQ(status_of(ask(post(signed_blob()), from)), 429) << "and that peer waits before it may try again";
  }
  write("keys/revoked", hal::hex_of(ann.open.id) + "\n");
  EXPECT_EQ(status_of(ask(post(signed_blob()))), 403) << "revoked while it runs";
  EXPECT_TRUE(inbox_is_empty());
}

TEST_F(PageRig, TakesNoBlobForAnotherRoomAndNamesTheField) {
  ASSERT_TRUE(start()) << read("said.txt");
  BlobHeader elsewhere;
  std::string_view("Room 999").copy(elsewhere.site_scope.data(), elsewhere.site_scope.size());
  const std::string scope = ask(post(signed_blob(10, plain_blob(elsewhere))), "127.0.0.31");
  EXPECT_EQ(status_of(scope), 422) << scope;
  EXPECT_NE(scope.find("site_scope"), std::string::npos) << scope;
  const std::string shape = ask(post(signed_blob(10, plain_blob<ThreeVav>())), "127.0.0.32");
  EXPECT_EQ(status_of(shape), 422) << shape;
  EXPECT_NE(shape.find("topology_hash"), std::string::npos) << shape;
  EXPECT_TRUE(inbox_is_empty());
}

TEST_F(PageRig, ABlobThatWaitsIsReplacedByANewerOneOfItsKeyAlone) {
  ASSERT_TRUE(start()) << read("said.txt");
  EXPECT_EQ(status_of(ask(post(signed_blob(10)))), 202);
  EXPECT_EQ(status_of(ask(post(signed_blob(10)))), 409);
  EXPECT_EQ(status_of(ask(post(signed_blob(9)))), 409);
  EXPECT_EQ(status_of(ask(post(signed_blob(11)))), 202);
  const hal::SecretKey bob = hal::make_key("bob");
  write("keys/bob.pub", hal::public_key_text(bob.open));
  Bytes blob = plain_blob();
  hal::sign_blob(blob, bob, 100);
  EXPECT_EQ(status_of(ask(post(blob))), 409);
  fs::remove(folder / "inbox/page.blob");
  EXPECT_EQ(status_of(ask(post(blob))), 202) << "once the daemon has taken the other";
}

TEST_F(PageRig, SaysThatTheInboxIsNotThereAndGoesOn) {
  ASSERT_TRUE(start()) << read("said.txt");
  fs::remove(folder / "inbox");
  EXPECT_EQ(status_of(ask(post(signed_blob()))), 503);
  fs::create_directory(folder / "inbox");
  EXPECT_EQ(status_of(ask(post(signed_blob()))), 202);
}

TEST_F(PageRig, PutsNothingWhereALinkInPlaceOfTheInboxLeads) {
  ASSERT_TRUE(start()) << read("said.txt");
  fs::create_directory(folder / "elsewhere");
  fs::remove(folder / "inbox");
  fs::create_directory_symlink(folder / "elsewhere", folder / "inbox");
  const std::string answer = ask(post(signed_blob()));
  EXPECT_EQ(status_of(answer), 503) << answer;
  EXPECT_NE(answer.find("not a regular file or folder"), std::string::npos) << answer;
  EXPECT_TRUE(fs::is_empty(folder / "elsewhere"));
}

TEST_F(PageRig, OneUploadAPeerAtATime) {
  ASSERT_TRUE(start()) << read("said.txt");
  Peer first(port);
  first.send(post_head(1000) + "a");
  EXPECT_EQ(status_of(ask(get("/status.json"))), 200);
  EXPECT_EQ(status_of(ask(post(signed_blob()))), 503);
  EXPECT_EQ(status_of(ask(post(signed_blob()), "127.0.0.2")), 202);
}

TEST_F(PageRig, NoReadingChangesAFile) {
  ASSERT_TRUE(start()) << read("said.txt");
  write("state/weights.blob", "bytes");
  const auto times = [this] {
    std::string all;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      struct stat status {};
      ::stat(entry.path().c_str(), &status);
      if (entry.path().filename() == "said.txt") continue;
      all += entry.path().string() + ' ' + std::to_string(status.st_mtim.tv_sec) + '.' +
             std::to_string(status.st_mtim.tv_nsec) + '\n';
    }
    return all;
  };
  // The page's own ledger of weights is written beside the requests, once: after that nothing moves by itself.
  std::string before = times();
  for (int quiet = 0; quiet < 5; ++quiet) {
    sleep_s(0.1);
    const std::string now = times();
    if (now != before || !fs::exists(folder / "page" / "ledger.json")) quiet = 0;
    before = now;
  }
  for (const char* read : {"/status.json", "/weights.blob", "/token", "/weights", "/release", "/inbox/release"}) {
    ask(get(read));
  }
  EXPECT_EQ(times(), before);
}

TEST_F(PageRig, EndsInOrderWhenToldEvenWithPeersThatWait) {
  ASSERT_TRUE(start()) << read("said.txt");
  const std::string first = token;
  Peer idle(port), half(port);
  half.send("GET /stat");
  page->signal(SIGTERM);
  EXPECT_EQ(page->wait(5), 0);
  ASSERT_TRUE(start()) << read("said.txt");
  EXPECT_NE(token, first) << "a token lives as long as the process";
  EXPECT_EQ(token.size(), 32u);
}

TEST_F(PageRig, ListensOnANetworkOnlyWithACertificate) {
  for (const char* keys : {"listen = \"0.0.0.0\"", "listen = \"192.168.1.30\"", "listen = \"::\""}) {
    EXPECT_FALSE(start(keys)) << keys;
    EXPECT_EQ(page->wait(1), 1);
  }
  EXPECT_NE(read("said.txt").find("found the text \"192.168.1.30\"; expected a loopback address"), std::string::npos)
      << read("said.txt");
  EXPECT_FALSE(start("listen = \"0.0.0.0\"\ntls_cert = \"box.pem\"")) << "a certificate without its key";
  EXPECT_FALSE(start("listen = \"localhost\"")) << "names are not looked up";
  EXPECT_FALSE(start("names = [\"Box\"]"));
  EXPECT_FALSE(start("tls_cert = \"none.pem\"\ntls_key = \"none.key\""));
  ASSERT_TRUE(start("listen = \"127.0.0.1\"")) << read("said.txt");
  const std::string taken = "[page]\nport = " + std::to_string(port);
  write("second.toml", "[site]\nname = \"R\"\ntopology = \"5vav-5fcu-2power\"\n" + taken + "\n");
  Child second({std::string(AIRSIDE_BIN_DIR) + "/airside-page", "--site", folder / "second.toml"},
               folder / "second.txt");
  EXPECT_EQ(second.wait(20), 1);
  EXPECT_NE(second.said().find("Address already in use"), std::string::npos) << second.said();
}

}  // namespace
}  // namespace airside::page
