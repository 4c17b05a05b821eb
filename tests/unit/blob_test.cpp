// A blob is read whole or refused with the field's name: flipped bits, cut ends, other rooms, other units.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "airside/controller/instances.hpp"
#include "airside/splitmix64.hpp"

namespace airside {
namespace {

template <class T>
using Payload = typename WeightBlob<T>::Payload;
using Bytes = std::vector<std::byte>;

template <class T>
std::unique_ptr<Payload<T>> some_payload(bool with_head, bool with_residual = false) {
  auto p = std::make_unique<Payload<T>>();
  SplitMix64 draw(17);
  for (int i = 0; i < Layout<T>::inputs; ++i) {
    p->scaler.mean(i) = 10 * draw.symmetric();
    p->scaler.scale(i) = 0.5 + draw.uniform();
  }
  for (float& w : p->weights) w = static_cast<float>(draw.symmetric());
  if (with_head) {
    using Head = RoomHead<T>;
    p->head_states = static_cast<std::uint32_t>(Head::states);
    p->head_updates = 123;
    for (int i = 0; i < Head::states; ++i) p->head_theta(i) = draw.symmetric();
    typename Head::Covariance c(p->head_covariance.data());
    for (int i = 0; i < Head::states; ++i) {
      for (int j = 0; j <= i; ++j) c(i, j) = c(j, i) = i == j ? 1 + draw.uniform() : 0.01 * draw.symmetric();
    }
  }
  if (with_residual) {
    for (float& v : p->residual.values) v = 0.5f + static_cast<float>(draw.uniform());
    p->residual.is_trained = 1;
  }
  const std::string text = "twin rc 301, 31 days";
  std::copy(text.begin(), text.end(), p->provenance.begin());
  return p;
}

template <class T>
Bytes encode(const Payload<T>& payload, BlobHeader header = {}) {
  Bytes bytes(WeightBlob<T>::size(payload));
  EXPECT_EQ(WeightBlob<T>::encode(header, payload, bytes), bytes.size());
  return bytes;
}

template <class T>
tl::expected<BlobHeader, BlobError> decode(const Bytes& bytes, const std::string& scope = "") {
  auto payload = std::make_unique<Payload<T>>();
  return WeightBlob<T>::decode(bytes, scope, *payload);
}

/// Writes the digest anew after a change, so that the check behind the digest is reached.
void sign_off(Bytes& bytes) {
  BlobHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  header.digest = {};
  std::memcpy(bytes.data(), &header, sizeof header);
  const std::span<const std::byte> all(bytes);
  const std::uint32_t crc = crc32c(all.subspan(sizeof header, header.payload_bytes), crc32c(all.first(sizeof header)));
  std::memcpy(header.digest.data(), &crc, sizeof crc);
  std::memcpy(bytes.data(), &header, sizeof header);
}

template <class T, class Change>
void expect_refused(Bytes bytes, Change change, Fault fault, const std::string& field, const std::string& scope = "") {
  BlobHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  change(header);
  std::memcpy(bytes.data(), &header, sizeof header);
  sign_off(bytes);
  const auto read = decode<T>(bytes, scope);
  ASSERT_FALSE(read) << field;
  EXPECT_EQ(read.error().fault, fault) << text_of(read.error().fault);
  EXPECT_EQ(read.error().field, field);
}

template <class T>
class BlobOfEveryTopology : public ::testing::Test {};
using Topologies = ::testing::Types<FiveZone, ThreeVav, EightVavFourFcu>;
TYPED_TEST_SUITE(BlobOfEveryTopology, Topologies);

TYPED_TEST(BlobOfEveryTopology, Row45WithoutItComesBackToTheBit) {
  for (const bool with_head : {false, true}) {
    const auto before = some_payload<TypeParam>(with_head);
    BlobHeader header;
    header.security_counter = 42;
    header.created_s = 1'627'862'400;
    const Bytes bytes = encode<TypeParam>(*before, header);
    auto after = std::make_unique<Payload<TypeParam>>();
    const auto read = WeightBlob<TypeParam>::decode(bytes, {}, *after);
    ASSERT_TRUE(read) << read.error().field;
    EXPECT_EQ(read->security_counter, 42U);
    EXPECT_EQ(read->created_s, 1'627'862'400);
    EXPECT_EQ(after->scaler.mean, before->scaler.mean);
    EXPECT_EQ(after->scaler.scale, before->scaler.scale);
    EXPECT_EQ(after->weights, before->weights);
    EXPECT_EQ(after->head_states, before->head_states);
    EXPECT_EQ(after->head_updates, before->head_updates);
    EXPECT_EQ(after->head_theta, before->head_theta);
    EXPECT_EQ(after->head_covariance, before->head_covariance);
    EXPECT_EQ(after->provenance, before->provenance);
    EXPECT_EQ(encode<TypeParam>(*after, *read), bytes);
  }
}

TYPED_TEST(BlobOfEveryTopology, EveryTruncationAndEveryExtensionIsRefused) {
  const Bytes whole = encode<TypeParam>(*some_payload<TypeParam>(true));
  auto payload = std::make_unique<Payload<TypeParam>>();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto read = WeightBlob<TypeParam>::decode(std::span(whole).first(size), {}, *payload);
    ASSERT_FALSE(read) << size;
    ASSERT_EQ(read.error().fault, Fault::blob_truncated);
  }
  Bytes longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_EQ(decode<TypeParam>(longer).error().fault, Fault::blob_size);
}

/// Flips bits 0, step, 2 step ... of [from, to); returns how many were tried. The signature is not covered here: it has
/// its own check against the key.
template <class T>
std::size_t flip_bits(Bytes& bytes, std::size_t from_byte, std::size_t to_byte, std::size_t step) {
  auto payload = std::make_unique<Payload<T>>();
  std::size_t tried = 0;
  for (std::size_t bit = 8 * from_byte; bit < 8 * to_byte; bit += step, ++tried) {
    const std::byte mask{static_cast<unsigned char>(1U << (bit % 8))};
    bytes[bit / 8] ^= mask;
    const auto read = WeightBlob<T>::decode(bytes, {}, *payload);
    bytes[bit / 8] ^= mask;
    if (read) {
      ADD_FAILURE() << "bit " << bit << " was flipped and the blob taken";
      return tried;
    }
  }
  return tried;
}

TEST(Blob, EverySingleFlippedBitIsRefused) {
  Bytes bytes = encode<ThreeVav>(*some_payload<ThreeVav>(false));
  ASSERT_TRUE(decode<ThreeVav>(bytes));
  const std::size_t covered = bytes.size() - blob_signature_bytes;
  EXPECT_EQ(flip_bits<ThreeVav>(bytes, 0, sizeof(BlobHeader), 1), 8 * sizeof(BlobHeader));
  const bool every = std::getenv("AIRSIDE_EVERY_BIT") != nullptr;
  EXPECT_GT(flip_bits<ThreeVav>(bytes, sizeof(BlobHeader), covered, every ? 1 : 211), 4000U);
}

TEST(Blob, FlippedBitsOfTheLargestAreRefused) {
  Bytes bytes = encode<EightVavFourFcu>(*some_payload<EightVavFourFcu>(true));
  ASSERT_TRUE(decode<EightVavFourFcu>(bytes));
  EXPECT_EQ(flip_bits<EightVavFourFcu>(bytes, 0, sizeof(BlobHeader), 7), 220U);
  EXPECT_GT(flip_bits<EightVavFourFcu>(bytes, sizeof(BlobHeader), bytes.size() - blob_signature_bytes, 1999), 900U);
}

TEST(Blob, OfAnotherRoomNamesTheField) {
  const Bytes bytes = encode<ThreeVav>(*some_payload<ThreeVav>(true));
  const auto read = decode<FiveZone>(bytes);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().fault, Fault::blob_topology);
  EXPECT_STREQ(read.error().field, "topology_hash");
}

TEST(Blob, Row45Row46EachFieldThatDoesNotFitIsNamed) {
  const Bytes b = encode<ThreeVav>(*some_payload<ThreeVav>(true));
  using H = BlobHeader;
  expect_refused<ThreeVav>(
      b, [](H& h) { h.magic[0] = 'X'; }, Fault::blob_magic, "magic");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.format_version = 4; }, Fault::blob_version, "format_version");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.header_bytes = 64; }, Fault::blob_version, "header_bytes");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.endian_mark = 0x04030201; }, Fault::blob_architecture, "endian_mark");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.float_mark = -h.float_mark; }, Fault::blob_architecture, "float_mark");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.digest_kind = 2; }, Fault::blob_digest, "digest_kind");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.units_hash ^= 1; }, Fault::blob_units, "units_hash");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.parameters -= 1; }, Fault::blob_size, "parameters");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.head_states = 3; }, Fault::blob_size, "head_states");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.head_states = 0; }, Fault::blob_size, "payload_bytes");
  expect_refused<ThreeVav>(
      b, [](H& h) { h.site_scope[0] = 'A'; }, Fault::blob_scope, "site_scope", "B");
}

