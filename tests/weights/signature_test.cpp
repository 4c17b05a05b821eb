// A signed blob is taken as it was signed, or refused with the field's name: whatever bit is flipped, whatever is cut
// off, whoever signed it.

#include "hal/weights/signature.hpp"

#include <gtest/gtest.h>
#include <sodium.h>
#include <sys/stat.h>

#include <cstdlib>
#include <cstring>
#include <fstream>

#include "airside/splitmix64.hpp"
#include "hal/text/input_error.hpp"
#include "support/blob_maker.hpp"
#include "support/controller_rig.hpp"
#include "support/test_folder.hpp"

namespace airside::weights {
namespace {

class Signed : public ::testing::Test {
 protected:
  Signed() { ring.add(key.open); }

  ControllerRig rig;
  hal::SecretKey key = hal::make_key("Ann");
  hal::KeyRing ring;
  Bytes blob = signed_by(blob_of<FiveZone>(*rig.controller), key, 7);
};

TEST_F(Signed, Row44Row48WithoutItIsTakenWithItsKeyAndCounter) {
  const auto found = hal::verify_blob(blob, ring);
  ASSERT_TRUE(found) << found.error().field;
  EXPECT_EQ((*found)->name.view(), "Ann");
  auto payload = std::make_unique<WeightBlob<FiveZone>::Payload>();
  const auto header = WeightBlob<FiveZone>::decode(blob, {}, *payload);
  ASSERT_TRUE(header) << header.error().field;
  EXPECT_EQ(header->security_counter, 7u);
  EXPECT_EQ(header->key_id, key.open.id);
}

/// Whether the blob with one bit flipped is taken.
bool taken_with_flip(Bytes& blob, std::size_t bit, const hal::KeyRing& ring) {
  const auto mask = static_cast<std::byte>(1U << bit % 8);
  blob[bit / 8] ^= mask;
  const bool taken = hal::verify_blob(blob, ring).has_value();
  blob[bit / 8] ^= mask;
  return taken;
}

TEST_F(Signed, NoFlippedBitIsTaken) {
  const bool every = std::getenv("AIRSIDE_EVERY_BIT") != nullptr;
  const std::size_t bits = 8 * blob.size(), header = 8 * sizeof(BlobHeader), signature = 8 * blob_signature_bytes;
  std::size_t tried = 0, taken = 0;
  SplitMix64 draw(11);
  for (std::size_t bit = 0; bit < bits;) {
    taken += taken_with_flip(blob, bit, ring);
    ++tried;
    const bool sampled = !every && bit >= header && bit < bits - signature;
    bit += sampled ? std::min<std::size_t>(1 + draw.below(3000), bits - signature - bit) : 1;
  }
  EXPECT_EQ(taken, 0u);
  EXPECT_TRUE(hal::verify_blob(blob, ring)) << "and all were put back";
  std::printf("%zu flipped bits of %zu tried, none taken\n", tried, bits);
}

TEST_F(Signed, Row44NoOtherLengthIsTaken) {
  std::size_t tried = 0;
  for (std::size_t length = 0; length < blob.size(); ++length) {
    const auto found = hal::verify_blob(std::span(blob).first(length), ring);
    ASSERT_FALSE(found) << length;
    EXPECT_EQ(found.error().fault, Fault::blob_truncated) << length;
    ++tried;
  }
  for (std::size_t more = 1; more < 70; ++more) {
    Bytes longer = blob;
    longer.resize(blob.size() + more);
    EXPECT_FALSE(hal::verify_blob(longer, ring)) << more;
  }
  std::printf("%zu shorter lengths tried\n", tried);
}

TEST_F(Signed, Row48AnUnknownAndARevokedKeyAreRefused) {
  const hal::SecretKey stranger = hal::make_key("nobody");
  const auto unknown = hal::verify_blob(signed_by(blob, stranger, 9), ring);
  ASSERT_FALSE(unknown);
  EXPECT_STREQ(unknown.error().field, "key_id");
  hal::KeyRing revoking;
  hal::PublicKey open = key.open;
  open.revoked = true;
  revoking.add(open);
  EXPECT_FALSE(hal::verify_blob(blob, revoking));
}

TEST_F(Signed, AStrangersSignatureUnderAKnownKeysNameIsRefused) {
  Bytes forged = signed_by(blob, hal::make_key("nobody"), 9);
  BlobHeader header;
  std::memcpy(&header, forged.data(), sizeof header);
  header.key_id = key.open.id;
  std::memcpy(forged.data(), &header, sizeof header);
  const auto found = hal::verify_blob(forged, ring);
  ASSERT_FALSE(found);
  EXPECT_STREQ(found.error().field, "signature");
}

TEST_F(Signed, AnUnsignedBlobIsRefused) {
  const auto found = hal::verify_blob(blob_of<FiveZone>(*rig.controller), ring);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().fault, Fault::blob_signature);
}

TEST_F(Signed, ItsSignatureIsOverItsDomainToo) {
  // The same bytes signed by the same key without the domain, as another program might be made to do.
  crypto_sign_state state;
  crypto_sign_init(&state);
  crypto_sign_update(&state, reinterpret_cast<const unsigned char*>(blob.data()), blob.size() - blob_signature_bytes);
  std::array<unsigned char, crypto_sign_BYTES> signature{};
  crypto_sign_final_create(&state, signature.data(), nullptr, key.bytes.data());
  std::memcpy(blob.data() + blob.size() - signature.size(), signature.data(), signature.size());
  const auto found = hal::verify_blob(blob, ring);
  ASSERT_FALSE(found);
  EXPECT_STREQ(found.error().field, "signature");
}

TEST_F(Signed, AHeaderIsSoundWhereTheBytesAreThoseItWasMadeWith) {
  const auto complaint = [this](std::size_t bytes) {
    try {
      hal::sound_header(std::span(blob).first(bytes), "a.blob");
    } catch (const hal::InputError& e) {
      return e.place();
    }
    return std::string("none");
  };
  EXPECT_EQ(hal::sound_header(blob, "a.blob").security_counter, 7u);
  EXPECT_EQ(complaint(blob.size() - 1), "a.blob: payload_bytes");
  EXPECT_EQ(complaint(100), "a.blob: header");
  blob[5000] ^= std::byte{1};
  EXPECT_EQ(complaint(blob.size()), "a.blob: digest");
}

TEST_F(Signed, OnlyAWholeBlobCanBeSigned) {
  Bytes other = blob;
  other[0] = std::byte{'x'};
  Bytes longer = blob;
  longer.push_back(std::byte{});
  for (const Bytes& bytes :
       {other, longer, Bytes(blob.begin(), blob.begin() + 250), Bytes(blob.begin(), blob.end() - 1)}) {
    EXPECT_THROW(signed_by(bytes, key, 8), hal::InputError) << bytes.size();
    EXPECT_FALSE(hal::verify_blob(bytes, ring));
  }
}

class KeyFiles : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text, mode_t mode = 0600) {
    const std::string path = (folder.file(name)).string();
    std::ofstream(path) << text;
    ::chmod(path.c_str(), mode);
    return path;
  }
  static std::string complaint(const std::function<void()>& act) {
    try {
      act();
    } catch (const hal::InputError& e) {
      return e.what();
    }
    return "";
  }

  hal::TestFolder folder{"keys"};
  hal::SecretKey key = hal::make_key("Ann Other");
};

