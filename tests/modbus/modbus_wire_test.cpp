// Bytes on descriptors when the system itself misbehaves: interrupted and spurious calls are tried again, everything
// else ends the exchange. The calls that fail on demand stand in for the C library's in this program.

#include "hal/modbus/wire.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdarg>

namespace {

/// What the next calls do: fail with `error` as often as `times` says; error 0 with recv means "nothing came".
struct Failing {
  int error = 0;
  int times = 0;
  bool due() {
    if (times == 0) return false;
    --times;
    errno = error;
    return true;
  }
};
Failing failing_ppoll, failing_poll, failing_send, failing_recv, failing_ioctl;

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// Names and types are the C library's.
extern "C" int ppoll(pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* mask) {
  static const auto real = next<int (*)(pollfd*, nfds_t, const timespec*, const sigset_t*)>("ppoll");
  return failing_ppoll.due() ? -1 : real(fds, count, timeout, mask);
}
extern "C" int poll(pollfd* fds, nfds_t count, int timeout) {
  static const auto real = next<int (*)(pollfd*, nfds_t, int)>("poll");
  return failing_poll.due() ? -1 : real(fds, count, timeout);
}
extern "C" ssize_t send(int fd, const void* bytes, size_t size, int flags) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t, int)>("send");
  if (!failing_send.due()) return real(fd, bytes, size, flags);
  return failing_send.error == 0 ? 0 : -1;
}
extern "C" ssize_t recv(int fd, void* bytes, size_t size, int flags) {
  static const auto real = next<ssize_t (*)(int, void*, size_t, int)>("recv");
  return failing_recv.due() ? -1 : real(fd, bytes, size, flags);
}
extern "C" int ioctl(int fd, unsigned long request, ...) noexcept {
  static const auto real = next<int (*)(int, unsigned long, void*)>("ioctl");
  va_list rest;
  va_start(rest, request);
  void* argument = va_arg(rest, void*);
  va_end(rest);
  return failing_ioctl.due() ? -1 : real(fd, request, argument);
}

namespace airside::hal {
namespace {

class Wire : public ::testing::Test {
 protected:
  Wire() { EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0); }
  ~Wire() override {
    failing_ppoll = failing_poll = failing_send = failing_recv = failing_ioctl = {};
    for (const int fd : ends) ::close(fd);
  }
  static std::int64_t soon() { return monotonic_ns() + to_ns(0.05); }
  WireResult receive() { return receive_exact(ends[0], bytes, soon(), received); }