TEST(Blob, Row46WithoutItScopeFitsItsSiteAndAnEmptyOneFitsAll) {
  BlobHeader header;
  const std::string scope = "Room 301";
  std::copy(scope.begin(), scope.end(), header.site_scope.begin());
  const Bytes bytes = encode<ThreeVav>(*some_payload<ThreeVav>(false), header);
  EXPECT_TRUE(decode<ThreeVav>(bytes, "Room 301"));
  for (const char* other : {"Room 302", "Room 30", "Room 3011", ""})
    EXPECT_FALSE(decode<ThreeVav>(bytes, other)) << other;
  EXPECT_TRUE(decode<ThreeVav>(encode<ThreeVav>(*some_payload<ThreeVav>(false)), "anything"));
}

TEST(Blob, ValuesThatAreNoneAreRefusedThoughTheDigestIsRight) {
  const auto refused = [](const std::string& field, const std::function<void(Payload<ThreeVav>&)>& spoil) {
    auto payload = some_payload<ThreeVav>(true);
    spoil(*payload);
    const auto read = decode<ThreeVav>(encode<ThreeVav>(*payload));
    ASSERT_FALSE(read) << field;
    EXPECT_EQ(read.error().fault, Fault::blob_value);
    EXPECT_EQ(read.error().field, field);
  };
  constexpr float inf = std::numeric_limits<float>::infinity();
  refused("scaler", [](auto& p) { p.scaler.scale(2) = 0; });
  refused("scaler", [](auto& p) { p.scaler.mean(2) = std::nan(""); });
  refused("weights", [](auto& p) { p.weights[5] = std::nanf(""); });
  refused("weights", [](auto& p) { p.weights.back() = inf; });
  refused("weights", [](auto& p) { p.weights[0] = -1001.0f; });
  refused("head_theta", [](auto& p) { p.head_theta(1) = std::nan(""); });
  refused("head_covariance", [](auto& p) { p.head_covariance[0] = -1; });
  refused("head_covariance", [](auto& p) { p.head_covariance[1] = std::nan(""); });
}

