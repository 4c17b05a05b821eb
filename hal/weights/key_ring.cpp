#include "hal/weights/key_ring.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "hal/storage/folder_names.hpp"
#include "hal/storage/storage_file.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"

namespace airside::hal {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view public_word = "airside-public-key-1", secret_word = "airside-secret-key-1";
constexpr const char* revoked_name = "revoked";
constexpr const char* counters_name = "counters";
static_assert(sizeof(PublicKey::bytes) == crypto_sign_PUBLICKEYBYTES);
static_assert(sizeof(SecretKey::bytes) == crypto_sign_SECRETKEYBYTES);

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

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// The word at the front of `line`, which is moved behind it and the blanks that follow.
std::string_view take_word(std::string_view& line) {
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  const std::size_t end = std::min(line.size(), line.find_first_of(" \t\r"));
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(end);
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
  return word;
}

std::string_view first_line(std::string_view text) { return text.substr(0, text.find('\n')); }

/// A key file's one line, taken apart.
struct KeyLine {
  std::string_view word, hex, name;
  explicit KeyLine(std::string_view text) {
    name = first_line(text);
    word = take_word(name);
    hex = take_word(name);
  }
};

/// Whether `hex` is just as many bytes as `bytes` has.
bool read_hex(std::string_view hex, std::span<std::uint8_t> bytes) {
  return hex.size() == 2 * bytes.size() &&
         sodium_hex2bin(bytes.data(), bytes.size(), hex.data(), hex.size(), nullptr, nullptr, nullptr) == 0;
}

constexpr std::size_t key_file_bytes = 512, list_file_bytes = 16384;

void refuse_longer(const std::string& path, const std::string& text, std::size_t most) {
  if (text.size() <= most) return;
  throw InputError(path, fmt::format("{} bytes", text.size()), fmt::format("at most {}", most),
                   "a box would not read it; leave out what is no key");
}

template <std::size_t N>
KeyName read_key(const std::string& path, std::string_view word, std::array<std::uint8_t, N>& bytes) {
  const std::string text = read_text_file(path, "a key file that `airside keygen` wrote");
  refuse_longer(path, text, key_file_bytes);
  const KeyLine line(text);
  if (line.word != word) {
    throw InputError(path + ":1", fmt::format("\"{}\"", line.word.substr(0, 40)), fmt::format("the word {}", word),
                     "give the .pub file to boxes and the .key file to `airside sign`");
  }
  if (!read_hex(line.hex, bytes)) {
    throw InputError(path + ":1", fmt::format("a key of {} characters", line.hex.size()),
                     fmt::format("{} hex digits", 2 * N), "copy the file again, whole");
  }
  return KeyName(line.name);
}

/// Calls `take(id, rest)` for each line of a list of key ids. Returns the number of the first line that has none or
/// whose rest is not taken, 0 for a good list.
template <class Take>
int read_id_list(std::string_view text, const Take& take) {
  for (int number = 1; !text.empty(); ++number) {
    std::string_view line = first_line(text);
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    line = line.substr(0, line.find('#'));
    const std::string_view id = take_word(line);
    if (id.empty()) continue;
    KeyId key{};
    if (!read_hex(id, key) || !take(key, line)) return number;
  }
  return 0;
}

/// As read_id_list, of lines that hold the id alone.
template <class Take>
int read_revoked(std::string_view text, const Take& take) {
  return read_id_list(text, [&take](const KeyId& id, std::string_view rest) {
    if (rest.empty()) take(id);
    return rest.empty();
  });
}

/// As read_id_list, of lines with a counter behind the id.
template <class Take>
int read_counters(std::string_view text, const Take& take) {
  return read_id_list(text, [&take](const KeyId& id, std::string_view rest) {
    std::uint64_t counter = 0;
    const auto read = std::from_chars(rest.data(), rest.data() + rest.size(), counter);
    if (rest.empty() || read.ec != std::errc() || read.ptr != rest.data() + rest.size()) return false;
    take(id, counter);
    return true;
  });
}

/// The bytes of a small file, read to `buffer`. -1: none that can be read; longer than the buffer is not whole.
long read_small(int dir_fd, const char* name, std::span<char> buffer) {
  const StorageFile file(::openat(dir_fd, name, O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open()) return -1;
  if (::fstat(file.descriptor(), &status) != 0) return -1;  // uncovered: an open file has a status
  if (!S_ISREG(status.st_mode)) return -1;
  if (static_cast<std::uint64_t>(status.st_size) > buffer.size()) return -1;
  const auto got = file.read_at(std::as_writable_bytes(buffer), 0, "read key");
  return got ? static_cast<long>(*got) : -1;  // uncovered: a medium that fails between opening and reading
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
  key.open.name = KeyName(name);
  return key;
}

std::string public_key_text(const PublicKey& key) {
  return fmt::format("{} {} {}\n", public_word, hex_of(key.bytes), key.name.view());
}

std::string secret_key_text(const SecretKey& key) {
  return fmt::format("{} {} {}\n", secret_word, hex_of(key.bytes), key.open.name.view());
}

PublicKey read_public_key(const std::string& path) {
  PublicKey key;
  key.name = read_key(path, public_word, key.bytes);
  key.id = id_of(key.bytes);
  return key;
}

SecretKey read_secret_key(const std::string& path) {
  need_sodium();
  SecretKey key;
  key.open.name = read_key(path, secret_word, key.bytes);  // of another kind of file: before its permissions
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & 077) != 0) {
    throw InputError(path, fmt::format("permissions {:o}", status.st_mode & 0777U),
                     "a file that only its owner may read",
                     "chmod 600 it, and make a new key if somebody else may have read it");
  }
  crypto_sign_ed25519_sk_to_pk(key.open.bytes.data(), key.bytes.data());
  key.open.id = id_of(key.open.bytes);
  return key;
}

