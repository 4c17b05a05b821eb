// A serial line has noise, echoes and no transaction numbers; a spoilt answer still never becomes a value.

#include <gtest/gtest.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <memory>
#include <stdexcept>
#include <thread>

#include "hal/modbus/link.hpp"
#include "hal/modbus/wire.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::hal {
namespace {

using namespace testing_peers;
using Bytes = std::vector<std::uint8_t>;

/// A serial device on a pty whose answers a test may spoil.
class SerialPeer {
 public:
  using Answer = std::function<std::vector<Bytes>(const Bytes& request, const Bytes& honest)>;
  explicit SerialPeer(Answer answer) : answer_(std::move(answer)) {
    termios raw{};
    cfmakeraw(&raw);
    std::array<char, 128> name{};
    if (openpty(&master_, &slave_, name.data(), &raw, nullptr) != 0) throw std::runtime_error("openpty");
    device_ = name.data();
    thread_ = std::thread([this] { serve(); });
  }
  ~SerialPeer() {
    stop_ = true;
    thread_.join();
    ::close(master_);
    ::close(slave_);
  }
  LinkSettings settings(double deadline) const {
    LinkSettings s = tcp_settings(1, deadline);
    s.address = SerialAddress{device_, 115200, 'N', 8, 1};
    return s;
  }

 private:
  void serve() {
    while (!stop_) {
      Bytes request(8);
      std::size_t got = 0;
      if (receive_exact(master_, request, monotonic_ns() + to_ns(0.02), got) != WireResult::done) continue;
      Bytes honest = {request[0], 3, static_cast<std::uint8_t>(2 * request[5])};
      for (int i = 0; i < request[5]; ++i) {
        honest.push_back(request[2]);
        honest.push_back(static_cast<std::uint8_t>(request[3] + i));
      }
      const std::uint16_t crc = crc16(honest);
      honest.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
      honest.push_back(static_cast<std::uint8_t>(crc >> 8));
      for (const Bytes& part : answer_(request, honest)) send_all(master_, part, monotonic_ns() + to_ns(1));
    }
  }

  Answer answer_;
  std::atomic<bool> stop_{false};
  int master_ = -1, slave_ = -1;
  std::string device_;
  std::thread thread_;
};

TEST(ModbusLinkSerial, Row19OwnEchoIsDropped) {
  const SerialPeer peer([](const Bytes& request, const Bytes& honest) { return std::vector<Bytes>{request, honest}; });
  ModbusLink link(peer.settings(0.5));
  for (const std::size_t count : {1U, 2U, 3U, 10U}) {
    std::vector<std::uint16_t> values(count);
    ASSERT_TRUE(link.read(3, 7, values)) << count;
    EXPECT_EQ(values[0], 7);
  }
}

TEST(ModbusLinkSerial, Row19NoiseInAnAnswerIsDroppedAndTheRequestRepeatedOnce) {
  std::atomic<int> requests{0};
  const SerialPeer peer([&](const Bytes&, const Bytes& honest) {
    Bytes spoilt = honest;
    if (++requests % 2 == 1) spoilt[4] ^= 0x10;
    return std::vector<Bytes>{spoilt};
  });
  ModbusLink link(peer.settings(1.0));
  std::array<std::uint16_t, 2> values{};
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(link.read(3, 40, values));
    EXPECT_EQ(values[0], 40);
  }
  EXPECT_EQ(requests, 10);
}

TEST(ModbusLinkSerial, Row19SpoiltChecksumIsNeverAValue) {
  const SerialPeer peer([](const Bytes&, const Bytes& honest) { return std::vector<Bytes>{with(honest, 4, 0xEE)}; });
  ModbusLink link(peer.settings(0.5));
  std::array<std::uint16_t, 2> values{};
  EXPECT_EQ(link.read(3, 40, values).error().error, LinkError::bad_frame);
  EXPECT_EQ(values[0], 0);
}

TEST(ModbusLinkSerial, Row19AnotherUnitAndSilenceEndAtTheDeadline) {
  const SerialPeer other([](const Bytes&, const Bytes& honest) {
    Bytes forged = with(honest, 0, 9);
    const std::uint16_t crc = crc16({forged.data(), forged.size() - 2});
    forged[forged.size() - 2] = static_cast<std::uint8_t>(crc & 0xFFU);
    forged[forged.size() - 1] = static_cast<std::uint8_t>(crc >> 8);
    return std::vector<Bytes>{forged};
  });
  ModbusLink link(other.settings(0.3));
  std::array<std::uint16_t, 2> values{};
  EXPECT_EQ(link.read(3, 40, values).error().error, LinkError::wrong_unit);

  const SerialPeer silent([](const Bytes&, const Bytes&) { return std::vector<Bytes>{}; });
  ModbusLink waiting(silent.settings(0.3));
  const std::int64_t start = monotonic_ns();
  EXPECT_EQ(waiting.read(3, 40, values).error().error, LinkError::timed_out);
  EXPECT_LT(seconds_since(start), 0.3 + slack_s);
}

