// Whatever the peer does, an exchange ends at its deadline and a wrong answer never becomes a value.

#include "hal/modbus/link.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <functional>
#include <thread>

#include "hal/modbus/wire.hpp"
#include "hal/text/input_error.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::hal {
namespace {

using namespace testing_peers;
using Bytes = std::vector<std::uint8_t>;

constexpr double deadline_s = 0.5;

struct Hostile {
  const char* name;
  HostilePeer::Behaviour behave;
  LinkError expected;
};

/// Answers each request with what `forge` makes of the honest answer, then waits for the client to leave.
HostilePeer::Behaviour forging(std::function<Bytes(Bytes)> forge) {
  return [forge = std::move(forge)](HostilePeer& peer, int fd) {
    for (Bytes request = peer.request(fd); !request.empty(); request = peer.request(fd)) {
      peer.send(fd, forge(honest_answer(request)));
    }
  };
}

HostilePeer::Behaviour trickling(double pause_s) {
  return [pause_s](HostilePeer& peer, int fd) {
    const Bytes answer = honest_answer(peer.request(fd));
    for (const std::uint8_t byte : answer) {
      peer.send(fd, {byte});
      peer.pause(pause_s);
    }
  };
}

class HostilePeers : public testing::TestWithParam<Hostile> {};

TEST_P(HostilePeers, CostNoMoreThanTheDeadlineAndGiveNoValue) {
  const HostilePeer peer(GetParam().behave);
  ModbusLink link(tcp_settings(peer.port(), deadline_s));
  std::array<std::uint16_t, 10> registers{};
  registers.fill(0xABCD);
  const std::int64_t start = monotonic_ns();
  const auto read = link.read(3, 100, registers);
  EXPECT_LT(seconds_since(start), deadline_s + slack_s);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().error, GetParam().expected) << text_of(read.error().error);
  EXPECT_FALSE(link.connected()) << "a doubtful connection must be closed";
  for (const std::uint16_t value : registers) EXPECT_EQ(value, 0xABCD) << "nothing may be handed out";
}

INSTANTIATE_TEST_SUITE_P(
    Table, HostilePeers,
    testing::Values(
        Hostile{"WrongUnit", forging([](Bytes a) { return with(a, 6, 77); }), LinkError::wrong_unit},
        Hostile{"WrongTransaction", forging([](Bytes a) { return with(a, 0, 0x55); }), LinkError::wrong_transaction},
        Hostile{"TransactionZero", forging([](Bytes a) { return with(with(a, 0, 0), 1, 0); }),
                LinkError::wrong_transaction},
        Hostile{"WrongProtocol", forging([](Bytes a) { return with(a, 3, 1); }), LinkError::bad_frame},
        Hostile{"LengthFfff", forging([](Bytes a) { return with(with(a, 4, 0xFF), 5, 0xFF); }), LinkError::bad_frame},
        Hostile{"LengthZero", forging([](Bytes a) { return with(with(a, 4, 0), 5, 0); }), LinkError::bad_frame},
        Hostile{"LengthTooShort", forging([](Bytes a) { return with(a, 5, 10); }), LinkError::bad_frame},
        Hostile{"LengthTooLong", forging([](Bytes a) { return with(a, 5, 40); }), LinkError::timed_out},
        Hostile{"WrongFunction", forging([](Bytes a) { return with(a, 7, 4); }), LinkError::bad_frame},
        Hostile{"WrongByteCount", forging([](Bytes a) { return with(a, 8, 18); }), LinkError::bad_frame},
        Hostile{"ExceptionWithPayload", forging([](Bytes a) { return with(a, 7, 0x83); }), LinkError::bad_frame},
        Hostile{"Truncated", forging([](Bytes a) { return Bytes(a.begin(), a.begin() + 15); }), LinkError::timed_out},
        Hostile{"TricklesEachByteInTime", trickling(0.1), LinkError::timed_out},
        Hostile{"HalfOpenNeverAnswers", [](HostilePeer& peer, int) { peer.pause(30); }, LinkError::timed_out},
        Hostile{"HangsUpAtOnce", [](HostilePeer&, int) {}, LinkError::closed_by_peer},
        Hostile{"HangsUpAfterTheRequest", [](HostilePeer& peer, int fd) { peer.request(fd); },
                LinkError::closed_by_peer},
        Hostile{"ResetsTheConnection",
                [](HostilePeer& peer, int fd) {
                  peer.request(fd);
                  const linger abort = {1, 0};
                  setsockopt(fd, SOL_SOCKET, SO_LINGER, &abort, sizeof(abort));
                },
                LinkError::closed_by_peer},
        Hostile{"ResetsInTheMiddleOfAnAnswer",
                [](HostilePeer& peer, int fd) {
                  const Bytes a = honest_answer(peer.request(fd));
                  peer.send(fd, Bytes(a.begin(), a.begin() + 12));
                },
                LinkError::closed_by_peer}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(ModbusLink, HonestPeerIsBelieved) {
  const HostilePeer peer(forging([](Bytes a) { return a; }));
  ModbusLink link(tcp_settings(peer.port()));
  std::array<std::uint16_t, 3> registers{};
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(link.read(3, 100, registers));
    ASSERT_EQ(registers, (std::array<std::uint16_t, 3>{100, 101, 102}));
  }
  EXPECT_EQ(link.counters().connects, 1U);
}

TEST(ModbusLink, LateAnswerIsNeverTakenForTheNextRequest) {
  std::atomic<int> requests{0};
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    for (Bytes request = p.request(fd); !request.empty(); request = p.request(fd)) {
      if (++requests == 2) p.pause(0.35);
      p.send(fd, honest_answer(request));
    }
  });
  ModbusLink link(tcp_settings(peer.port(), 0.25));
  std::array<std::uint16_t, 1> value{};
  ASSERT_TRUE(link.read(3, 1, value));
  EXPECT_EQ(link.read(3, 2, value).error().error, LinkError::timed_out);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  for (int addr = 3; addr < 10; ++addr) {
    ASSERT_TRUE(link.read(3, addr, value));
    ASSERT_EQ(value[0], addr);
  }
}

