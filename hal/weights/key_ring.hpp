#pragma once
// Keys that sign weights, their files, and the folder of those that a box trusts.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace airside::hal {

using KeyId = std::array<std::uint8_t, 8>;

/// Whose key it is, for people. Longer names are cut; no heap.
class KeyName {
 public:
  KeyName() = default;
  explicit KeyName(std::string_view name) { name.copy(text_.data(), text_.size() - 1); }
  std::string_view view() const { return text_.data(); }

 private:
  std::array<char, 64> text_{};
};

/// A public key as a box knows it.
struct PublicKey {
  std::array<std::uint8_t, 32> bytes{};
  KeyId id{};  ///< first bytes of BLAKE2b of the key, as in a blob's header
  bool revoked = false;
  bool counter_given = false;      ///< by the file `counters` of the keys folder
  std::uint64_t last_counter = 0;  ///< then: blobs up to this one are old
  KeyName name;
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

/// The keys of a folder: `*.pub`, those named in a file `revoked`, one key id in hex a line, and the last counters that
/// a person has written into a file `counters`, a key id and a number a line.
class KeyRing {
 public:
  static constexpr std::size_t max_keys = 16;  ///< as many as a box keeps counters for

  KeyRing() = default;
  /// Errors: InputError for a bad key file, or more than max_keys; a folder that does not exist holds no keys.
  static KeyRing load(const std::string& dir);
  /// The folder as it is now, for a box that must go on whatever lies there: `tell(file, what)` for each file that is
  /// no key and each key beyond max_keys, which are left out. Where `revoked` cannot be read no key is trusted, and
  /// the reason is returned, else nullptr.
  /// Cost: a few system calls a key, no heap.
  using Tell = void (*)(const char* file, const char* what);
  const char* reload(const char* dir, Tell tell);

  /// False: there is no place for another.
  bool add(const PublicKey& key);
  /// nullptr for a key that is not here.
  const PublicKey* find(const KeyId& id) const;
  std::size_t size() const { return size_; }
  std::span<const PublicKey> keys() const { return std::span(keys_).first(size_); }

 private:
  void revoke(const KeyId& id);
  void give_counter(const KeyId& id, std::uint64_t counter);
  const char* revoke_listed(int dir_fd);
  const char* give_listed_counters(int dir_fd);

  std::array<PublicKey, max_keys> keys_{};
  std::size_t size_ = 0;
};

/// `0123456789abcdef (NAME), 0123456789abcdef (NAME, revoked)`, or that there are none: for people.
std::string describe(const KeyRing& ring);

/// `0123456789abcdef`.
std::string hex_of(std::span<const std::uint8_t> bytes);

}  // namespace airside::hal
