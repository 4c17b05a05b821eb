#include "hal/signature.hpp"

#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include "hal/input_error.hpp"
#include "hal/text_file.hpp"

namespace airside::hal {
namespace {

namespace fs = std::filesystem;

constexpr char domain[] = "airside weight blob 1";  // its final zero is signed too
constexpr const char* public_word = "airside-public-key-1";
constexpr const char* secret_word = "airside-secret-key-1";
static_assert(sizeof(PublicKey::bytes) == crypto_sign_PUBLICKEYBYTES);
static_assert(sizeof(SecretKey::bytes) == crypto_sign_SECRETKEYBYTES);
static_assert(blob_signature_bytes == crypto_sign_BYTES);

void need_sodium() {
  if (sodium_init() >= 0) return;  // uncovered: Linux has random numbers once it has started
  throw std::runtime_error("libsodium finds no source of random numbers");  // uncovered: as above
}

KeyId id_of(const std::array<std::uint8_t, 32>& key) {
  std::array<std::uint8_t, 16> hash{};
  crypto_generichash(hash.data(), hash.size(), key.data(), key.size(), nullptr, 0);
  KeyId id{};
  std::copy_n(hash.begin(), id.size(), id.begin());
  return id;
}

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

/// The hex digits and the name of a key file's one line.
template <std::size_t N>
std::string read_key(const std::string& path, const char* word, std::array<std::uint8_t, N>& bytes) {
  std::istringstream line(read_text_file(path, "a key file that `airside keygen` wrote"));
  std::string found, hex, name;
  line >> found >> hex;
  std::getline(line >> std::ws, name);
  if (found != word) {
    throw InputError(path + ":1", "\"" + found.substr(0, 40) + "\"", std::string("the word ") + word,
                     "give the .pub file to boxes and the .key file to `airside sign`");
  }
  std::size_t length = 0;
  const bool whole = sodium_hex2bin(bytes.data(), N, hex.c_str(), hex.size(), nullptr, &length, nullptr) == 0;
  if (!whole || length != N) {
    throw InputError(path + ":1", fmt::format("a key of {} characters", hex.size()),
                     fmt::format("{} hex digits", 2 * N), "copy the file again, whole");
  }
  return name;
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

/// Key ids of the file `revoked`; a missing file revokes nothing.
std::vector<std::string> revoked_ids(const fs::path& path) {
  std::vector<std::string> ids;
  if (!fs::exists(path)) return ids;
  std::istringstream lines(read_text_file(path.string(), "key ids in hex, one a line"));
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    line.erase(std::find(line.begin(), line.end(), '#'), line.end());
    std::erase_if(line, [](char c) { return c == ' ' || c == '\t' || c == '\r'; });
    if (line.empty()) continue;
    const bool hex =
        std::ranges::all_of(line, [](char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; });
    if (!hex || line.size() != 2 * sizeof(KeyId)) {
      throw InputError(fmt::format("{}:{}", path.string(), number), "\"" + line.substr(0, 40) + "\"",
                       "a key id of 16 hex digits", "take it from `airside blob inspect` or from the key's file name");
    }
    std::ranges::transform(line, line.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    ids.push_back(line);
  }
  return ids;
}

}  // namespace

std::string hex_of(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t b : bytes) text += fmt::format("{:02x}", b);
  return text;
}

SecretKey make_key(const std::string& name) {
  need_sodium();
  SecretKey key;
  crypto_sign_keypair(key.open.bytes.data(), key.bytes.data());
  key.open.id = id_of(key.open.bytes);
  key.open.name = name;
  return key;
}

std::string public_key_text(const PublicKey& key) {
  return fmt::format("{} {} {}\n", public_word, hex_of(key.bytes), key.name);
}

std::string secret_key_text(const SecretKey& key) {
  return fmt::format("{} {} {}\n", secret_word, hex_of(key.bytes), key.open.name);
}

PublicKey read_public_key(const std::string& path) {
  PublicKey key;
  key.name = read_key(path, public_word, key.bytes);
  key.id = id_of(key.bytes);
  return key;
}

SecretKey read_secret_key(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & 077) != 0) {
    throw InputError(path, fmt::format("permissions {:o}", status.st_mode & 0777U),
                     "a file that only its owner may read",
                     "chmod 600 it, and make a new key if somebody else may have read it");
  }
  need_sodium();
  SecretKey key;
  key.open.name = read_key(path, secret_word, key.bytes);
  crypto_sign_ed25519_sk_to_pk(key.open.bytes.data(), key.bytes.data());
  key.open.id = id_of(key.open.bytes);
  return key;
}

KeyRing KeyRing::load(const std::string& dir) {
  need_sodium();
  KeyRing ring;
  std::error_code none;
  if (dir.empty() || !fs::is_directory(dir, none)) return ring;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(dir)) {
    if (entry.path().extension() == ".pub") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  if (files.size() > max_keys) {
    throw InputError(dir, fmt::format("{} keys", files.size()), fmt::format("at most {}", max_keys),
                     "remove those of people who send no weights any more");
  }
  for (const fs::path& file : files) ring.add(read_public_key(file.string()));
  const std::vector<std::string> revoked = revoked_ids(fs::path(dir) / "revoked");
  for (PublicKey& key : ring.keys_) key.revoked = std::ranges::count(revoked, hex_of(key.id)) != 0;
  return ring;
}

const PublicKey* KeyRing::find(const KeyId& id) const {
  const auto at = std::ranges::find(keys_, id, &PublicKey::id);
  return at == keys_.end() ? nullptr : &*at;
}

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