TEST(ModbusLink, TrailingBytesDoNotPoisonTheNextRead) {
  const HostilePeer peer(forging([](Bytes a) {
    a.push_back(0);
    a.push_back(7);
    return a;
  }));
  ModbusLink link(tcp_settings(peer.port()));
  std::array<std::uint16_t, 1> value{};
  for (int addr = 0; addr < 5; ++addr) {
    ASSERT_TRUE(link.read(3, addr, value));
    ASSERT_EQ(value[0], addr);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(link.counters().connects, 5U) << "each time the stray bytes close the connection";
  EXPECT_EQ(link.counters().wrong_ids, 4U);
}

TEST(ModbusLink, IdleConnectionThatTheDeviceClosedCostsNoReading) {
  const HostilePeer peer([](HostilePeer& p, int fd) { p.send(fd, honest_answer(p.request(fd))); });
  ModbusLink link(tcp_settings(peer.port()));
  std::array<std::uint16_t, 1> value{};
  for (int addr = 0; addr < 20; ++addr) {
    ASSERT_TRUE(link.read(3, addr, value)) << addr;
    ASSERT_EQ(value[0], addr);
  }
}

TEST(ModbusLink, ExceptionsAreHandedOnAndKeepTheConnection) {
  std::atomic<int> code{1};
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    for (Bytes r = p.request(fd); !r.empty(); r = p.request(fd)) {
      p.send(fd, {r[0], r[1], 0, 0, 0, 3, r[6], static_cast<std::uint8_t>(r[7] | 0x80U),
                  static_cast<std::uint8_t>(code.load())});
    }
  });
  LinkSettings settings = tcp_settings(peer.port());
  settings.backoff_first_s = settings.backoff_max_s = 30;
  std::array<std::uint16_t, 1> value{};
  for (const int c : {1, 2, 3, 6, 4, 11, 99}) {
    ModbusLink link(settings);
    code = c;
    const auto read = link.read(3, 0, value);
    ASSERT_EQ(read.error().error, LinkError::exception_answer);
    EXPECT_EQ(read.error().exception, c);
    EXPECT_EQ(link.connected(), c != 4) << "4 means a broken device";
    const bool rests = c == 4 || c > 6;
    EXPECT_EQ(link.backoff_left_s() > 0, rests) << c;
  }
}

