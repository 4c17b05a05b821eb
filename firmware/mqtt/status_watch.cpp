#include "firmware/mqtt/status_watch.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

namespace airside::mqtt {

namespace {

constexpr double old_after_s = 900;  // as `airside status` has it; the box writes every 6 min
constexpr std::size_t most_bytes = 65536;

struct Descriptor {
  explicit Descriptor(int number) : value(number) {}
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int value;
};

/// Everything up to most_bytes + 1.
std::string read_all(int descriptor) {
  std::string text;
  std::array<char, 4096> some{};
  while (text.size() <= most_bytes) {
    const ssize_t got = ::read(descriptor, some.data(), some.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    text.append(some.data(), static_cast<std::size_t>(got));
  }
  return text;
}

}  // namespace

void StatusWatch::refuse(std::string complaint) { complaint_ = std::move(complaint); }

void StatusWatch::poll(double now_s) {
  // Never a link, and never a pipe that would be waited for.
  const Descriptor file(::open(path_.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (file.value < 0 || ::fstat(file.value, &status) != 0) return refuse(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return refuse("no regular file");
  const std::timespec changed = status.st_mtim;
  if (status.st_ino == inode_ && changed.tv_sec == changed_.tv_sec && changed.tv_nsec == changed_.tv_nsec) return;
  std::string text = read_all(file.value);
  if (text.size() > most_bytes) return refuse("more than 64 KiB");
  const nlohmann::json parsed = nlohmann::json::parse(text, nullptr, false);
  if (!parsed.is_object() || !parsed.contains("state")) return refuse("no JSON object with a state");
  inode_ = status.st_ino;
  changed_ = changed;
  seen_s_ = now_s;
  const auto stopped = parsed.find("stopped");
  stopped_ = stopped != parsed.end() && stopped->is_boolean() && stopped->get<bool>();
  while (!text.empty() && text.back() == '\n') text.pop_back();
  text_ = std::move(text);
  complaint_.clear();
  ++version_;
}

bool StatusWatch::is_current(double now_s) const {
  if (version_ == 0 || stopped_ || !complaint_.empty()) return false;
  // By the file's time where the clock is right; by our own patience where somebody has set it.
  const auto age_s = static_cast<double>(std::time(nullptr) - changed_.tv_sec);
  return age_s < old_after_s && now_s - seen_s_ < old_after_s;
}

}  // namespace airside::mqtt