bool KeyRing::add(const PublicKey& key) {
  if (size_ == max_keys) return false;
  keys_[size_++] = key;
  return true;
}

void KeyRing::revoke(const KeyId& id) {
  for (PublicKey& key : keys_) {
    if (key.id == id) key.revoked = true;
  }
}

void KeyRing::give_counter(const KeyId& id, std::uint64_t counter) {
  for (PublicKey& key : keys_) {
    if (key.id != id) continue;
    key.last_counter = std::max(counter, key.last_counter);  // of two lines the stricter one
    key.counter_given = true;
  }
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
  const auto text_of_list = [&dir](const char* name, const char* what) {
    const fs::path list = fs::path(dir) / name;
    if (!fs::exists(list)) return std::string();
    std::string text = read_text_file(list.string(), what);
    refuse_longer(list.string(), text, list_file_bytes);
    return text;
  };
  const std::string revoked = text_of_list(revoked_name, "key ids in hex, one a line");
  if (const int bad = read_revoked(revoked, [&ring](const KeyId& id) { ring.revoke(id); }); bad != 0) {
    throw InputError(fmt::format("{}/{}:{}", dir, revoked_name, bad), "a line that is none",
                     "a key id of 16 hex digits",
                     "take it from `airsided --check`, which lists the keys, or from `airside blob inspect`");
  }
  const std::string counters = text_of_list(counters_name, "key ids in hex, each with a counter, one a line");
  const auto give = [&ring](const KeyId& id, std::uint64_t counter) { ring.give_counter(id, counter); };
  if (const int bad = read_counters(counters, give); bad != 0) {
    throw InputError(fmt::format("{}/{}:{}", dir, counters_name, bad), "a line that is none",
                     "a key id of 16 hex digits and the last counter that was taken from it",
                     "take both from `airside blob inspect` of the last blob that was pushed");
  }
  return ring;
}

std::string describe(const KeyRing& ring) {
  if (ring.size() == 0) return "no keys: this box takes no pushed weights";
  std::string text;
  for (const PublicKey& key : ring.keys()) {
    text += fmt::format("{}{} ({}{})", text.empty() ? "" : ", ", hex_of(key.id), key.name.view(),
                        key.revoked ? ", revoked" : "");
  }
  return text;
}

const char* KeyRing::revoke_listed(int dir_fd) {
  struct stat status {};
  if (::fstatat(dir_fd, revoked_name, &status, 0) != 0 && errno == ENOENT) return nullptr;
  std::array<char, list_file_bytes> text;
  const long got = read_small(dir_fd, revoked_name, text);
  if (got < 0) return "cannot be read, or is longer than 16 kB: no key is trusted";
  const int bad = read_revoked({text.data(), static_cast<std::size_t>(got)}, [this](const KeyId& id) { revoke(id); });
  return bad == 0 ? nullptr : "has a line that is no key id of 16 hex digits: no key is trusted";
}

const char* KeyRing::give_listed_counters(int dir_fd) {
  struct stat status {};
  if (::fstatat(dir_fd, counters_name, &status, 0) != 0 && errno == ENOENT) return nullptr;
  std::array<char, list_file_bytes> text;
  const long got = read_small(dir_fd, counters_name, text);
  if (got < 0) return "cannot be read, or is longer than 16 kB; left out";
  const int bad = read_counters({text.data(), static_cast<std::size_t>(got)},
                                [this](const KeyId& id, std::uint64_t counter) { give_counter(id, counter); });
  return bad == 0 ? nullptr : "has a line that is no key id with a counter; it and those behind it are left out";
}

const char* KeyRing::reload(const char* dir, Tell tell) {
  *this = {};
  need_sodium();
  const StorageFile folder(::open(dir, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.is_open()) {
    if (*dir == '\0' || errno == ENOENT) return nullptr;
    constexpr const char* closed = "cannot be opened: no key is trusted";
    tell(dir, closed);
    return closed;
  }
  const bool listed = for_each_name(folder.descriptor(), [&](const char* name) {
    if (!std::string_view(name).ends_with(".pub")) return true;
    std::array<char, key_file_bytes> text;
    const long got = read_small(folder.descriptor(), name, text);
    const KeyLine line({text.data(), static_cast<std::size_t>(std::max(got, 0L))});
    PublicKey key;
    if (line.word != public_word || !read_hex(line.hex, key.bytes)) {
      tell(name, "is no public key; left out");
      return true;
    }
    key.name = KeyName(line.name);
    key.id = id_of(key.bytes);
    if (!add(key)) tell(name, "is one more than the 16 that a box keeps; left out");
    return true;
  });
  if (const char* left_out = give_listed_counters(folder.descriptor()); left_out != nullptr)
    tell(counters_name, left_out);
  const char* wrong = revoke_listed(folder.descriptor());
  if (!listed) wrong = "stands in a folder that cannot be listed: no key is trusted";  // uncovered: one that was opened
  if (wrong == nullptr) return nullptr;
  tell(revoked_name, wrong);
  *this = {};
  return wrong;
}

const PublicKey* KeyRing::find(const KeyId& id) const {
  const auto known = keys();
  const auto at = std::ranges::find(known, id, &PublicKey::id);
  return at == known.end() ? nullptr : &*at;
}

}  // namespace airside::hal