TEST(ModbusLink, BusyDeviceIsAskedAgainWithinTheDeadline) {
  std::atomic<int> requests{0};
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    for (Bytes r = p.request(fd); !r.empty(); r = p.request(fd)) {
      if (++requests < 3)
        p.send(fd, {r[0], r[1], 0, 0, 0, 3, r[6], 0x83, 6});
      else
        p.send(fd, honest_answer(r));
    }
  });
  ModbusLink link(tcp_settings(peer.port()));
  std::array<std::uint16_t, 1> value{};
  EXPECT_TRUE(link.read(3, 42, value));
  EXPECT_EQ(value[0], 42);
  EXPECT_EQ(requests, 3);
}

TEST(ModbusLink, BacksOffLongerAfterEachFailureAndForgetsItAfterSuccess) {
  std::atomic<bool> honest{false};
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    if (!honest) return;
    for (Bytes r = p.request(fd); !r.empty() && honest; r = p.request(fd)) p.send(fd, honest_answer(r));
  });
  LinkSettings settings = tcp_settings(peer.port());
  settings.backoff_first_s = 0.05;
  settings.backoff_max_s = 0.15;
  ModbusLink link(settings);
  std::array<std::uint16_t, 1> value{};
  for (const double wait : {0.05, 0.1, 0.15, 0.15}) {
    EXPECT_DOUBLE_EQ(link.failure_costs_s(), settings.exchange_deadline_s + wait);
    ASSERT_EQ(link.read(3, 0, value).error().error, LinkError::closed_by_peer);
    EXPECT_NEAR(link.backoff_left_s(), wait, 0.02);
    EXPECT_EQ(link.read(3, 0, value).error().error, LinkError::backing_off);
    std::this_thread::sleep_for(std::chrono::duration<double>(link.backoff_left_s() + 0.002));
  }
  EXPECT_EQ(peer.connections(), 4) << "no attempt while backing off";
  honest = true;
  EXPECT_TRUE(link.read(3, 0, value));
  EXPECT_EQ(link.backoff_left_s(), 0.0);
  EXPECT_DOUBLE_EQ(link.failure_costs_s(), settings.exchange_deadline_s + 0.05);
}

TEST(ModbusLink, NobodyThereIsSaidBeforeTheDeadline) {
  int port = 0;
  {
    port = HostilePeer([](HostilePeer&, int) {}).port();
  }
  ModbusLink link(tcp_settings(port));
  std::array<std::uint16_t, 1> value{};
  const std::int64_t start = monotonic_ns();
  EXPECT_EQ(link.read(3, 0, value).error().error, LinkError::connect_failed);
  EXPECT_LT(seconds_since(start), deadline_s + slack_s);
}

TEST(ModbusLink, RequestsOutsideModbusNeverReachTheBus) {
  ModbusLink link(tcp_settings(1));
  std::array<std::uint16_t, 126> many{};
  const auto bad = [](const LinkResult<void>& r) { return !r && r.error().error == LinkError::bad_request; };
  EXPECT_TRUE(bad(link.read(3, 0, many)));
  EXPECT_TRUE(bad(link.read(3, 0, {})));
  EXPECT_TRUE(bad(link.read(7, 0, {many.data(), 1})));
  EXPECT_TRUE(bad(link.read(0, 0, {many.data(), 1})));
  EXPECT_TRUE(bad(link.read(3, -1, {many.data(), 1})));
  std::array<std::uint16_t, 2001> bits{};
  EXPECT_TRUE(bad(link.read(1, 0, bits)));
  EXPECT_TRUE(bad(link.read(2, 0, bits)));
  EXPECT_TRUE(bad(link.write(6, -1, {many.data(), 1})));
  EXPECT_TRUE(bad(link.write(16, 0, {})));
  EXPECT_TRUE(bad(link.write(16, 65535, {many.data(), 2})));
  EXPECT_TRUE(bad(link.read(3, 65536, {many.data(), 1})));
  EXPECT_TRUE(bad(link.read(4, 65535, {many.data(), 2})));
  EXPECT_TRUE(bad(link.write(6, 0, {many.data(), 2})));
  EXPECT_TRUE(bad(link.write(16, 0, {many.data(), 124})));
  EXPECT_TRUE(bad(link.write(3, 0, {many.data(), 1})));
  many[0] = 2;
  EXPECT_TRUE(bad(link.write(5, 0, {many.data(), 1})));
  EXPECT_EQ(link.counters().connects, 0U);
}

