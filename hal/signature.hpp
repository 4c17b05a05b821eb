#pragma once
// Who may send weights: Ed25519 signatures on blobs, and the keys that a box trusts. libsodium computes; nothing is
// asked of the heap after the keys were loaded.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "airside/blob.hpp"

namespace airside::hal {

using KeyId = std::array<std::uint8_t, 8>;

/// A public key as a box knows it.
struct PublicKey {
  std::array<std::uint8_t, 32> bytes{};
  KeyId id{};  ///< first bytes of BLAKE2b of the key, as in a blob's header
  bool revoked = false;
  std::string name;  ///< whose it is, for people
};

/// A key that signs; stays on the host that trains.
struct SecretKey {
  std::array<std::uint8_t, 64> bytes{};
  PublicKey open;
};

/// A new random pair.
SecretKey make_key(const std::string& name);

/// Text of the two key files. One line each: `airside-public-key-1 HEX NAME`, `airside-secret-key-1 HEX NAME`.
std::string public_key_text(const PublicKey& key);
std::string secret_key_text(const SecretKey& key);
/// Errors: InputError for another kind of file, a wrong length, or digits that are none; a secret key that others may
/// read is refused.
PublicKey read_public_key(const std::string& path);
SecretKey read_secret_key(const std::string& path);

/// The keys of a folder: `*.pub`, and those named in a file `revoked`, one key id in hex a line.
class KeyRing {
 public:
  static constexpr std::size_t max_keys = 16;  ///< as many as a box keeps counters for

  KeyRing() = default;
  /// Errors: InputError for a bad key file, or more than max_keys; a folder that does not exist holds no keys.
  static KeyRing load(const std::string& dir);
  void add(PublicKey key) { keys_.push_back(std::move(key)); }
  /// nullptr for a key that is not here.
  const PublicKey* find(const KeyId& id) const;
  std::size_t size() const { return keys_.size(); }
  const std::vector<PublicKey>& keys() const { return keys_; }

 private:
  std::vector<PublicKey> keys_;
};

/// `0123456789abcdef`.
std::string hex_of(std::span<const std::uint8_t> bytes);

/// Writes key id and counter into the header, the digest anew, and the signature behind the payload.
///   signature = Ed25519ph(key, "airside weight blob 1\0" | header | payload)
/// Errors: InputError for bytes that are no whole blob.  Source: RELIABILITY "Weight blob"; FORMATS.md.
void sign_blob(std::span<std::byte> blob, const SecretKey& key, std::uint64_t counter);

/// Checks, in this order: length against the header's, key known and not revoked, signature over every byte before it.
/// Errors: BlobError blob_truncated, blob_magic, blob_size or blob_signature, the field named. Cost: one pass of
/// SHA-512, no heap.
tl::expected<const PublicKey*, BlobError> verify_blob(std::span<const std::byte> blob, const KeyRing& keys);

}  // namespace airside::hal
