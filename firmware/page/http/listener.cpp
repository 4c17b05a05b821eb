#include "firmware/page/http/listener.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>

#include "hal/modbus/wire.hpp"
#include "hal/text/input_error.hpp"

namespace airside::page {
namespace {

PeerAddress address_of(const sockaddr_storage& storage) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  PeerAddress address;
  if (storage.ss_family == AF_INET) {
    const auto& four = reinterpret_cast<const sockaddr_in&>(storage);
    address.bytes[10] = address.bytes[11] = 0xFF;
    std::memcpy(address.bytes.data() + 12, &four.sin_addr, 4);
    ::inet_ntop(AF_INET, &four.sin_addr, text.data(), text.size());
  } else if (storage.ss_family == AF_INET6) {
    const auto& six = reinterpret_cast<const sockaddr_in6&>(storage);
    std::memcpy(address.bytes.data(), &six.sin6_addr, address.bytes.size());
    ::inet_ntop(AF_INET6, &six.sin6_addr, text.data(), text.size());
  }
  address.text = text.data();
  return address;
}

}  // namespace

Listener::Listener(const std::string& address, int port) {
  sockaddr_in four{};
  sockaddr_in6 six{};
  four.sin_family = AF_INET;
  six.sin6_family = AF_INET6;
  four.sin_port = six.sin6_port = htons(static_cast<std::uint16_t>(port));
  const bool is_four = ::inet_pton(AF_INET, address.c_str(), &four.sin_addr) == 1;
  if (!is_four) ::inet_pton(AF_INET6, address.c_str(), &six.sin6_addr);
  auto* at = is_four ? reinterpret_cast<sockaddr*>(&four) : reinterpret_cast<sockaddr*>(&six);
  socklen_t size = is_four ? sizeof four : sizeof six;
  socket_ = hal::StorageFile(::socket(is_four ? AF_INET : AF_INET6, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int fd = socket_.descriptor(), on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (fd < 0 || ::bind(fd, at, size) != 0 || ::listen(fd, max_waiting) != 0) {
    throw hal::InputError(fmt::format("[page] listen {} port {}", address, port), std::strerror(errno),
                          "an address of this machine and a free port", "correct them in the site file");
  }
  ::getsockname(fd, at, &size);
  port_ = ntohs(is_four ? four.sin_port : six.sin6_port);
}

std::optional<Newcomer> Listener::accept() const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  hal::StorageFile socket(
      ::accept4(socket_.descriptor(), reinterpret_cast<sockaddr*>(&address), &size, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket.is_open()) return std::nullopt;
  return Newcomer{std::move(socket), address_of(address), hal::monotonic_ns()};
}

std::string local_address_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  return address_of(address).text;
}

}  // namespace airside::page