TEST(ModbusLinkSerial, ALineThatVanishesIsOpenedAnew) {
  auto peer =
      std::make_unique<SerialPeer>([](const Bytes&, const Bytes& honest) { return std::vector<Bytes>{honest}; });
  LinkSettings settings = peer->settings(0.3);
  settings.backoff_first_s = 0;
  ModbusLink link(settings);
  std::array<std::uint16_t, 1> value{};
  ASSERT_TRUE(link.read(3, 1, value));
  peer.reset();
  const auto lost = link.read(3, 1, value);
  ASSERT_FALSE(lost);
  EXPECT_FALSE(link.connected());
}

TEST(ModbusLinkSerial, Row19NoiseBetweenFramesIsDroppedUntilTheLineIsSilent) {
  // 3.5 characters of silence begin a frame: whatever stands on the line before is nobody's.
  const SerialPeer peer([](const Bytes& request, const Bytes& honest) {
    return std::vector<Bytes>{honest, Bytes{0x00, 0xFF, 0x13}, request};
  });
  ModbusLink link(peer.settings(0.5));
  std::array<std::uint16_t, 4> values{};
  for (int addr = 10; addr < 30; ++addr) {
    ASSERT_TRUE(link.read(3, addr, values)) << addr;
    ASSERT_EQ(values[0], addr);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // until the noise is there
  }
  EXPECT_EQ(link.counters().bad_frames, 0U);
}

TEST(ModbusLinkSerial, Row19NoiseBeforeAnAnswerCostsOneRepetition) {
  std::atomic<int> requests{0};
  const SerialPeer peer([&](const Bytes&, const Bytes& honest) {
    return ++requests % 2 == 1 ? std::vector<Bytes>{Bytes{0x01, 0x03, 0x55}, honest} : std::vector<Bytes>{honest};
  });
  ModbusLink link(peer.settings(1.0));
  std::array<std::uint16_t, 4> values{};
  for (int addr = 10; addr < 14; ++addr) {
    ASSERT_TRUE(link.read(3, addr, values)) << addr;
    ASSERT_EQ(values[0], addr);
  }
  EXPECT_EQ(requests, 8);
}

TEST(ModbusLinkSerial, Row19LineThatIsNeverSilentEndsAtTheDeadlineAndIsUsedAgainAfterwards) {
  std::atomic<bool> babbles{true};
  const SerialPeer peer([&](const Bytes&, const Bytes& honest) {
    if (!babbles) return std::vector<Bytes>{honest};
    return std::vector<Bytes>(200, Bytes(20, 0x55));
  });
  ModbusLink link(peer.settings(0.3));
  std::array<std::uint16_t, 4> values{};
  const std::int64_t start = monotonic_ns();
  EXPECT_FALSE(link.read(3, 10, values));
  EXPECT_LT(seconds_since(start), 0.3 + slack_s);
  EXPECT_EQ(values[0], 0);
  babbles = false;
  bool again = false;
  for (int i = 0; i < 20 && !again; ++i) again = link.read(3, 10, values).has_value();
  EXPECT_TRUE(again);
  EXPECT_EQ(values[0], 10);
}

TEST(ModbusLinkSerial, Row19WithoutNoiseEachRequestIsSentOnce) {
  std::atomic<int> requests{0};
  const SerialPeer peer([&](const Bytes&, const Bytes& honest) { return ++requests, std::vector<Bytes>{honest}; });
  ModbusLink link(peer.settings(0.5));
  std::array<std::uint16_t, 4> values{};
  for (int addr = 10; addr < 60; ++addr) {
    ASSERT_TRUE(link.read(3, addr, values));
    ASSERT_EQ(values[3], addr + 3);
  }
  EXPECT_EQ(requests, 50);
  EXPECT_EQ(link.counters().bad_frames + link.counters().timeouts + link.counters().wrong_ids, 0U);
}

TEST(ModbusLinkSerial, AWriteOnAVanishedLineIsNotRepeated) {
  auto peer = std::make_unique<SerialPeer>(
      [](const Bytes& request, const Bytes& honest) { return std::vector<Bytes>{request[1] == 6 ? request : honest}; });
  ModbusLink link(peer->settings(0.3));
  const std::array<std::uint16_t, 1> value = {7};
  ASSERT_TRUE(link.write(6, 1, value));
  peer.reset();
  const auto lost = link.write(6, 1, value);
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().error, LinkError::closed_by_peer);
  EXPECT_FALSE(link.connected());
}

TEST(ModbusWire, ChecksumIsTheOneOfTheSpecification) {
  const Bytes request = {0x02, 0x07};  // serial line specification, appendix B: 41 12 on the wire
  EXPECT_EQ(crc16(request), 0x1241);
}

}  // namespace
}  // namespace airside::hal
