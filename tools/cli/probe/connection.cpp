#include "tools/cli/probe/connection.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include "hal/text/shell_word.hpp"

namespace airside::tools {

namespace {

constexpr int connect_ms = 3000, usual_port = 502;
constexpr std::array gateway_units = {"/etc/systemd/system/airside-bacnet.service",
                                      "/usr/local/lib/systemd/system/airside-bacnet.service",
                                      "/usr/lib/systemd/system/airside-bacnet.service"};

/// errno of one attempt to connect; 0: something took it.
int errno_of_connecting(const addrinfo& address) {
  const int socket = ::socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket < 0) return errno;
  int failed = ::connect(socket, address.ai_addr, address.ai_addrlen) == 0 ? 0 : errno;
  if (failed == EINPROGRESS) {
    pollfd ready{socket, POLLOUT, 0};
    socklen_t size = sizeof failed;
    if (::poll(&ready, 1, connect_ms) != 1) {
      failed = ETIMEDOUT;
    } else if (::getsockopt(socket, SOL_SOCKET, SO_ERROR, &failed, &size) != 0) {
      failed = errno;
    }
  }
  ::close(socket);
  return failed;
}

NoConnection refused_connection(const hal::SiteFile& site, const std::string& address) {
  const hal::ModbusSection& m = *site.modbus;
  const std::string found = fmt::format("connection refused by {}: nothing listens on that port there", address);
  if (site.bacnet) {
    const bool has_unit =
        std::ranges::any_of(gateway_units, [](const char* path) { return ::access(path, F_OK) == 0; });
    return {found, has_unit
                       ? "start the gateway: sudo systemctl start airside-bacnet; journalctl -u airside-bacnet says "
                         "more"
                       : "install the gateway airside-bacnet on this machine, then start it (docs/bacnet.md, Install)"};
  }
  return {
      found,
      fmt::format("see whether Modbus TCP is switched on in the device, whether it listens on port {}{}, and whether "
                  "a firewall refuses; nc -vz {} {} tries again",
                  m.port, m.port == usual_port ? ", as most do" : " (most listen on 502)", hal::shell_word(m.host),
                  m.port)};
}

std::optional<NoConnection> why_no_tcp(const hal::SiteFile& site) {
  const hal::ModbusSection& m = *site.modbus;
  const std::string address = fmt::format("{}:{}", m.host, m.port), host = hal::shell_word(m.host);
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  if (const int error = ::getaddrinfo(m.host.c_str(), std::to_string(m.port).c_str(), &wanted, &found); error != 0) {
    return NoConnection{fmt::format("{}: \"{}\" cannot be looked up ({})", m.host_place, m.host, ::gai_strerror(error)),
                        "give the numeric address, such as 192.168.1.20, or add the name to /etc/hosts"};
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses(found, &::freeaddrinfo);
  switch (const int failed = errno_of_connecting(*found)) {
    case 0: return {};
    case ECONNREFUSED: return refused_connection(site, address);
    case ETIMEDOUT:
      return NoConnection{
          fmt::format("no answer from {} within {} s", address, connect_ms / 1000),
          fmt::format("ping {}: where it answers, a firewall on the way drops port {}; else the address is another's, "
                      "or the device is off or unplugged",
                      host, m.port)};
    case EHOSTUNREACH:
    case ENETUNREACH:
      return NoConnection{
          fmt::format("no way to {} ({})", address, std::strerror(failed)),
          fmt::format("ip route get {}; see cable, address and netmask of this machine, then host in {}", host,
                      site.path)};
    default:
      return NoConnection{fmt::format("{}: {}", address, std::strerror(failed)),
                          fmt::format("ping {}; see cable, address and firewall", host)};
  }
}

std::optional<NoConnection> why_no_line(const std::string& device) {
  struct stat status {};
  if (::stat(device.c_str(), &status) != 0) {
    return NoConnection{fmt::format("{}: {}", device, std::strerror(errno)),
                        "ls /dev/serial/by-id; name one in [modbus] device"};
  }
  if (!S_ISCHR(status.st_mode)) {
    return NoConnection{device + " is no serial line", "ls /dev/serial/by-id; name one in [modbus] device"};
  }
  if (::access(device.c_str(), R_OK | W_OK) != 0) {
    return NoConnection{device + " may not be used by this user", "sudo usermod -aG dialout $USER, then log in again"};
  }
  return {};
}

}  // namespace

std::optional<NoConnection> why_no_connection(const hal::SiteFile& site) {
  const hal::ModbusSection& m = *site.modbus;
  return m.transport == hal::ModbusTransport::rtu ? why_no_line(m.device) : why_no_tcp(site);
}

}  // namespace airside::tools