TEST(Blob, CarriesAResidualNetworkOrNone) {
  for (const bool with_head : {false, true}) {
    const auto without = some_payload<ThreeVav>(with_head), with = some_payload<ThreeVav>(with_head, true);
    const Bytes small = encode<ThreeVav>(*without), large = encode<ThreeVav>(*with);
    EXPECT_EQ(large.size(), small.size() + sizeof(float) * ResidualNetwork::parameters);
    auto read = std::make_unique<Payload<ThreeVav>>();
    ASSERT_TRUE(WeightBlob<ThreeVav>::decode(large, std::string(), *read));
    EXPECT_EQ(read->residual.is_trained, 1u);
    EXPECT_EQ(read->residual.values, with->residual.values);
    EXPECT_EQ(read->provenance, with->provenance);
    ASSERT_TRUE(WeightBlob<ThreeVav>::decode(small, std::string(), *read));
    EXPECT_EQ(read->residual.is_trained, 0u) << "none stays from the blob before";
    EXPECT_EQ(read->provenance, without->provenance);
  }
}

TEST(Blob, RefusesAResidualNetworkOfAnotherSize) {
  const Bytes bytes = encode<ThreeVav>(*some_payload<ThreeVav>(true, true));
  for (const std::uint32_t count : {0u, 1u, 1188u, 1190u, 0xFFFFFFFFu}) {
    expect_refused<ThreeVav>(
        bytes, [&](BlobHeader& h) { h.residual_parameters = count; }, Fault::blob_size, "residual_parameters");
  }
}

