#include "firmware/page/auth/access_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <span>
#include <stdexcept>

#include "hal/storage/storage_file.hpp"
#include "hal/text/input_error.hpp"

namespace airside::page {
namespace {

constexpr unsigned long long hash_passes = 2;
constexpr std::size_t hash_memory_bytes = 19u << 20;

bool is_hex(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

std::string_view take_word(std::string_view& line) {
  const std::string_view word = line.substr(0, line.find(' '));
  line.remove_prefix(std::min(line.size(), word.size() + 1));
  return word;
}

/// False: the line is none of ours.
bool read_line(std::string_view line, Access& access) {
  const std::string_view kind = take_word(line);
  const Role role = role_of(take_word(line));
  if (role == Role::none) return false;
  if (kind == "password") {
    std::string& place = access.password[static_cast<std::size_t>(role)];
    if (!place.empty() || !line.starts_with("$argon2id$") || line.size() >= crypto_pwhash_STRBYTES) return false;
    place = line;
    return true;
  }
  const std::string_view digest = take_word(line);
  if (kind != "key" || digest.size() != 64 || !is_hex(digest) || access.keys.size() == Access::max_keys) return false;
  access.keys.push_back({role, std::string(digest), std::string(line)});
  return true;
}

/// Of a hash: what it has to begin with, a number, bytes as base64. False: it does not.
bool take(std::string_view& rest, std::string_view words) {
  const bool good = rest.starts_with(words);
  if (good) rest.remove_prefix(words.size());
  return good;
}
bool take(std::string_view& rest, unsigned& number) {
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return error == std::errc{};
}
bool take(std::string_view& rest, std::span<unsigned char> bytes) {
  std::size_t got = 0;
  const char* end = rest.data();
  const bool good = sodium_base642bin(bytes.data(), bytes.size(), rest.data(), rest.size(), nullptr, &got, &end,
                                      sodium_base64_VARIANT_ORIGINAL_NO_PADDING) == 0;
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return good && got == bytes.size();
}

void start_sodium() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium finds no source of random numbers");
}

}  // namespace

bool Access::has_password() const {
  return std::ranges::any_of(password, [](const std::string& hash) { return !hash.empty(); });
}

Rights Access::of_anybody() const {
  if (!has_password() && keys.empty()) return {.see = true, .operate = false, .install = true};
  const bool closed = !password[static_cast<std::size_t>(Role::viewer)].empty();
  return {.see = !closed, .operate = false, .install = false};
}

const AccessKey* Access::find_key(std::string_view key) const {
  if (key.size() != 64 || !is_hex(key)) return nullptr;
  const std::string digest = digest_of_key(key);
  const AccessKey* found = nullptr;
  for (const AccessKey& k : keys) {
    if (sodium_memcmp(k.digest.data(), digest.data(), digest.size()) == 0) found = &k;
  }
  return found;
}

std::string Access::text() const {
  std::string out = std::string(first_line) + "\n";
  for (const Role role : {Role::viewer, Role::operator_, Role::installer}) {
    const std::string& hash = password[static_cast<std::size_t>(role)];
    if (!hash.empty()) out += fmt::format("password {} {}\n", text_of(role), hash);
  }
  for (const AccessKey& key : keys) out += fmt::format("key {} {} {}\n", text_of(key.role), key.digest, key.name);
  return out;
}

std::string hash_of_password(const std::string& password) {
  start_sodium();
  std::array<char, crypto_pwhash_STRBYTES> hash{};
  if (crypto_pwhash_str(hash.data(), password.data(), password.size(), hash_passes, hash_memory_bytes) != 0) {
    throw std::runtime_error("no memory for the hash of a password (19 MiB)");
  }
  return hash.data();
}

/// By hand, since crypto_pwhash_str_verify gives one answer for a wrong password and for too little memory.
bool is_password(const std::string& password, const std::string& hash) {
  start_sodium();
  std::string_view rest = hash;
  unsigned memory_kib = 0, passes = 0;
  std::array<unsigned char, crypto_pwhash_SALTBYTES> salt{};
  std::array<unsigned char, 32> digest{}, made{};
  const bool is_ours = take(rest, "$argon2id$v=19$m=") && take(rest, memory_kib) && take(rest, ",t=") &&
                       take(rest, passes) && take(rest, ",p=1$") && take(rest, salt) && take(rest, "$") &&
                       take(rest, digest) && rest.empty();
  if (!is_ours) return false;
  if (crypto_pwhash(made.data(), made.size(), password.data(), password.size(), salt.data(), passes,
                    std::size_t{memory_kib} * 1024, crypto_pwhash_ALG_ARGON2ID13) != 0) {
    throw std::runtime_error("no memory to verify a password");
  }
  return sodium_memcmp(made.data(), digest.data(), digest.size()) == 0;
}

std::string digest_of_key(std::string_view key) {
  std::array<unsigned char, 32> digest{};
  crypto_generichash(digest.data(), digest.size(), reinterpret_cast<const unsigned char*>(key.data()), key.size(),
                     nullptr, 0);
  std::array<char, 65> hex{};
  sodium_bin2hex(hex.data(), hex.size(), digest.data(), digest.size());
  return hex.data();
}

Access read_access(const std::string& dir) {
  const std::string path = dir + "/" + Access::file_name;
  const hal::StorageFile file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (!file.is_open() && errno == ENOENT) return {};
  struct stat status {};
  if (!file.is_open() || ::fstat(file.descriptor(), &status) != 0 || !S_ISREG(status.st_mode)) {
    throw hal::InputError(path, "no file that this user may read", "the passwords of the page",
                          "let it belong to the user of airside-page, or take it away");
  }
  if ((status.st_mode & 077) != 0) {
    throw hal::InputError(path, fmt::format("permissions {:o}", status.st_mode & 0777U),
                          "a file that only its owner may read", "chmod 600 it");
  }
  std::string text(static_cast<std::size_t>(std::min<off_t>(status.st_size, Access::max_bytes)), '\0');
  const auto got = file.read_at(std::as_writable_bytes(std::span(text)), 0, "read access");
  const bool whole = got && *got == text.size() && text.ends_with('\n');
  Access access;
  int number = 0;
  for (std::string_view rest = text; !rest.empty(); ++number) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    const bool good = number == 0 ? line == Access::first_line : read_line(line, access);
    if (whole && good) continue;
    throw hal::InputError(fmt::format("{}:{}", path, number + 1), "a line that airside-page did not write",
                          "password ROLE HASH or key ROLE DIGEST NAME",
                          "take the file away and set the passwords anew: airside-page --set-password operator");
  }
  if (number == 0) {
    throw hal::InputError(path, "an empty file", Access::first_line, "take it away, and set the passwords anew");
  }
  return access;
}

