#include "hal/modbus/wire.hpp"

#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>

namespace airside::hal {
namespace {

/// Waits for `events`. done: something can be done or must be looked at; timed_out; closed: the wait failed.
WireResult wait_for(int fd, short events, std::int64_t deadline_ns) {
  while (true) {
    const std::int64_t left = deadline_ns - monotonic_ns();
    if (left <= 0) return WireResult::timed_out;
    const timespec timeout = {static_cast<std::time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
    pollfd entry = {fd, events, 0};
    const int ready = ppoll(&entry, 1, &timeout, nullptr);
    if (ready > 0) return WireResult::done;
    if (ready < 0 && errno != EINTR) return WireResult::closed;
  }
}

/// A socket must not raise SIGPIPE and must not block; a serial line knows neither flag.
ssize_t send_some(int fd, std::span<const std::uint8_t> bytes) {
  const ssize_t sent = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (sent >= 0 || errno != ENOTSOCK) return sent;
  return ::write(fd, bytes.data(), bytes.size());
}

ssize_t receive_some(int fd, std::span<std::uint8_t> bytes) {
  const ssize_t got = ::recv(fd, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (got >= 0 || errno != ENOTSOCK) return got;
  return ::read(fd, bytes.data(), bytes.size());
}

static_assert(EAGAIN == EWOULDBLOCK);
bool try_again() { return errno == EINTR || errno == EAGAIN; }

}  // namespace

std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

WireResult send_all(int fd, std::span<const std::uint8_t> bytes, std::int64_t deadline_ns) {
  while (!bytes.empty()) {
    const WireResult ready = wait_for(fd, POLLOUT, deadline_ns);
    if (ready != WireResult::done) return ready;
    const ssize_t sent = send_some(fd, bytes);
    if (sent < 0 && !try_again()) return WireResult::closed;
    if (sent > 0) bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
  return WireResult::done;
}

WireResult receive_exact(int fd, std::span<std::uint8_t> bytes, std::int64_t deadline_ns, std::size_t& received) {
  received = 0;
  while (received < bytes.size()) {
    const WireResult ready = wait_for(fd, POLLIN, deadline_ns);
    if (ready != WireResult::done) return ready;
    const ssize_t got = receive_some(fd, bytes.subspan(received));
    if (got == 0 || (got < 0 && !try_again())) return WireResult::closed;
    if (got > 0) received += static_cast<std::size_t>(got);
  }
  return WireResult::done;
}

IdleState idle_state(int fd) {
  pollfd entry = {fd, POLLIN, 0};
  const int ready = poll(&entry, 1, 0);
  if (ready == 0) return IdleState::silent;
  if (ready < 0) return errno == EINTR ? IdleState::silent : IdleState::closed;
  if ((entry.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) return IdleState::closed;
  int waiting = 0;
  if (ioctl(fd, FIONREAD, &waiting) < 0 || waiting == 0) return IdleState::closed;
  return IdleState::bytes_waiting;
}

bool drain_until_silent(int fd, std::int64_t silence_ns, std::int64_t deadline_ns) {
  std::array<std::uint8_t, 64> dropped{};
  while (true) {
    const std::int64_t silent_at = monotonic_ns() + silence_ns;
    if (silent_at > deadline_ns) return false;
    const WireResult heard = wait_for(fd, POLLIN, silent_at);
    if (heard == WireResult::timed_out) return true;
    if (heard == WireResult::closed) return false;
    const ssize_t got = receive_some(fd, dropped);
    if (got == 0 || (got < 0 && !try_again())) return false;
  }
}

std::uint16_t crc16(std::span<const std::uint8_t> bytes) {
  std::uint16_t crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ byte);
    for (int bit = 0; bit < 8; ++bit) {
      const bool carry = (crc & 1U) != 0;
      crc = static_cast<std::uint16_t>(crc >> 1);
      if (carry) crc = static_cast<std::uint16_t>(crc ^ 0xA001U);
    }
  }
  return crc;
}

}  // namespace airside::hal