TEST_F(KeyFiles, ReadBackAsTheyWereWritten) {
  const auto open = hal::read_public_key(write("a.pub", hal::public_key_text(key.open)));
  EXPECT_EQ(open.bytes, key.open.bytes);
  EXPECT_EQ(open.id, key.open.id);
  EXPECT_EQ(open.name.view(), "Ann Other");
  const auto secret = hal::read_secret_key(write("a.key", hal::secret_key_text(key)));
  EXPECT_EQ(secret.bytes, key.bytes);
  EXPECT_EQ(secret.open.id, key.open.id);
}

TEST_F(KeyFiles, AreRefusedWithTheReason) {
  const std::string open = hal::public_key_text(key.open);
  EXPECT_NE(complaint([&] {
              hal::read_public_key(write("b.pub", hal::secret_key_text(key)));
            }).find("the word airside-public-key-1"),
            std::string::npos);
  EXPECT_NE(complaint([&] { hal::read_public_key(write("c.pub", open.substr(0, 60))); }).find("64 hex digits"),
            std::string::npos);
  std::string letter = open;
  letter[30] = 'g';
  EXPECT_NE(complaint([&] { hal::read_public_key(write("d.pub", letter)); }).find("64 hex digits"), std::string::npos);
  EXPECT_NE(complaint([&] { hal::read_secret_key(write("e.key", hal::secret_key_text(key), 0644)); }).find("chmod 600"),
            std::string::npos);
}