TEST(Blob, SaysByItsVersionWhetherThereIsAResidualNetwork) {
  const Bytes with = encode<ThreeVav>(*some_payload<ThreeVav>(true, true)),
              without = encode<ThreeVav>(*some_payload<ThreeVav>(true));
  BlobHeader header;
  std::memcpy(&header, with.data(), sizeof header);
  EXPECT_EQ(header.format_version, 2) << "readers from before there were any must refuse it";
  std::memcpy(&header, without.data(), sizeof header);
  EXPECT_EQ(header.format_version, 1);
  const auto other = [](BlobHeader& h) { h.format_version = h.format_version == 1 ? 2 : 1; };
  for (const Bytes& bytes : {with, without}) {
    expect_refused<ThreeVav>(bytes, other, Fault::blob_size, "residual_parameters");
  }
}

TEST(Blob, OfAnotherCycleFitsThatCycleAlone) {
  for (const bool with_residual : {false, true}) {
    const auto payload = some_payload<ThreeVav>(true, with_residual);
    const Bytes usual = encode<ThreeVav>(*payload);
    payload->cycle = cycle_of_minutes(12);
    const Bytes bytes = encode<ThreeVav>(*payload);
    BlobHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    EXPECT_EQ(header.format_version, 3) << "readers from before there was another must refuse it";
    EXPECT_EQ(cycle_min_of(header), 12U);
    std::memcpy(&header, usual.data(), sizeof header);
    EXPECT_EQ(header.cycle_min, 0U) << "the bytes of 18 min are those of before";
    for (const int minutes : {6, 12, 18, 24}) {
      auto read = std::make_unique<Payload<ThreeVav>>();
      read->cycle = cycle_of_minutes(minutes);
      const auto other = WeightBlob<ThreeVav>::decode(bytes, std::string(), *read);
      EXPECT_EQ(other.has_value(), minutes == 12) << minutes;
      if (other) {
        EXPECT_EQ(read->residual.is_trained, with_residual ? 1U : 0U);
      } else {
        EXPECT_EQ(other.error().fault, Fault::blob_cycle);
        EXPECT_STREQ(other.error().field, "cycle_min");
      }
      EXPECT_EQ(WeightBlob<ThreeVav>::decode(usual, std::string(), *read).has_value(), minutes == 18) << minutes;
    }
  }
}

TEST(Blob, RefusesACycleThatItsVersionDoesNotHave) {
  const Bytes usual = encode<ThreeVav>(*some_payload<ThreeVav>(true));
  expect_refused<ThreeVav>(
      usual, [](BlobHeader& h) { h.cycle_min = 18; }, Fault::blob_cycle, "cycle_min");
  expect_refused<ThreeVav>(
      usual, [](BlobHeader& h) { h.format_version = 3; }, Fault::blob_cycle, "cycle_min");
}

TEST(Blob, RefusesAResidualNetworkThatCannotBe) {
  const auto refused = [](std::size_t at, float value) {
    const auto payload = some_payload<ThreeVav>(false, true);
    payload->residual.values[at] = value;
    const auto read = decode<ThreeVav>(encode<ThreeVav>(*payload));
    ASSERT_FALSE(read) << at;
    EXPECT_EQ(read.error().fault, Fault::blob_value);
    EXPECT_STREQ(read.error().field, "residual");
  };
  refused(0, std::nanf(""));
  refused(ResidualNetwork::inputs, 0.0f);
  refused(2 * ResidualNetwork::inputs - 1, -1.0f);
  refused(ResidualNetwork::parameters - 1, 1001.0f);
}

TEST(Blob, NeedsRoomForTheWhole) {
  const auto payload = some_payload<ThreeVav>(true);
  Bytes small(WeightBlob<ThreeVav>::size(*payload) - 1);
  EXPECT_EQ(WeightBlob<ThreeVav>::encode({}, *payload, small), 0U);
  EXPECT_GE(WeightBlob<ThreeVav>::max_bytes, small.size() + 1);
}

TEST(Crc32c, GivesTheReferenceNumbers) {
  const auto crc_of = [](const std::string& text) { return crc32c(std::as_bytes(std::span(text))); };
  EXPECT_EQ(crc_of("123456789"), 0xE3069283u);  // RFC 3720's polynomial, the usual check value
  EXPECT_EQ(crc_of(std::string(32, '\0')), 0x8A9136AAu);
  EXPECT_EQ(crc_of(std::string(32, '\xFF')), 0x62A8AB43u);
  EXPECT_EQ(crc_of(""), 0u);
}

}  // namespace
}  // namespace airside
