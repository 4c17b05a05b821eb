#include "hal/weights/signature.hpp"

#include <sodium.h>

#include <cstring>

#include "hal/text/input_error.hpp"
#include "hal/weights/blob_file.hpp"

namespace airside::hal {
namespace {

constexpr char domain[] = "airside weight blob 1";  // its final zero is signed too
static_assert(blob_signature_bytes == crypto_sign_BYTES);

const unsigned char* bytes_at(std::span<const std::byte> bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

/// Ed25519ph of domain and everything but the signature itself.
crypto_sign_state signed_part(std::span<const std::byte> blob) {
  crypto_sign_state state;
  crypto_sign_init(&state);
  crypto_sign_update(&state, reinterpret_cast<const unsigned char*>(domain), sizeof domain);
  crypto_sign_update(&state, bytes_at(blob), blob.size() - blob_signature_bytes);
  return state;
}

/// The header, if the bytes are as long as it says.
tl::expected<BlobHeader, BlobError> whole_header(std::span<const std::byte> blob) {
  const auto refuse = [](Fault fault, const char* field) { return tl::unexpected(BlobError{fault, field}); };
  BlobHeader header;
  if (blob.size() < sizeof header + blob_signature_bytes) return refuse(Fault::blob_truncated, "header");
  std::memcpy(&header, blob.data(), sizeof header);
  if (header.magic != BlobHeader{}.magic) return refuse(Fault::blob_magic, "magic");
  const std::uint64_t total = sizeof header + std::uint64_t{header.payload_bytes} + blob_signature_bytes;
  if (blob.size() < total) return refuse(Fault::blob_truncated, "payload_bytes");
  if (blob.size() > total) return refuse(Fault::blob_size, "payload_bytes");
  return header;
}

}  // namespace

void sign_blob(std::span<std::byte> blob, const SecretKey& key, std::uint64_t counter) {
  auto header = whole_header(blob);
  if (!header) {
    throw InputError(std::string("blob: ") + header.error().field, text_of(header.error().fault), "a whole weight blob",
                     "give a file made by `airside pretrain` or `airside transfer`");
  }
  header->security_counter = counter;
  header->key_id = key.open.id;
  const std::uint32_t crc = blob_digest(*header, blob.subspan(sizeof *header, header->payload_bytes));
  header->digest = {};
  std::memcpy(header->digest.data(), &crc, sizeof crc);
  std::memcpy(blob.data(), &*header, sizeof *header);
  crypto_sign_state state = signed_part(blob);
  std::array<unsigned char, crypto_sign_BYTES> signature{};
  crypto_sign_final_create(&state, signature.data(), nullptr, key.bytes.data());
  std::memcpy(blob.data() + blob.size() - signature.size(), signature.data(), signature.size());
}

BlobHeader sound_header(std::span<const std::byte> blob, const std::string& path) {
  const auto header = whole_header(blob);
  if (!header) throw_blob_error(header.error(), path);
  std::uint32_t digest = 0;
  std::memcpy(&digest, header->digest.data(), sizeof digest);
  if (digest != blob_digest(*header, blob.subspan(sizeof *header, header->payload_bytes))) {
    throw_blob_error({Fault::blob_digest, "digest"}, path);
  }
  return *header;
}

tl::expected<const PublicKey*, BlobError> verify_blob(std::span<const std::byte> blob, const KeyRing& keys) {
  const auto refuse = [](const char* field) { return tl::unexpected(BlobError{Fault::blob_signature, field}); };
  const auto header = whole_header(blob);
  if (!header) return tl::unexpected(header.error());
  const PublicKey* key = keys.find(header->key_id);
  if (key == nullptr || key->revoked) return refuse("key_id");
  std::array<unsigned char, crypto_sign_BYTES> signature{};
  std::memcpy(signature.data(), blob.data() + blob.size() - signature.size(), signature.size());
  crypto_sign_state state = signed_part(blob);
  if (crypto_sign_final_verify(&state, signature.data(), key->bytes.data()) != 0) return refuse("signature");
  return key;
}

}  // namespace airside::hal