TEST_F(KeyFiles, AFolderOfThemIsARingAndItsRevokedOnesStayKnown) {
  const hal::SecretKey other = hal::make_key("Bob");
  write("a.pub", hal::public_key_text(key.open));
  write("b.pub", hal::public_key_text(other.open));
  write("notes.txt", "anything");
  EXPECT_FALSE(hal::KeyRing::load(std::string(folder.c_str())).find(other.open.id)->revoked) << "nobody is yet";
  write("revoked", "# left in May\n" + hal::hex_of(other.open.id) + "\n");
  const hal::KeyRing ring = hal::KeyRing::load(std::string(folder.c_str()));
  const std::string listed = hal::describe(ring);
  EXPECT_NE(listed.find(hal::hex_of(other.open.id) + " (" + std::string(other.open.name.view()) + ", revoked)"),
            std::string::npos)
      << listed;
  EXPECT_NE(listed.find(" (" + std::string(key.open.name.view()) + ")"), std::string::npos) << listed;
  EXPECT_NE(hal::describe({}).find("no keys"), std::string::npos);
  ASSERT_EQ(ring.size(), 2u);
  EXPECT_FALSE(ring.find(key.open.id)->revoked);
  EXPECT_TRUE(ring.find(other.open.id)->revoked);
  EXPECT_EQ(hal::KeyRing::load(folder.file("none").string()).size(), 0u);
  write("revoked", "no id\n");
  EXPECT_NE(complaint([&] { hal::KeyRing::load(std::string(folder.c_str())); }).find("revoked:1"), std::string::npos);
}

TEST_F(KeyFiles, AFolderOfTooManyIsRefusedAndAnEmptyNameIsNone) {
  EXPECT_EQ(hal::KeyRing::load("").size(), 0u);
  for (int i = 0; i < 17; ++i) write(std::to_string(i) + ".pub", hal::public_key_text(hal::make_key("k").open));
  EXPECT_NE(complaint([&] { hal::KeyRing::load(std::string(folder.c_str())); }).find("17 keys"), std::string::npos);
}

TEST_F(KeyFiles, TheRevokedListTakesCapitalsAndSpacesAndRefusesAnythingElse) {
  write("a.pub", hal::public_key_text(key.open));
  std::string id = hal::hex_of(key.open.id);
  for (char& c : id) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  write("revoked", "\t" + id + "\r\n# Ann\r\n\n");
  EXPECT_TRUE(hal::KeyRing::load(std::string(folder.c_str())).find(key.open.id)->revoked);
  EXPECT_EQ(hal::KeyRing::load(std::string(folder.c_str())).find(hal::KeyId{}), nullptr);
  write("revoked", std::string(17000, '#'));
  EXPECT_NE(complaint([&] { hal::KeyRing::load(std::string(folder.c_str())); }).find("at most 16384"),
            std::string::npos);
  write("revoked", hal::hex_of(key.open.id) + " since May\n");
  EXPECT_NE(complaint([&] { hal::KeyRing::load(std::string(folder.c_str())); }).find("16 hex digits"),
            std::string::npos);
  write("revoked", "0011\n");
  EXPECT_NE(complaint([&] { hal::KeyRing::load(std::string(folder.c_str())); }).find("16 hex digits"),
            std::string::npos);
}

/// What reload() complains of.
std::vector<std::string> told;
hal::KeyRing reloaded(const std::string& dir) {
  told.clear();
  hal::KeyRing ring;
  ring.add(hal::make_key("of before").open);
  ring.reload(dir.c_str(), [](const char* file, const char* what) { told.push_back(std::string(file) + " " + what); });
  return ring;
}