TEST(ModbusLink, BadSettingsAreRefused) {
  EXPECT_THROW(ModbusLink{tcp_settings(0)}, InputError);
  EXPECT_THROW((ModbusLink{tcp_settings(502, 11)}), InputError);
  EXPECT_THROW((ModbusLink{tcp_settings(502, 0)}), InputError);
  EXPECT_THROW(ModbusLink{tcp_settings(65536)}, InputError);
  const auto refused = [](const std::function<void(LinkSettings&)>& change) {
    LinkSettings changed = tcp_settings(502);
    change(changed);
    EXPECT_THROW(ModbusLink{changed}, InputError);
  };
  refused([](LinkSettings& s) { s.unit = -1; });
  refused([](LinkSettings& s) { s.unit = 256; });
  refused([](LinkSettings& s) { s.backoff_first_s = -1; });
  refused([](LinkSettings& s) { s.backoff_first_s = 2, s.backoff_max_s = 1; });
  refused([](LinkSettings& s) { s.backoff_max_s = 3601; });
  const auto serial = [&](const SerialAddress& address, int unit = 1) {
    refused([&](LinkSettings& s) { s.address = address, s.unit = unit; });
  };
  serial({"/dev/ttyS0", 19200, 'E', 8, 1}, 0);
  serial({"/dev/ttyS0", 19200, 'E', 8, 1}, 248);
  serial({"/dev/ttyS0", 1199, 'E', 8, 1});
  serial({"/dev/ttyS0", 921601, 'E', 8, 1});
  serial({"/dev/ttyS0", 19200, 'E', 7, 1});
  serial({"/dev/ttyS0", 19200, 'E', 8, 3});
  LinkSettings settings = tcp_settings(502);
  settings.address = TcpAddress{"no such host.invalid", 502};
  EXPECT_THROW(ModbusLink{settings}, InputError);
  settings.address = SerialAddress{"", 19200, 'E', 8, 1};
  EXPECT_THROW(ModbusLink{settings}, InputError);
  settings.address = SerialAddress{"/dev/ttyS0", 19200, 'X', 8, 1};
  EXPECT_THROW(ModbusLink{settings}, InputError);
}

TEST(ModbusLink, GoodSettingsOfEveryKindAreTaken) {
  for (const char parity : {'N', 'E', 'O'}) {
    for (const int stop_bits : {1, 2}) {
      for (const int baud : {9600, 115200}) {
        LinkSettings settings = tcp_settings(502);
        settings.address = SerialAddress{"/dev/airside-none", baud, parity, 8, stop_bits};
        settings.backoff_first_s = 0;
        ModbusLink link(settings);
        std::array<std::uint16_t, 1> value{};
        EXPECT_EQ(link.read(3, 0, value).error().error, LinkError::connect_failed) << "no such device";
      }
    }
  }
  LinkSettings settings = tcp_settings(9);
  settings.address = TcpAddress{"::1", 9};
  ModbusLink link(settings);
  EXPECT_EQ(link.description(), "::1:9 unit 1");
  std::array<std::uint16_t, 1> value{};
  EXPECT_EQ(link.read(3, 0, value).error().error, LinkError::connect_failed);
}

TEST(ModbusLink, ADeadlineThatIsAlreadyOverConnectsToNobody) {
  ModbusLink link(tcp_settings(1, 1e-9));
  std::array<std::uint16_t, 1> value{};
  EXPECT_EQ(link.read(3, 0, value).error().error, LinkError::timed_out);
  EXPECT_EQ(link.counters().connects, 0u);
}

TEST(ModbusLink, ASlowBusyDeviceIsNotAskedAgainBehindTheDeadline) {
  std::atomic<int> requests{0};
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    for (Bytes request = p.request(fd); !request.empty(); request = p.request(fd)) {
      ++requests;
      p.pause(0.28);
      p.send(fd, {request[0], request[1], 0, 0, 0, 3, request[6], 0x83, 6});
    }
  });
  ModbusLink link(tcp_settings(peer.port(), 0.8));
  std::array<std::uint16_t, 1> value{};
  const std::int64_t start = monotonic_ns();
  const auto read = link.read(3, 0, value);
  EXPECT_LT(seconds_since(start), 0.8 + slack_s);
  ASSERT_FALSE(read);
  EXPECT_LT(requests, 4) << "there was no time for all three repetitions";
}

