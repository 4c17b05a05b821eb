// Weight blobs: what is taken is encoded back to the same bytes, and every number in it is within bounds; a signature
// is taken from the one trusted key alone, over every byte.

#include <sodium.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <memory>

#include "airside/controller/blob.hpp"
#include "fuzz/target.hpp"
#include "hal/weights/signature.hpp"

namespace airside::fuzz {
namespace {

/// A room so small that a blob has less than 1 KB.
struct OneVav {
  static constexpr int vavs = 1, fcus = 0, powers = 1;
  static constexpr bool exact = true;
  static constexpr const char* name = "1vav-0fcu-1power";
};
constexpr int parameters = 6;
using Codec = BlobCodec<OneVav, parameters>;
constexpr std::size_t front = sizeof(BlobHeader);

std::span<std::byte> raw_of(Bytes& bytes) { return std::as_writable_bytes(std::span(bytes)); }

Codec::Payload& scratch() {
  static const auto payload = std::make_unique<Codec::Payload>();
  return *payload;
}

Bytes encoded(std::uint32_t head_states, const char* scope, bool with_residual = false) {
  auto payload = std::make_unique<Codec::Payload>();
  payload->head_states = head_states;
  payload->head_theta.setConstant(0.25);
  for (int i = 0; i < RoomHead<OneVav>::states; ++i) {
    payload->head_covariance[static_cast<std::size_t>(i * RoomHead<OneVav>::states + i)] = 0.5;
  }
  payload->weights.fill(0.125f);
  payload->residual.values.fill(0.25f);
  payload->residual.is_trained = with_residual ? 1 : 0;
  std::strcpy(payload->provenance.data(), "airside pretrain");  // NOLINT: a literal into 512 bytes
  BlobHeader header;
  std::memcpy(header.site_scope.data(), scope, std::strlen(scope));
  Bytes bytes(Codec::size(*payload));
  Codec::encode(header, *payload, raw_of(bytes));
  return bytes;
}

bool decode(View input) {
  constexpr std::string_view site = "Room 1";
  Codec::Payload& payload = scratch();
  const auto header = Codec::decode(raw(input), site, payload);
  if (!header) {
    FUZZ_CLAIM(header.error().fault != Fault::none && header.error().field[0] != '\0');
    return false;
  }
  FUZZ_CLAIM(payload.scaler.finite());
  for (const float w : payload.weights) FUZZ_CLAIM(w >= -1000 && w <= 1000);
  FUZZ_CLAIM(payload.head_theta.allFinite());
  for (const float v : payload.residual.values) FUZZ_CLAIM(v >= -1000 && v <= 1000);
  Bytes again(input.size());
  FUZZ_CLAIM(Codec::encode(*header, payload, raw_of(again)) == input.size());
  FUZZ_CLAIM(std::memcmp(again.data(), input.data(), input.size() - blob_signature_bytes) == 0);
  return true;
}

void give_digest(Bytes& input) {
  if (input.size() < front + blob_signature_bytes) return;
  BlobHeader header;
  std::memcpy(&header, input.data(), front);
  const std::size_t payload = std::min<std::size_t>(header.payload_bytes, input.size() - front);
  const std::uint32_t crc = blob_digest(header, std::as_bytes(std::span(input)).subspan(front, payload));
  header.digest = {};
  std::memcpy(header.digest.data(), &crc, sizeof crc);
  std::memcpy(input.data(), &header, front);
}

/// The digest fits again; by choice also the marks, the hashes and the lengths.
void repair(Bytes& input, std::uint32_t choice) {
  if (input.size() < front + blob_signature_bytes) input.resize(front + blob_signature_bytes);
  BlobHeader header;
  std::memcpy(&header, input.data(), front);
  const BlobHeader good;
  if ((choice & 1) != 0) {
    header.magic = good.magic, header.format_version = good.format_version, header.header_bytes = good.header_bytes;
    header.endian_mark = good.endian_mark, header.float_mark = good.float_mark, header.digest_kind = good.digest_kind;
    header.topology_hash = topology_hash(capacity_of<OneVav>(), parameters);
    header.units_hash = units_hash<OneVav>(capacity_of<OneVav>());
    header.parameters = parameters;
  }
  if ((choice & 2) != 0) header.payload_bytes = static_cast<std::uint32_t>(input.size() - front - blob_signature_bytes);
  if ((choice & 4) != 0) {
    input.resize(Codec::size(0, 0));
    header.head_states = 0;
    header.payload_bytes = static_cast<std::uint32_t>(Codec::Payload::bytes(0, 0));
  }
  std::memcpy(input.data(), &header, front);
  give_digest(input);
}

/// The same for blobs with a room head.
void repair_head(Bytes& input, std::uint32_t choice) { repair(input, choice & ~4U); }

std::vector<Bytes> seeds() { return {encoded(0, "Room 1"), encoded(0, ""), encoded(0, "another")}; }
std::vector<Bytes> head_seeds() { return {encoded(94, ""), encoded(0, ""), encoded(94, "", true)}; }

// ---- signatures

/// Reads text through the file system, as key files are.
template <class Read>
auto through_file(std::string_view text, const Read& read) {
  static const int fd = ::memfd_create("airside-fuzz", 0);
  FUZZ_CLAIM(::fchmod(fd, 0600) == 0);  // as a secret key must stand
  FUZZ_CLAIM(::ftruncate(fd, 0) == 0 && ::pwrite(fd, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()));
  return read("/proc/self/fd/" + std::to_string(fd));
}

hal::SecretKey key_from(std::uint8_t first) {
  FUZZ_CLAIM(sodium_init() >= 0);
  std::array<std::uint8_t, crypto_sign_SEEDBYTES> seed{first};
  hal::SecretKey key;
  crypto_sign_seed_keypair(key.open.bytes.data(), key.bytes.data(), seed.data());
  key.open = through_file(hal::public_key_text(key.open), hal::read_public_key);
  return key;
}

struct KeyTable {
  hal::SecretKey trusted = key_from(1), revoked = key_from(2), unknown = key_from(3);
  hal::KeyRing ring;
  KeyTable() {
    ring.add(trusted.open);
    revoked.open.revoked = true;
    ring.add(revoked.open);
  }
};
const KeyTable& table() {
  static const KeyTable all;
  return all;
}

bool verify(View input) {
  const auto key = hal::verify_blob(raw(input), table().ring);
  if (!key) {
    FUZZ_CLAIM(key.error().fault != Fault::none && key.error().field[0] != '\0');
    return false;
  }
  FUZZ_CLAIM((*key)->id == table().trusted.open.id && !(*key)->revoked);
  BlobHeader header;
  std::memcpy(&header, input.data(), front);
  FUZZ_CLAIM(header.key_id == table().trusted.open.id);
  // Ed25519 has one signature of a message: signing again must give these bytes, else somebody forged them.
  Bytes again(input.begin(), input.end());
  hal::sign_blob(raw_of(again), table().trusted, header.security_counter);
  FUZZ_CLAIM(std::equal(input.end() - blob_signature_bytes, input.end(), again.end() - blob_signature_bytes));
  decode(input);
  return true;
}

void sign(Bytes& input, std::uint32_t choice) {
  repair(input, choice | 3U);
  const hal::SecretKey& key = choice % 16 == 8 ? table().revoked : choice % 16 == 9 ? table().unknown : table().trusted;
  taken([&] { hal::sign_blob(raw_of(input), key, choice); });
  if (choice % 5 == 0) input[choice % input.size()] ^= static_cast<std::uint8_t>(1U << choice % 8);
}

std::vector<Bytes> signed_seeds() {
  std::vector<Bytes> all;
  for (const hal::SecretKey* key : {&table().trusted, &table().revoked, &table().unknown}) {
    all.push_back(encoded(0, ""));
    hal::sign_blob(raw_of(all.back()), *key, 7);
  }
  all.push_back(encoded(0, ""));
  return all;
}

// ---- key files

bool read_key(View input) {
  Cursor in(input);
  const unsigned kind = in.byte();
  return taken([&] {
    if (kind % 2 == 0) {
      const hal::PublicKey key = through_file(text_of(in.rest()), hal::read_public_key);
      const hal::PublicKey again = through_file(hal::public_key_text(key), hal::read_public_key);
      FUZZ_CLAIM(again.bytes == key.bytes && again.id == key.id);
    } else {
      const hal::SecretKey key = through_file(text_of(in.rest()), hal::read_secret_key);
      const hal::SecretKey again = through_file(hal::secret_key_text(key), hal::read_secret_key);
      FUZZ_CLAIM(again.bytes == key.bytes && again.open.bytes == key.open.bytes);
    }
  });
}

std::vector<Bytes> key_seeds() {
  const auto with_kind = [](char kind, const std::string& text) { return bytes_of(kind + text); };
  return {with_kind('\0', hal::public_key_text(table().trusted.open)),
          with_kind('\1', hal::secret_key_text(table().trusted)), with_kind('\0', "airside-public-key-1 00")};
}

std::vector<std::string> key_words() { return {"airside-public-key-1", "airside-secret-key-1", "0123456789abcdef"}; }

}  // namespace

const Target blob{"blob", Codec::size(0, 0) + 64, decode, repair, seeds, nullptr};
const Target blob_head{"blob_head", Codec::size(94, ResidualNetwork::parameters) + 64, decode, repair_head, head_seeds,
                       nullptr};
const Target signed_blob{"signed_blob", Codec::size(0, 0) + 64, verify, sign, signed_seeds, nullptr};
const Target keys{"keys", 400, read_key, nullptr, key_seeds, key_words};

}  // namespace airside::fuzz