TEST_F(KeyFiles, ABoxReadsTheFolderAnewAndLeavesOutWhatIsNoKey) {
  const hal::SecretKey other = hal::make_key("Bob");
  write("a.pub", hal::public_key_text(key.open));
  write("b.pub", hal::public_key_text(other.open));
  write("revoked", hal::hex_of(other.open.id));
  const std::string dir(folder.c_str());
  const hal::KeyRing good = reloaded(dir), loaded = hal::KeyRing::load(dir);
  EXPECT_TRUE(told.empty());
  ASSERT_EQ(good.size(), 2u);
  for (const hal::PublicKey& known : loaded.keys()) {
    const hal::PublicKey* same = good.find(known.id);
    ASSERT_NE(same, nullptr);
    EXPECT_EQ(same->bytes, known.bytes);
    EXPECT_EQ(same->name.view(), known.name.view());
    EXPECT_EQ(same->revoked, known.revoked);
  }
  write("c.pub", hal::secret_key_text(key), 0600);
  write("d.pub", "airside-public-key-1 0011 Cid");
  write("e.pub", std::string(600, 'x'));
  std::filesystem::create_directory(folder.file("f.pub"));
  EXPECT_EQ(reloaded(dir).size(), 2u);
  EXPECT_EQ(told.size(), 4u);
  for (const std::string& line : told) EXPECT_NE(line.find("no public key"), std::string::npos) << line;
  for (int i = 0; i < 15; ++i) write("k" + std::to_string(i) + ".pub", hal::public_key_text(hal::make_key("k").open));
  EXPECT_EQ(reloaded(dir).size(), hal::KeyRing::max_keys);
  EXPECT_EQ(told.size(), 5u);
}

TEST_F(KeyFiles, ABoxThatCannotReadWhoWasRevokedTrustsNobody) {
  const std::string dir(folder.c_str());
  write("a.pub", hal::public_key_text(key.open));
  for (const std::string& list :
       {std::string("no id\n"), std::string("00112233445566778899\n"), std::string(17000, '#')}) {
    write("revoked", list);
    EXPECT_EQ(reloaded(dir).size(), 0u) << list.substr(0, 30);
    ASSERT_EQ(told.size(), 1u);
    EXPECT_NE(told[0].find("no key is trusted"), std::string::npos);
  }
  std::filesystem::remove(folder.file("revoked"));
  std::filesystem::create_symlink("revoked", folder.file("revoked"));
  EXPECT_EQ(reloaded(dir).size(), 0u) << "a link in a circle";
  std::filesystem::remove(folder.file("revoked"));
  EXPECT_EQ(reloaded(dir).size(), 1u);
  EXPECT_EQ(reloaded("").size() + reloaded(folder.file("none").string()).size(), 0u);
  EXPECT_TRUE(told.empty()) << "a box without keys takes no pushed weights";
  EXPECT_EQ(reloaded(folder.file("a.pub").string()).size(), 0u);
  EXPECT_EQ(told.size(), 1u);
}

TEST_F(KeyFiles, ALongNameIsCutAndTheRingHasAnEnd) {
  key.open.name = hal::KeyName(std::string(200, 'n'));
  EXPECT_EQ(key.open.name.view().size(), 63u);
  hal::KeyRing ring;
  for (std::size_t i = 0; i < hal::KeyRing::max_keys; ++i) EXPECT_TRUE(ring.add(key.open));
  EXPECT_FALSE(ring.add(key.open));
}

TEST_F(KeyFiles, AMissingSecretKeyIsSaidToBeMissing) {
  EXPECT_NE(complaint([&] { hal::read_secret_key(folder.file("none.key").string()); }).find("none.key"),
            std::string::npos);
  for (const std::size_t digits : {62u, 66u}) {
    const std::string text = "airside-public-key-1 " + std::string(digits, 'a');
    EXPECT_NE(complaint([&] { hal::read_public_key(write("g.pub", text)); }).find(std::to_string(digits)),
              std::string::npos);
  }
}

}  // namespace
}  // namespace airside::weights
