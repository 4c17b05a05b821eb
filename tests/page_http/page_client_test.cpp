// `airside push` and `airside pull` against a real airside-page, by HTTP and by HTTPS with a certificate of the box's
// own.

#include "page_http/page_rig.hpp"

namespace airside::page {
namespace {

class PageClient : public PageRig {
 protected:
  int airside(std::vector<std::string> words) {
    words.insert(words.begin(), std::string(AIRSIDE_BIN_DIR) + "/airside");
    fs::remove(folder / "client.txt");
    return Child(words, folder / "client.txt").wait(60).value_or(-1);
  }
  std::string said() const { return read("client.txt"); }
  bool says(const std::string& words) const { return said().find(words) != std::string::npos; }
  std::string address() const { return "http://" + host(); }
  std::string path(const std::string& name) const { return folder / name; }
  void write_blob(const std::string& name, const Bytes& blob) const {
    write(name, std::string(reinterpret_cast<const char*>(blob.data()), blob.size()));
  }
  /// A certificate of its own for 127.0.0.1, and its key.
  bool make_certificate(const std::string& name) {
    Child openssl({"/usr/bin/openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
                   "-nodes", "-days", "3650", "-subj", "/CN=box", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout",
                   path(name + ".key"), "-out", path(name + ".pem")},
                  folder / "openssl.txt");
    const bool made = openssl.wait(30) == 0;
    fs::permissions(folder / (name + ".key"), fs::perms::owner_read | fs::perms::group_read);
    return made;
  }
};

TEST_F(PageClient, PushesASignedBlobIntoTheInboxBehindThePage) {
  ASSERT_TRUE(start()) << read("said.txt");
  const Bytes blob = signed_blob();
  write_blob("room.blob", blob);
  ASSERT_EQ(airside({"push", path("room.blob"), address() + "/", "--json"}), 0) << said();
  EXPECT_TRUE(says("\"bytes\":" + std::to_string(blob.size()))) << said();
  EXPECT_EQ(read("inbox/page.blob"), read("room.blob"));
  EXPECT_EQ(airside({"push", path("room.blob"), host()}), 1) << "the same once more, by the host alone";
  EXPECT_TRUE(says("found 409: other weights wait") && says("or sign this one later")) << said();
}

TEST_F(PageClient, PushesAndPullsWithAKeyWhereThePageHasPasswords) {
  ASSERT_TRUE(start()) << read("said.txt");
  const auto on_the_box = [&](const std::string& command) {
    return Child({"/bin/sh", "-c",
                  command + " " + std::string(AIRSIDE_BIN_DIR) + "/airside-page --site " + path("site.toml") + " " +
                      (command.empty() ? "--new-key" : "--set-password") +
                      (command.empty() ? " installer >" + path("key") : " viewer")},
                 folder / "client.txt")
        .wait(60)
        .value_or(-1);
  };
  EXPECT_EQ(on_the_box("echo too short |"), 1);
  EXPECT_TRUE(says("password: found 9 bytes; expected 10 to 512 bytes on one line")) << said();
  EXPECT_FALSE(fs::exists(folder / "page/access")) << "nothing half-written";
  ASSERT_EQ(on_the_box("echo only for this house |"), 0) << said();
  ASSERT_EQ(on_the_box(""), 0) << said();
  EXPECT_EQ(read("key").size(), 65u);
  write("state/weights.blob", "not read before the key is right");
  write_blob("room.blob", signed_blob());
  EXPECT_EQ(airside({"push", path("room.blob"), address()}), 1);
  EXPECT_TRUE(says("401: sign in as installer first") && says("--access")) << said();
  write("wrong", std::string(64, '0') + "\n");
  EXPECT_EQ(airside({"push", path("room.blob"), address(), "--access", path("wrong")}), 1);
  EXPECT_TRUE(says("401")) << said();
  EXPECT_EQ(airside({"push", path("room.blob"), address(), "--access", path("room.blob")}), 1);
  EXPECT_TRUE(says("no key of a box's page") && says("64 hex digits")) << said();
  EXPECT_TRUE(inbox_is_empty());
  ASSERT_EQ(airside({"push", path("room.blob"), address(), "--access", path("key")}), 0) << said();
  EXPECT_EQ(read("inbox/page.blob"), read("room.blob"));
  EXPECT_EQ(airside({"pull", address(), "-o", path("out.blob")}), 1);
  EXPECT_TRUE(says("401: sign in as viewer first")) << said();
  EXPECT_EQ(airside({"pull", address(), "-o", path("out.blob"), "--access", path("key")}), 1);
  EXPECT_FALSE(says("401")) << "it came as far as what was pulled: " << said();
}

TEST_F(PageClient, ReleasesForATimeByAFile) {
  ASSERT_EQ(airside({"release", path("inbox"), "--hours", "4"}), 0) << said();
  EXPECT_EQ(read("inbox/release"), "4");
  EXPECT_TRUE(says("after 4 h")) << said();
  ASSERT_EQ(airside({"release", path("inbox")}), 0) << said();
  EXPECT_EQ(read("inbox/release"), "");
  for (const char* wrong : {"0", "169", "1.5", "soon"}) {
    EXPECT_EQ(airside({"release", path("inbox"), "--hours", wrong}), 2) << wrong;
    EXPECT_TRUE(says("--hours")) << said();
  }
}

TEST_F(PageClient, WhoMaySeeTheStateSeesThatAnOrderWaits) {
  ASSERT_TRUE(start()) << read("said.txt");
  const auto waits_for = [this](const std::string& wish) {
    return body_of(ask(get("/session.json"))).find("\"waiting\":\"" + wish + "\"") != std::string::npos;
  };
  EXPECT_TRUE(waits_for(""));
  ASSERT_EQ(airside({"release", path("inbox")}), 0) << said();
  EXPECT_TRUE(waits_for("release"));
  ASSERT_EQ(airside({"hand-back", path("inbox")}), 0) << said();
  EXPECT_TRUE(waits_for("hand-back")) << "the later wish";
}

TEST_F(PageClient, SaysWhatTheBoxHadAgainstABlob) {
  ASSERT_TRUE(start()) << read("said.txt");
  Bytes stranger = plain_blob();
  hal::sign_blob(stranger, hal::make_key("mallory"), 10);
  write_blob("stranger.blob", stranger);
  EXPECT_EQ(airside({"push", path("stranger.blob"), address()}), 1);
  EXPECT_TRUE(says("/weights: found 403: blob signature (key_id)") && says("keys folder")) << said();
  sleep_s(2.1);  // after a refusal that peer waits
  write_blob("small.blob", signed_blob(10, plain_blob<ThreeVav>()));
  EXPECT_EQ(airside({"push", path("small.blob"), address()}), 1);
  EXPECT_TRUE(says("found 422: blob topology (topology_hash)")) << said();
  write_blob("unsigned.blob", plain_blob());
  EXPECT_EQ(airside({"push", path("unsigned.blob"), address()}), 1);
  EXPECT_TRUE(says("an unsigned blob")) << said();
  EXPECT_TRUE(inbox_is_empty());
}

TEST_F(PageClient, SaysWhenNobodyOrSomebodyElseAnswers) {
  ASSERT_TRUE(start()) << read("said.txt");
  write_blob("room.blob", signed_blob());
  const std::string there = address();
  EXPECT_EQ(airside({"push", path("room.blob"), there + "/weights"}), 1);
  EXPECT_TRUE(says("no address of a box")) << said();
  EXPECT_EQ(airside({"pull", "https://" + host(), "-o", path("out.blob")}), 1) << "no TLS there";
  EXPECT_TRUE(says("no answer")) << said();
  page.reset();
  EXPECT_EQ(airside({"push", path("room.blob"), there}), 1);
  EXPECT_TRUE(says(there + ": found no answer") && says("start airside-page")) << said();
  EXPECT_EQ(airside({"pull", there, "-o", path("out.blob"), "--ca", path("nowhere.pem")}), 1);
  EXPECT_TRUE(says("--ca")) << said();
  EXPECT_FALSE(fs::exists(folder / "out.blob"));
}

TEST_F(PageClient, PullsWhatIsABlobAndNothingElse) {
  ASSERT_TRUE(start()) << read("said.txt");
  EXPECT_EQ(airside({"pull", address(), "-o", path("out.blob")}), 1);
  EXPECT_TRUE(says("found 404: no weights yet")) << said();
  write_blob("state/weights.blob", plain_blob());
  ASSERT_EQ(airside({"pull", address(), "-o", path("out.blob")}), 0) << said();
  EXPECT_EQ(read("out.blob"), read("state/weights.blob"));
  for (const char* source : {"state", "state/weights.blob", "site.toml"}) {
    ASSERT_EQ(airside({"pull", path(source), "-o", path("again.blob"), "--json"}), 0) << said();
    EXPECT_TRUE(says("\"topology\":\"5vav-5fcu-2power\"") && says("\"key_id\":\"unsigned\"")) << said();
    EXPECT_EQ(read("again.blob"), read("out.blob"));
    fs::remove(folder / "again.blob");
  }
  Bytes damaged = plain_blob();
  damaged[1000] ^= std::byte{1};
  write_blob("state/weights.blob", damaged);
  EXPECT_EQ(airside({"pull", address(), "-o", path("again.blob")}), 1);
  EXPECT_TRUE(says("digest")) << said();
  write("state/weights.blob", "no blob at all");
  EXPECT_EQ(airside({"pull", address(), "-o", path("again.blob")}), 1);
  write("state/weights.blob", std::string(5u << 20, 'x'));
  EXPECT_EQ(airside({"pull", address(), "-o", path("again.blob")}), 1);
  EXPECT_FALSE(fs::exists(folder / "again.blob"));
  EXPECT_EQ(airside({"pull", path("inbox"), "-o", path("again.blob")}), 1);
  EXPECT_TRUE(says("no such file")) << said();
}

TEST_F(PageClient, TrustsTheBoxsOwnCertificateAndNoOther) {
  ASSERT_TRUE(make_certificate("box") && make_certificate("other")) << read("openssl.txt");
  ASSERT_TRUE(start("listen = \"0.0.0.0\"\ntls_cert = \"box.pem\"\ntls_key = \"box.key\"")) << read("said.txt");
  write_blob("room.blob", signed_blob());
  write_blob("state/weights.blob", plain_blob());
  const std::string box = "https://" + host();
  ASSERT_EQ(airside({"push", path("room.blob"), box, "--ca", path("box.pem")}), 0) << said();
  EXPECT_EQ(read("inbox/page.blob"), read("room.blob"));
  ASSERT_EQ(airside({"pull", box, "-o", path("out.blob"), "--ca", path("box.pem")}), 0) << said();
  EXPECT_EQ(read("out.blob"), read("state/weights.blob"));
  EXPECT_EQ(airside({"pull", box, "-o", path("no.blob")}), 1);
  EXPECT_TRUE(says("a certificate that cannot be trusted") && says("--ca FILE")) << said();
  EXPECT_EQ(airside({"pull", box, "-o", path("no.blob"), "--ca", path("other.pem")}), 1);
  EXPECT_TRUE(says("a certificate that cannot be trusted")) << said();
  EXPECT_EQ(
      airside({"pull", "https://127.0.0.2:" + std::to_string(port), "-o", path("no.blob"), "--ca", path("box.pem")}), 1)
      << "a name that is not in it";
  EXPECT_EQ(airside({"pull", address(), "-o", path("no.blob")}), 1) << "plain HTTP to it";
  EXPECT_FALSE(fs::exists(folder / "no.blob"));
}

TEST_F(PageClient, SpeaksOnlySuitesThatAuthenticateWhatTheyEncrypt) {
  ASSERT_TRUE(make_certificate("box")) << read("openssl.txt");
  ASSERT_TRUE(start("tls_cert = \"box.pem\"\ntls_key = \"box.key\"")) << read("said.txt");
  const auto agrees = [this](const std::string& offer) {
    fs::remove(folder / "client.txt");
    Child client({"/bin/sh", "-c", "exec openssl s_client -connect " + host() + ' ' + offer + " </dev/null"},
                 folder / "client.txt");
    return client.wait(20) == 0 && client.said().find("Cipher is ") != std::string::npos &&
           client.said().find("Cipher is (NONE)") == std::string::npos;
  };
  EXPECT_TRUE(agrees("-tls1_2 -cipher ECDHE-ECDSA-AES128-GCM-SHA256")) << read("client.txt");
  EXPECT_TRUE(agrees("-tls1_2 -cipher ECDHE-ECDSA-CHACHA20-POLY1305")) << read("client.txt");
  EXPECT_TRUE(agrees("-tls1_3")) << read("client.txt");
  for (const char* cbc :
       {"ECDHE-ECDSA-AES128-SHA256", "ECDHE-ECDSA-AES256-SHA384", "ECDHE-ECDSA-AES128-SHA", "ECDHE-ECDSA-AES256-SHA"}) {
    EXPECT_FALSE(agrees(std::string("-tls1_2 -cipher ") + cbc + ":@SECLEVEL=0")) << cbc << read("client.txt");
  }
  EXPECT_FALSE(agrees("-tls1_1 -cipher ALL:@SECLEVEL=0")) << read("client.txt");
}

TEST_F(PageClient, StartsWithNoKeyThatEverybodyMayRead) {
  ASSERT_TRUE(make_certificate("box")) << read("openssl.txt");
  fs::permissions(folder / "box.key", fs::perms::others_read, fs::perm_options::add);
  EXPECT_FALSE(start("tls_cert = \"box.pem\"\ntls_key = \"box.key\""));
  EXPECT_NE(read("said.txt").find("permissions"), std::string::npos) << read("said.txt");
  fs::permissions(folder / "box.key", fs::perms::others_read, fs::perm_options::remove);
  write("box.pem", "no certificate");
  EXPECT_FALSE(start("tls_cert = \"box.pem\"\ntls_key = \"box.key\""));
}

}  // namespace
}  // namespace airside::page
