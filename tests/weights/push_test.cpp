// `airside push` to an inbox: what the box would refuse as soon as it looks is refused at once, where its site can be
// read; where it cannot, the person is told what was not checked.

#include <gtest/gtest.h>

#include "airside/controller/instances.hpp"
#include "hal/weights/blob_file.hpp"
#include "hal/weights/signature.hpp"
#include "support/program.hpp"

namespace airside::weights {
namespace {

class Push : public ::testing::Test {
 protected:
  Push() {
    for (const char* part : {"box", "box/inbox", "box/keys", "stick"}) fs::create_directories(path(part));
    write("box/site.toml",
          "[site]\nname = \"Room 301\"\ntopology = \"5vav-5fcu-2power\"\n[inbox]\ndir = \"inbox\"\n"
          "[weights]\nkeys = \"keys\"\n");
    write("box/keys/ann.pub", hal::public_key_text(ann.open));
  }
  fs::path path(const std::string& name) const { return folder.path() / name; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  template <Topology T = FiveZone>
  std::string blob(const std::string& name, const hal::SecretKey& key, BlobHeader header = {}) const {
    auto payload = std::make_unique<typename WeightBlob<T>::Payload>();
    payload->head_states = static_cast<std::uint32_t>(RoomHead<T>::states);
    std::vector<std::byte> bytes(WeightBlob<T>::size(*payload));
    WeightBlob<T>::encode(header, *payload, bytes);
    hal::sign_blob(bytes, key, 10);
    hal::write_blob_file(path(name).string(), bytes);
    return path(name).string();
  }
  Outcome push(const std::string& file, const std::string& target, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"push", file, path(target).string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_program("airside", words, folder.path(), scratch.path());
  }
  /// Refused for `field`, in four parts, and nothing was put anywhere.
  void expect_refused(const Outcome& o, const std::string& field) const {
    EXPECT_EQ(o.code, 1) << o.out << o.err;
    const Said said = complaint_in(o.err);
    EXPECT_NE(said.place.find(field), std::string::npos) << o.err;
    EXPECT_FALSE(said.found.empty() || said.expected.empty() || said.remedy.empty()) << o.err;
    EXPECT_TRUE(fs::is_empty(path("box/inbox")) && fs::is_empty(path("stick")));
  }
  const hal::SecretKey ann = hal::make_key("ann"), mallory = hal::make_key("mallory");
  TemporaryFolder folder, scratch;
};

TEST_F(Push, RefusesWhatTheBoxBehindTheInboxWouldRefuse) {
  BlobHeader elsewhere;
  std::string_view("Room 999").copy(elsewhere.site_scope.data(), elsewhere.site_scope.size());
  const std::string small = blob<ThreeVav>("small", ann), scope = blob("scope", ann, elsewhere);
  const std::string stranger = blob("stranger", mallory);
  for (const char* target : {"box/inbox", "box/site.toml"}) {
    expect_refused(push(small, target), "topology_hash");
    expect_refused(push(scope, target), "site_scope");
    expect_refused(push(stranger, target), "key_id");
  }
  expect_refused(push(small, "stick", {"--site", path("box/site.toml").string()}), "topology_hash");
  write("box/keys/revoked", hal::hex_of(ann.open.id) + "\n");
  expect_refused(push(blob("revoked", ann), "box/inbox"), "key_id");
}

TEST_F(Push, GivesWhatFitsWithoutAWord) {
  const Outcome o = push(blob("good", ann), "box/inbox");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(o.err, "");
  EXPECT_TRUE(fs::exists(path("box/inbox/weights.blob")));
}

TEST_F(Push, SaysWhatItCouldNotCheckWhereNoSiteNamesTheInbox) {
  const Outcome o = push(blob("good", ann), "stick");
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("topology, site and key of"), std::string::npos) << o.err;
  EXPECT_NE(o.err.find("not checked"), std::string::npos) << o.err;
  EXPECT_EQ(o.out.find("not checked"), std::string::npos);
  write("box/site.toml", "[[[ broken");
  EXPECT_NE(push(blob("good", ann), "box/inbox").err.find("not checked"), std::string::npos);
}

TEST_F(Push, FollowsNoLinkOfAnotherUserInPlaceOfTheInbox) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can make another user's link";
  fs::create_directory_symlink(path("stick"), path("link"));
  ASSERT_EQ(::lchown(path("link").c_str(), 12345, 12345), 0);
  const Outcome o = push(blob("good", ann), "link");
  EXPECT_EQ(o.code, 1) << o.out;
  EXPECT_TRUE(fs::is_empty(path("stick")));
}

}  // namespace
}  // namespace airside::weights
