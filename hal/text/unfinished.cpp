#include "hal/text/unfinished.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

namespace airside::hal {
namespace {

constexpr int most_unfinished = 256;
constexpr int most_depth = 8, most_passes = 8;
constexpr int patience_ms = 5000, look_ms = 10;
constexpr int ending_signals[] = {SIGINT, SIGTERM, SIGHUP};

// Whoever takes a text out of its slot owns it; the handler never gives one back.
std::array<std::atomic<char*>, most_unfinished> unfinished_paths{};
std::array<std::atomic<pid_t>, most_unfinished> unfinished_children{};
static_assert(std::atomic<char*>::is_always_lock_free && std::atomic<pid_t>::is_always_lock_free);

template <class Value>
int occupy(std::array<std::atomic<Value>, most_unfinished>& table, Value value) {
  for (int i = 0; i < most_unfinished; ++i) {
    Value none{};
    if (table[static_cast<std::size_t>(i)].compare_exchange_strong(none, value)) return i;
  }
  return -1;
}

// From here to the handler: async-signal-safe calls only, so no opendir() and no allocation.

void remove_at(int folder, const char* name, int depth);

bool is_entry(const char* name) { return std::strcmp(name, ".") != 0 && std::strcmp(name, "..") != 0; }

/// Removes what lies in an open folder. Removing while reading may skip entries: passes until one finds nothing.
void empty_folder(int folder, int depth) {
  alignas(dirent64) std::array<char, 4096> buffer{};
  bool found = true;
  for (int pass = 0; found && pass < most_passes && ::lseek(folder, 0, SEEK_SET) == 0; ++pass) {
    found = false;
    for (long got = 0; (got = ::syscall(SYS_getdents64, folder, buffer.data(), buffer.size())) > 0;) {
      for (long at = 0; at < got;) {
        const auto* entry = reinterpret_cast<const dirent64*>(buffer.data() + at);
        at += entry->d_reclen;
        if (!is_entry(entry->d_name)) continue;
        found = true;
        remove_at(folder, entry->d_name, depth + 1);
      }
    }
  }
}

void remove_at(int folder, const char* name, int depth) {
  if (::unlinkat(folder, name, 0) == 0 || (errno != EISDIR && errno != EPERM) || depth > most_depth) return;
  const int inside = ::openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (inside < 0) return;
  empty_folder(inside, depth);
  ::close(inside);
  ::unlinkat(folder, name, AT_REMOVEDIR);
}

bool ended(pid_t child) {
  const pid_t found = ::waitpid(child, nullptr, WNOHANG);
  return found > 0 || (found < 0 && errno == ECHILD);
}

void end_children() {
  std::array<pid_t, most_unfinished> running{};
  int count = 0;
  for (auto& child : unfinished_children) {
    if (const pid_t pid = child.exchange(0); pid > 0) running[static_cast<std::size_t>(count++)] = pid;
  }
  for (int i = 0; i < count; ++i) ::kill(running[static_cast<std::size_t>(i)], SIGTERM);
  for (int waited_ms = 0; count > 0; waited_ms += look_ms) {
    for (int i = count; i-- > 0;) {
      pid_t& child = running[static_cast<std::size_t>(i)];
      if (waited_ms >= patience_ms) {
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
        child = running[static_cast<std::size_t>(--count)];
      } else if (ended(child)) {
        child = running[static_cast<std::size_t>(--count)];
      }
    }
    if (count > 0) ::poll(nullptr, 0, look_ms);
  }
}

extern "C" void clean_up_and_end(int number) {
  end_children();
  for (auto& path : unfinished_paths) {
    if (const char* text = path.exchange(nullptr); text != nullptr) remove_at(AT_FDCWD, text, 0);
  }
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  ::sigaction(number, &usual, nullptr);
  ::raise(number);  // blocked while this runs: it ends the process at the return
}

}  // namespace

UnfinishedPath::UnfinishedPath(const std::string& path) {
  std::error_code ignored;
  const std::string whole = std::filesystem::absolute(path, ignored).string();
  char* text = ::strdup(ignored ? path.c_str() : whole.c_str());
  if (text == nullptr) return;
  slot_ = occupy(unfinished_paths, text);
  if (slot_ < 0) std::free(text);
}

void UnfinishedPath::release() {
  if (slot_ < 0) return;
  std::free(unfinished_paths[static_cast<std::size_t>(std::exchange(slot_, -1))].exchange(nullptr));
}

UnfinishedChild::UnfinishedChild(pid_t pid) : slot_(occupy(unfinished_children, pid)) {}

UnfinishedChild::UnfinishedChild(UnfinishedChild&& other) noexcept : slot_(std::exchange(other.slot_, -1)) {}

UnfinishedChild& UnfinishedChild::operator=(UnfinishedChild&& other) noexcept {
  release();
  slot_ = std::exchange(other.slot_, -1);
  return *this;
}

void UnfinishedChild::release() {
  if (slot_ >= 0) unfinished_children[static_cast<std::size_t>(std::exchange(slot_, -1))].store(0);
}

void clean_up_on_signals() {
  struct sigaction action {};
  action.sa_handler = clean_up_and_end;
  ::sigemptyset(&action.sa_mask);
  for (const int number : ending_signals) ::sigaddset(&action.sa_mask, number);
  for (const int number : ending_signals) {
    struct sigaction before {};
    if (::sigaction(number, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) {
      ::sigaction(number, &action, nullptr);
    }
  }
}

void forget_unfinished() {
  for (auto& path : unfinished_paths) path.store(nullptr);
  for (auto& child : unfinished_children) child.store(0);
}

}  // namespace airside::hal
