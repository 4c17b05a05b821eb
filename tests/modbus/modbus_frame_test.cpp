// Frames without a socket: every answer that is not the one to this request is refused, with the reason that fits.

#include "hal/modbus/frame.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

namespace airside::hal {
namespace {

using Bytes = std::vector<std::uint8_t>;

const Bytes read_two = {3, 0, 7, 0, 2};                      // registers 7 and 8
const Bytes two_registers = {3, 4, 0x12, 0x34, 0x56, 0x78};  // the answer to it
constexpr std::size_t answer_bytes = 6;

Bytes tcp_request() {
  Bytes bytes(max_frame_bytes);
  bytes.resize(frame_tcp(read_two, 0x0102, 9, bytes.data()));
  return bytes;
}
Bytes rtu_frame(const Bytes& pdu, int unit = 9) {
  Bytes bytes(max_frame_bytes);
  bytes.resize(frame_rtu(pdu, unit, bytes.data()));
  return bytes;
}
Bytes joined(const Bytes& a, const Bytes& b) {
  Bytes all = a;
  all.insert(all.end(), b.begin(), b.end());
  return all;
}

/// A peer that sends these bytes and then hangs up, or stays silent.
struct Peer {
  Bytes bytes;
  WireResult at_end = WireResult::closed;
  std::size_t sent = 0;
  WireResult operator()(std::span<std::uint8_t> exactly, std::size_t& received) {
    for (received = 0; received < exactly.size() && sent < bytes.size(); ++received) exactly[received] = bytes[sent++];
    return received == exactly.size() ? WireResult::done : at_end;
  }
};

/// The PDU that is taken of an answer, or the text of the refusal.
struct Taken {
  Bytes pdu;
  std::string refusal;
};
template <class Result>
Taken taken(const Result& result) {
  if (!result) return {{}, text_of(result.error().error)};
  return {{result->begin(), result->end()}, ""};
}
Taken from_tcp(const Bytes& answer, WireResult at_end = WireResult::closed) {
  Bytes buffer(max_frame_bytes);
  return taken(receive_tcp(tcp_request(), buffer, Peer{answer, at_end}));
}
Taken from_rtu(const Bytes& answer, WireResult at_end = WireResult::closed) {
  Bytes buffer(max_frame_bytes);
  return taken(receive_rtu(rtu_frame(read_two), answer_bytes, buffer, Peer{answer, at_end}));
}

TEST(ModbusFrame, RequestsAreTheBytesOfTheSpecification) {
  EXPECT_EQ(tcp_request(), (Bytes{1, 2, 0, 0, 0, 6, 9, 3, 0, 7, 0, 2}));
  EXPECT_EQ(rtu_frame({3, 0, 0, 0, 1}, 1), (Bytes{1, 3, 0, 0, 0, 1, 0x84, 0x0A}));
}

const Bytes mbap = {1, 2, 0, 0, 0, 7, 9};

TEST(ModbusFrame, TcpTakesTheAnswerToThisRequest) {
  EXPECT_EQ(from_tcp(joined(mbap, two_registers)).pdu, two_registers);
  EXPECT_EQ(from_tcp({1, 2, 0, 0, 0, 3, 9, 0x83, 2}).pdu, (Bytes{0x83, 2}));
}

TEST(ModbusFrame, TcpRefusesEveryOtherWithItsReason) {
  const auto changed = [&](std::size_t at, std::uint8_t value) {
    Bytes all = joined(mbap, two_registers);
    all[at] = value;
    return from_tcp(all).refusal;
  };
  EXPECT_EQ(changed(0, 7), text_of(LinkError::wrong_transaction));
  EXPECT_EQ(changed(6, 8), text_of(LinkError::wrong_unit));
  EXPECT_EQ(changed(3, 1), text_of(LinkError::bad_frame)) << "protocol";
  EXPECT_EQ(changed(5, 2), text_of(LinkError::bad_frame)) << "too short to hold a PDU";
  EXPECT_EQ(changed(5, 255), text_of(LinkError::bad_frame)) << "longer than any PDU";
  EXPECT_EQ(changed(5, 254), text_of(LinkError::closed_by_peer)) << "the longest, but it does not come";
  EXPECT_EQ(from_tcp({1, 2, 0}).refusal, text_of(LinkError::closed_by_peer));
  EXPECT_EQ(from_tcp({1, 2, 0}, WireResult::timed_out).refusal, text_of(LinkError::timed_out));
}

TEST(ModbusFrame, SerialTakesTheAnswerAlsoBehindItsOwnEcho) {
  EXPECT_EQ(from_rtu(rtu_frame(two_registers)).pdu, two_registers);
  EXPECT_EQ(from_rtu(joined(rtu_frame(read_two), rtu_frame(two_registers))).pdu, two_registers);
  EXPECT_EQ(from_rtu(rtu_frame({0x83, 2})).pdu, (Bytes{0x83, 2})) << "a refusal is shorter";
  EXPECT_EQ(from_rtu(joined(rtu_frame(read_two), rtu_frame({0x83, 2}))).pdu, (Bytes{0x83, 2}));
}

TEST(ModbusFrame, SerialRefusesNoiseOtherUnitsAndWhatEndsEarly) {
  EXPECT_EQ(from_rtu(rtu_frame(two_registers, 8)).refusal, text_of(LinkError::wrong_unit));
  Bytes noisy = rtu_frame(two_registers);
  noisy[4] ^= 1;
  EXPECT_EQ(from_rtu(noisy).refusal, text_of(LinkError::bad_frame));
  const Bytes echo = rtu_frame(read_two);
  EXPECT_EQ(from_rtu(joined(echo, joined(echo, rtu_frame(two_registers)))).refusal, text_of(LinkError::bad_frame))
      << "an echo comes once";
  EXPECT_EQ(from_rtu({9, 3}).refusal, text_of(LinkError::closed_by_peer));
  EXPECT_EQ(from_rtu({9, 3, 4, 1, 2, 3}, WireResult::timed_out).refusal, text_of(LinkError::timed_out));
}

TEST(ModbusFrame, SerialDropsAnEchoOnlyWhole) {
  // One register: its answer is shorter than the echo, so that the last bytes of the echo come after the first look.
  const Bytes request = rtu_frame({3, 0, 7, 0, 1});
  const auto one = [&](const Bytes& answer) {
    Bytes buffer(max_frame_bytes);
    return taken(receive_rtu(request, 4, buffer, Peer{answer}));
  };
  const Bytes right = rtu_frame({3, 2, 0x12, 0x34});
  EXPECT_EQ(one(joined(request, right)).pdu, (Bytes{3, 2, 0x12, 0x34}));
  Bytes damaged = request;
  damaged.back() ^= 0x40;
  EXPECT_EQ(one(joined(damaged, right)).refusal, text_of(LinkError::bad_frame));
  EXPECT_EQ(one({request.begin(), request.end() - 1}).refusal, text_of(LinkError::closed_by_peer));
}

LinkError judged(const Bytes& answer, const Bytes& pdu, std::size_t bytes) {
  const auto checked = check_answer(answer, pdu, bytes);
  return checked ? LinkError::backing_off : checked.error().error;  // the first stands for "taken"
}
constexpr LinkError fits = LinkError::backing_off;

TEST(ModbusFrame, AnAnswerIsHeldAgainstItsRequest) {
  EXPECT_EQ(judged(two_registers, read_two, 6), fits);
  EXPECT_EQ(judged({0x83, 2}, read_two, 6), LinkError::exception_answer);
  EXPECT_EQ(check_answer(Bytes{0x83, 2}, read_two, 6).error().exception, 2);
  EXPECT_EQ(judged({0x84, 2}, read_two, 6), LinkError::bad_frame) << "a refusal of another function";
  EXPECT_EQ(judged({4, 4, 0, 0, 0, 0}, read_two, 6), LinkError::bad_frame) << "another function";
  EXPECT_EQ(judged({3, 4, 0, 0, 0}, read_two, 6), LinkError::bad_frame) << "another length";
  EXPECT_EQ(judged({3, 3, 0, 0, 0, 0}, read_two, 6), LinkError::bad_frame) << "another count";
}

TEST(ModbusFrame, AWriteIsConfirmedByItsAddressAndCount) {
  const Bytes one = {6, 0, 7, 0, 99}, many = {16, 0, 7, 0, 2, 4, 0, 1, 0, 2};
  EXPECT_EQ(judged(one, one, 5), fits);
  EXPECT_EQ(judged({6, 0, 7, 0, 50}, one, 5), fits) << "clamped: the read-back finds it";
  EXPECT_EQ(judged({6, 0, 8, 0, 99}, one, 5), LinkError::bad_frame);
  EXPECT_EQ(judged({16, 0, 7, 0, 2}, many, 5), fits);
  EXPECT_EQ(judged({16, 0, 7, 0, 1}, many, 5), LinkError::bad_frame) << "not all of them";
}

TEST(ModbusFrame, EveryErrorHasAText) {
  for (int e = 0; e <= static_cast<int>(LinkError::other_connection); ++e) {
    EXPECT_STRNE(text_of(static_cast<LinkError>(e)), "unknown") << e;
  }
  EXPECT_STREQ(text_of(static_cast<LinkError>(200)), "unknown");
}

}  // namespace
}  // namespace airside::hal