TEST(ModbusLink, ADeviceThatIsBusyUntilTheDeadlineIsLeftAlone) {
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    for (Bytes request = p.request(fd); !request.empty(); request = p.request(fd)) {
      p.pause(1.8);
      p.send(fd, {request[0], request[1], 0, 0, 0, 3, request[6], 0x83, 6});
    }
  });
  ModbusLink link(tcp_settings(peer.port(), 2));  // another try would come a quarter of a second later
  std::array<std::uint16_t, 1> value{};
  const auto read = link.read(3, 0, value);
  ASSERT_FALSE(read);
  EXPECT_EQ(link.counters().connects, 1u);
}

TEST(ModbusLink, AWriteForAnotherConnectionReachesNobody) {
  std::atomic<int> writes{0};
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    for (Bytes request = p.request(fd); !request.empty(); request = p.request(fd)) {
      writes += request[7] != 3;
      p.send(fd,
             request[7] == 3 ? honest_answer(request) : request);  // a write of one register is answered by its echo
    }
  });
  ModbusLink link(tcp_settings(peer.port()));
  std::array<std::uint16_t, 1> value{};
  EXPECT_EQ(link.write(6, 0, value, 0).error().error, LinkError::other_connection) << "there is none yet";
  ASSERT_TRUE(link.read(3, 0, value));
  EXPECT_EQ(link.write(6, 0, value, link.generation() + 1).error().error, LinkError::other_connection);
  EXPECT_EQ(writes, 0);
  EXPECT_TRUE(link.write(6, 0, value, link.generation()));
}

TEST(ModbusLink, ARequestThatCannotBeSentEndsTheConnection) {
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    for (Bytes request = p.request(fd); !request.empty(); request = p.request(fd)) p.send(fd, honest_answer(request));
    p.pause(0.3);  // it has heard that nothing more will come, and does not hang up yet
  });
  ModbusLink link(tcp_settings(peer.port()));
  std::array<std::uint16_t, 1> value{};
  ASSERT_TRUE(link.read(3, 0, value));
  // The client's end of the connection is the one socket whose peer has the server's port.
  for (int fd = 3; fd < 256; ++fd) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (::getpeername(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) continue;
    if (ntohs(address.sin_port) == peer.port()) ::shutdown(fd, SHUT_WR);
  }
  const auto read = link.read(3, 0, value);
  EXPECT_TRUE(read || read.error().error == LinkError::closed_by_peer) << text_of(read.error().error);
  EXPECT_TRUE(link.read(3, 0, value)) << "on a new connection";
}

TEST(ModbusLink, AWriteOnADroppedConnectionIsNotRepeated) {
  std::atomic<int> writes{0};
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    for (Bytes request = p.request(fd); !request.empty(); request = p.request(fd)) {
      if (request[7] != 3) {
        ++writes;
        return;  // hangs up on the write
      }
      p.send(fd, honest_answer(request));
    }
  });
  ModbusLink link(tcp_settings(peer.port()));
  std::array<std::uint16_t, 1> value{};
  ASSERT_TRUE(link.read(3, 0, value));
  const auto written = link.write(6, 0, value);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().error, LinkError::closed_by_peer);
  EXPECT_EQ(writes, 1) << "nothing is written on a connection whose device was not read again";
}

TEST(ModbusLink, ADeviceThatHasAcknowledgedIsAskedAgain) {
  std::atomic<int> requests{0};
  const HostilePeer peer([&](HostilePeer& p, int fd) {
    for (Bytes r = p.request(fd); !r.empty(); r = p.request(fd)) {
      const bool later = ++requests < 3;
      p.send(fd, later ? Bytes{r[0], r[1], 0, 0, 0, 3, r[6], static_cast<std::uint8_t>(r[7] | 0x80), 5}
                       : Bytes{r[0], r[1], 0, 0, 0, 6, r[6], r[7], r[8], r[9], r[10], r[11]});
    }
  });
  ModbusLink link(tcp_settings(peer.port()));
  const std::array<std::uint16_t, 1> off = {0};
  EXPECT_TRUE(link.write(5, 3, off)) << "acknowledged twice, done the third time";
  EXPECT_EQ(requests, 3);
  requests = -100;
  const auto never = link.write(5, 3, off);
  ASSERT_FALSE(never);
  EXPECT_EQ(never.error().exception, 5);
  EXPECT_EQ(link.backoff_left_s(), 0.0) << "it is there";
}

}  // namespace
}  // namespace airside::hal
