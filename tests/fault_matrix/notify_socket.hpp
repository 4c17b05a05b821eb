#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace airside::fault_matrix {

/// The service manager's end of NOTIFY_SOCKET, named in this process's environment while it lives.
class NotifySocket {
 public:
  explicit NotifySocket(const std::filesystem::path& path, double watchdog_s) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string text = path.string();
    if (text.size() >= sizeof address.sun_path) throw std::runtime_error("too long: " + text);
    std::memcpy(address.sun_path, text.data(), text.size());
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      throw std::runtime_error("bind " + text);
    }
    ::setenv("NOTIFY_SOCKET", text.c_str(), 1);
    ::setenv("WATCHDOG_USEC", std::to_string(static_cast<long>(watchdog_s * 1e6)).c_str(), 1);
  }
  ~NotifySocket() {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
    ::close(socket_);
  }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  /// The next word, or "" when none came for so long.
  std::string next(double timeout_s) const {
    pollfd wait{socket_, POLLIN, 0};
    if (::poll(&wait, 1, static_cast<int>(timeout_s * 1e3)) <= 0) return "";
    char word[256];
    const ssize_t n = ::recv(socket_, word, sizeof word, 0);
    return n > 0 ? std::string(word, static_cast<std::size_t>(n)) : "";
  }

 private:
  int socket_ = -1;
};

}  // namespace airside::fault_matrix