void write_access(const std::string& dir, const Access& access) {
  const std::string path = dir + "/" + Access::file_name, staged = path + ".new";
  const auto refuse = [&path](const char* what) {
    throw hal::InputError(path, std::string("a file that cannot be written: ") + what,
                          "a folder that this user may write", "run it as root, or as the user of airside-page");
  };
  struct stat folder {};
  if (::stat(dir.c_str(), &folder) != 0 || !S_ISDIR(folder.st_mode)) refuse("no such folder");
  ::unlink(staged.c_str());
  const hal::StorageFile file(::open(staged.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!file.is_open()) refuse("it cannot be made");
  if (::geteuid() == 0 && ::fchown(file.descriptor(), folder.st_uid, folder.st_gid) != 0) refuse("no right to give it");
  const std::string text = access.text();
  if (!file.write_at(std::as_bytes(std::span(text)), 0, "write access") || !file.sync(hal::Sync::full, "sync access")) {
    ::unlink(staged.c_str());
    refuse("the disk refuses it");
  }
  if (::rename(staged.c_str(), path.c_str()) != 0) refuse("it cannot be replaced");
  // Without this a power cut may bring the old password back.
  const hal::StorageFile names(::open(dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!names.is_open() || ::fsync(names.descriptor()) != 0) refuse("the disk may forget it at a power cut");
}

bool AccessWatch::refresh() {
  struct stat status {};
  const std::string path = dir_ + "/" + Access::file_name;
  std::array<std::int64_t, 3> seen{0, 0, 0};
  if (::lstat(path.c_str(), &status) == 0) {
    seen = {static_cast<std::int64_t>(status.st_ino),
            std::int64_t{status.st_ctim.tv_sec} * 1'000'000'000 + status.st_ctim.tv_nsec,
            static_cast<std::int64_t>(status.st_size)};
  }
  if (seen == seen_) return false;
  seen_ = seen;
  ++generation_;
  try {
    access_ = read_access(dir_);
    trouble_.clear();
  } catch (const hal::InputError& unread) {
    access_ = {};
    trouble_ = unread.what();
  }
  return true;
}

}  // namespace airside::page
