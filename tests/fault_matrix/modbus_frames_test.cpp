// Rows 14 and 16 to 18: whatever comes in the place of an answer, the exchange is over at its deadline, nothing of it
// becomes a value, and the next connection is as good as new.

#include "fault_matrix/modbus_rig.hpp"

namespace airside::fault_matrix {
namespace {

using Desk = ChaosDesk;
using hal::LinkError;

/// Does `fault` to the third of five reads of one link.
struct Spoilt {
  LinkError error = LinkError::bad_request;
  double longest_s = 0;
  hal::LinkCounters counters;
};
Spoilt spoil_one(const std::string& fault) {
  Desk desk("n=3 " + fault);
  Spoilt found;
  std::array<std::uint16_t, 7> words{};
  for (int i = 1; i <= 5; ++i) {
    words.fill(0xABCD);
    hal::LinkResult<void> got;
    found.longest_s = std::max(found.longest_s, Desk::seconds([&] { got = desk.link.read(4, 0, words); }));
    EXPECT_EQ(got.has_value(), i != 3) << fault << ", read " << i;
    if (!got) found.error = got.error().error;
    EXPECT_EQ(desk.link.connected(), got.has_value()) << fault << ": a doubtful connection is closed";
    for (const std::uint16_t w : words) {
      EXPECT_EQ(w == 0xABCD, i == 3) << fault << ": only a good answer is handed out";
    }
    EXPECT_EQ(words[0], got ? 2000 : 0xABCD) << fault;
  }
  EXPECT_LT(found.longest_s, Desk::deadline_s + Desk::busy_s) << fault;
  found.counters = desk.link.counters();
  EXPECT_EQ(found.counters.connects, 2U) << fault;
  return found;
}

TEST(ModbusFrames, Row14HalfOpenConnectionIsClosedAtTheDeadline) {
  for (const char* fault : {"halfopen", "drop", "mute"}) {
    const Spoilt s = spoil_one(fault);
    EXPECT_EQ(s.error, LinkError::timed_out) << fault;
    EXPECT_EQ(s.counters.timeouts, 1U) << fault;
  }
}

TEST(ModbusFrames, Row16LateAnswerIsDiscardedWithItsConnection) {
  const Spoilt s = spoil_one("late:s=0.8");
  EXPECT_EQ(s.error, LinkError::timed_out);
}

TEST(ModbusFrames, Row16DuplicateAnswerClosesTheSocketBeforeTheNextRequest) {
  Desk desk("n=3 duplicate:times=3");
  std::array<std::uint16_t, 1> word{};
  for (int addr = 0; addr < 6; ++addr) {
    ASSERT_TRUE(desk.link.read(4, addr, word)) << addr;
    EXPECT_EQ(word[0], 2000 + 10 * addr) << "never the answer to the request before";
    hal::sleep_until_ns(hal::monotonic_ns() + 10'000'000, {});
  }
  EXPECT_EQ(desk.link.generation(), 2U);
  EXPECT_EQ(desk.link.counters().wrong_ids, 1U);
}

TEST(ModbusFrames, Row17AnswersOfAnotherUnitTransactionProtocolOrFunctionAreCountedAndRefused) {
  for (const char* fault : {"unit:by=76", "unit:by=1", "transaction:by=65535", "transaction:by=256"}) {
    const Spoilt s = spoil_one(fault);
    EXPECT_EQ(s.counters.wrong_ids, 1U) << fault;
    EXPECT_EQ(s.error, fault[0] == 'u' ? LinkError::wrong_unit : LinkError::wrong_transaction) << fault;
  }
  for (const char* fault : {"protocol:id=1", "protocol:id=65535", "function:by=1", "function:by=127"}) {
    const Spoilt s = spoil_one(fault);
    EXPECT_EQ(s.error, LinkError::bad_frame) << fault;
    EXPECT_EQ(s.counters.bad_frames, 1U) << fault;
  }
}

TEST(ModbusFrames, Row18ShortLongAndTrickledFramesEndAtTheAbsoluteDeadline) {
  // Each byte comes long before any wait for one byte would end.
  for (const char* fault : {"trickle:gap=0.05", "endless:gap=0.01", "truncate:bytes=1", "truncate:bytes=7",
                            "truncate:bytes=15", "length:says=40"}) {
    EXPECT_EQ(spoil_one(fault).error, LinkError::timed_out) << fault;
  }
  for (const char* fault : {"length:says=65535", "length:says=0", "length:says=5", "noise:bytes=300"}) {
    EXPECT_NE(spoil_one(fault).error, LinkError::bad_request) << fault;
  }
  (void)spoil_one("flood");
}

TEST(ModbusFrames, Row18FrameThatEndsInAFinOrAResetIsAskedForAgainOnANewConnection) {
  for (const char* fault : {"fin:bytes=10", "fin:bytes=0", "reset:bytes=0", "reset:bytes=8"}) {
    Desk desk(std::string("n=3 ") + fault);
    std::array<std::uint16_t, 7> words{};
    for (int i = 1; i <= 5; ++i) {
      words.fill(0);
      ASSERT_TRUE(desk.link.read(4, 0, words)) << fault;
      EXPECT_EQ(words[6], 2060) << fault;
    }
    EXPECT_EQ(desk.link.generation(), 2U) << fault;
    desk.proxy.use(rules_of(fault));
    words.fill(0xABCD);
    EXPECT_EQ(desk.link.read(4, 0, words).error().error, LinkError::closed_by_peer) << "once, not for ever";
    EXPECT_EQ(desk.proxy.counters().exchanges, 8U);
    EXPECT_EQ(words[0], 0xABCD);
  }
}

TEST(ModbusFrames, Row18TrailingBytesCostTheConnectionAndNoValue) {
  Desk desk("n=2 trailing:bytes=2");
  std::array<std::uint16_t, 1> word{};
  for (int addr = 0; addr < 5; ++addr) {
    ASSERT_TRUE(desk.link.read(4, addr, word));
    EXPECT_EQ(word[0], 2000 + 10 * addr);
    hal::sleep_until_ns(hal::monotonic_ns() + 10'000'000, {});
  }
  EXPECT_EQ(desk.link.generation(), 2U);
}

TEST(ModbusFrames, Row14WithoutAHalfOpenConnectionNothingIsDisturbed) { Desk().expect_undisturbed(); }

TEST(ModbusFrames, Row16WithoutADelayBeyondTheDeadlineASlowAnswerIsTaken) {
  Desk desk("late:s=0.005");
  desk.expect_undisturbed();
}

TEST(ModbusFrames, Row17WithoutForeignNumbersNothingIsCounted) {
  Desk desk;
  desk.expect_undisturbed();
  EXPECT_EQ(desk.link.counters().wrong_ids, 0U);
}

TEST(ModbusFrames, Row18WithoutADelayBeyondTheDeadlineATrickledAnswerIsTaken) {
  Desk desk("n=1 trickle:gap=0.004");
  desk.expect_undisturbed();
}

}  // namespace
}  // namespace airside::fault_matrix
