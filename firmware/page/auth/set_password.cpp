#include "firmware/page/auth/set_password.hpp"

#include <fmt/format.h>
#include <sodium.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <iostream>

#include "firmware/page/auth/access_file.hpp"
#include "firmware/page/auth/sessions.hpp"
#include "hal/text/input_error.hpp"

namespace airside::page {
namespace {

constexpr std::size_t min_characters = 10, max_characters = 512;

/// A line without echo.
std::string ask(const char* question) {
  std::fputs(question, stderr);
  termios before{};
  ::tcgetattr(STDIN_FILENO, &before);
  termios quiet = before;
  quiet.c_lflag &= ~static_cast<tcflag_t>(ECHO);
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &quiet);
  std::string line;
  std::getline(std::cin, line);
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before);
  std::fputc('\n', stderr);
  return line;
}

std::string read_password() {
  std::string password;
  if (::isatty(STDIN_FILENO) == 1) {
    password = ask("Password: ");
    if (ask("Once more: ") != password) {
      throw hal::InputError("password", "two that differ", "the same twice", "type them again");
    }
  } else {
    std::getline(std::cin, password);
  }
  if (password.ends_with('\r')) password.pop_back();
  if (password.size() < min_characters || password.size() > max_characters) {
    throw hal::InputError("password", fmt::format("{} bytes", password.size()),
                          fmt::format("{} to {} bytes on one line", min_characters, max_characters),
                          "three or four words that do not belong together are easy to keep in mind");
  }
  return password;
}

/// The folder of a page that has never run.
void make_folder(const std::string& dir) {
  if (::mkdir(dir.c_str(), 0700) == 0 || errno == EEXIST) return;
  throw hal::InputError(dir, "a folder that cannot be made", "[page] dir of the site file, a folder of the page's own",
                        "run it as root, or as the user of airside-page");
}

}  // namespace

void set_password(const std::string& dir, Role role) {
  make_folder(dir);
  Access access = read_access(dir);
  std::string password = read_password();
  access.password[static_cast<std::size_t>(role)] = hash_of_password(password);
  sodium_memzero(password.data(), password.size());
  write_access(dir, access);
  std::fprintf(stderr, "airside-page: the password of the %s is set; who had signed in must do so again\n",
               text_of(role));
}

void clear_password(const std::string& dir, Role role) {
  Access access = read_access(dir);
  access.password[static_cast<std::size_t>(role)].clear();
  write_access(dir, access);
  std::fprintf(stderr, "airside-page: the %s has no password now\n", text_of(role));
}

void new_key(const std::string& dir, Role role, const std::string& name) {
  make_folder(dir);
  Access access = read_access(dir);
  if (access.keys.size() == Access::max_keys) {
    throw hal::InputError(dir + "/" + Access::file_name, fmt::format("{} keys", Access::max_keys), "fewer",
                          "strike the lines of keys that nobody uses");
  }
  const std::string key = random_hex(32);
  std::string shown = name.substr(0, 60);
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20) c = '?';
  }
  access.keys.push_back({role, digest_of_key(key), shown});
  write_access(dir, access);
  std::printf("%s\n", key.c_str());
  std::fprintf(stderr,
               "airside-page: a key with the rights of the %s, shown this once. A program sends it as\n"
               "  Authorization: Bearer KEY\n",
               text_of(role));
}

}  // namespace airside::page