  std::array<int, 2> ends{};
  std::array<std::uint8_t, 3> bytes{};
  const std::array<std::uint8_t, 3> sent = {7, 8, 9};
  std::size_t received = 0;
};

TEST_F(Wire, PassesBytesOn) {
  EXPECT_EQ(send_all(ends[1], sent, soon()), WireResult::done);
  EXPECT_EQ(receive(), WireResult::done);
  EXPECT_EQ(bytes, sent);
  EXPECT_EQ(send_all(ends[1], {}, soon()), WireResult::done) << "nothing to send";
}

TEST_F(Wire, GoesOnAfterInterruptedAndSpuriousCalls) {
  failing_ppoll = {EINTR, 1};
  failing_send = {EAGAIN, 1};
  EXPECT_EQ(send_all(ends[1], sent, soon()), WireResult::done);
  failing_send = {0, 1};  // nothing was taken, and no error
  EXPECT_EQ(send_all(ends[1], sent, soon()), WireResult::done);
  failing_ppoll = {EINTR, 1};
  failing_recv = {EINTR, 1};
  EXPECT_EQ(receive(), WireResult::done);
  EXPECT_EQ(bytes, sent);
}

TEST_F(Wire, EndsWhereACallFails) {
  failing_ppoll = {EINVAL, 1};
  EXPECT_EQ(send_all(ends[1], sent, soon()), WireResult::closed);
  failing_send = {EIO, 1};
  EXPECT_EQ(send_all(ends[1], sent, soon()), WireResult::closed);
  EXPECT_EQ(send_all(ends[1], sent, soon()), WireResult::done);
  failing_recv = {ECONNRESET, 1};
  EXPECT_EQ(receive(), WireResult::closed);
}

TEST_F(Wire, EndsAtTheDeadlineAndWhereThePeerHangsUp) {
  EXPECT_EQ(receive(), WireResult::timed_out);
  EXPECT_EQ(send_all(ends[1], std::span(sent).first(2), soon()), WireResult::done);
  EXPECT_EQ(receive(), WireResult::timed_out);
  EXPECT_EQ(received, 2u) << "what came is counted";
  EXPECT_EQ(send_all(ends[1], sent, monotonic_ns() - 1), WireResult::timed_out);
  ::shutdown(ends[1], SHUT_WR);
  EXPECT_EQ(receive(), WireResult::closed);
}

TEST_F(Wire, TellsWhatStandsOnAnIdleLine) {
  EXPECT_EQ(idle_state(ends[0]), IdleState::silent);
  failing_poll = {EINTR, 1};
  EXPECT_EQ(idle_state(ends[0]), IdleState::silent) << "an interrupted look has seen nothing";
  failing_poll = {ENOMEM, 1};
  EXPECT_EQ(idle_state(ends[0]), IdleState::closed);
  send_all(ends[1], sent, soon());
  EXPECT_EQ(idle_state(ends[0]), IdleState::bytes_waiting);
  failing_ioctl = {EIO, 1};
  EXPECT_EQ(idle_state(ends[0]), IdleState::closed);
  receive();
  ::shutdown(ends[1], SHUT_WR);
  EXPECT_EQ(idle_state(ends[0]), IdleState::closed) << "readable, and nothing there: it has hung up";
  ::close(ends[1]);
  ends[1] = ::dup(ends[0]);
  EXPECT_EQ(idle_state(ends[0]), IdleState::closed);
}

TEST_F(Wire, DropsBytesUntilTheLineIsSilent) {
  send_all(ends[1], sent, soon());
  EXPECT_TRUE(drain_until_silent(ends[0], to_ns(0.005), soon()));
  EXPECT_EQ(idle_state(ends[0]), IdleState::silent);
  EXPECT_FALSE(drain_until_silent(ends[0], to_ns(1), soon())) << "no time to listen for so long";
  failing_ppoll = {EINVAL, 1};
  EXPECT_FALSE(drain_until_silent(ends[0], to_ns(0.005), soon()));
  send_all(ends[1], sent, soon());
  failing_recv = {EAGAIN, 1};
  EXPECT_TRUE(drain_until_silent(ends[0], to_ns(0.005), soon()));
  send_all(ends[1], sent, soon());
  failing_recv = {EIO, 1};
  EXPECT_FALSE(drain_until_silent(ends[0], to_ns(0.005), soon()));
  ::shutdown(ends[1], SHUT_WR);
  EXPECT_FALSE(drain_until_silent(ends[0], to_ns(0.005), soon())) << "hung up";
}

TEST(WireOnASerialLine, TakesAndGivesBytesThoughItIsNoSocket) {
  termios plain{};
  cfmakeraw(&plain);
  int master = -1, slave = -1;
  ASSERT_EQ(::openpty(&master, &slave, nullptr, &plain, nullptr), 0);
  const std::array<std::uint8_t, 2> sent = {5, 6};
  std::array<std::uint8_t, 2> got{};
  std::size_t received = 0;
  const std::int64_t deadline = monotonic_ns() + to_ns(1);
  EXPECT_EQ(send_all(master, sent, deadline), WireResult::done);
  EXPECT_EQ(receive_exact(slave, got, deadline, received), WireResult::done);
  EXPECT_EQ(got, sent);
  ::close(master);
  ::close(slave);
}

}  // namespace
}  // namespace airside::hal
