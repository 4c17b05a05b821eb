// Modbus answers, TCP and serial: whatever a peer sends, an answer that is taken is one to this request.

#include <algorithm>
#include <array>

#include "fuzz/target.hpp"
#include "hal/modbus/frame.hpp"

namespace airside::fuzz {
namespace {

using hal::get16;
using hal::put16;

/// A request as ModbusLink makes them, and the length of the answer that it expects.
struct Request {
  std::array<std::uint8_t, hal::max_pdu_bytes> pdu{};
  std::size_t bytes = 5, answer_bytes = 5;
  int unit = 1;
  std::uint16_t transaction = 0;
  std::span<const std::uint8_t> view() const { return {pdu.data(), bytes}; }
};

constexpr std::size_t request_bytes = 6;  // of an input

Request request_of(Cursor& in) {
  static constexpr std::uint8_t functions[] = {1, 2, 3, 4, 5, 6, 16};
  Request r;
  r.pdu[0] = functions[in.byte() % 7];
  const unsigned addr = in.word(), count = in.byte();
  r.unit = static_cast<int>(in.byte());
  r.transaction = static_cast<std::uint16_t>(in.byte() * 257);
  put16(&r.pdu[1], addr);
  if (r.pdu[0] <= 2) {
    put16(&r.pdu[3], 1 + count);
    r.answer_bytes = 2 + (1 + count + 7) / 8;
  } else if (r.pdu[0] <= 4) {
    put16(&r.pdu[3], 1 + count % 125);
    r.answer_bytes = 2 + 2 * (1 + count % 125);
  } else if (r.pdu[0] <= 6) {
    put16(&r.pdu[3], r.pdu[0] == 5 ? (count % 2) * 0xFF00U : count);
  } else {
    put16(&r.pdu[3], 1 + count % 123);
    r.pdu[5] = static_cast<std::uint8_t>(2 * (1 + count % 123));
    r.bytes = 6 + r.pdu[5];
  }
  return r;
}

/// The peer's bytes; it hangs up after the last one.
struct Peer {
  Cursor bytes;
  hal::WireResult operator()(std::span<std::uint8_t> exactly, std::size_t& received) {
    const View some = bytes.take(exactly.size());
    std::ranges::copy(some, exactly.begin());
    received = some.size();
    return received == exactly.size() ? hal::WireResult::done : hal::WireResult::closed;
  }
};

/// What the specification says of an answer's PDU, written down a second time.
void check_pdu(View pdu, const Request& r, bool refused) {
  if (refused) {
    FUZZ_CLAIM(pdu.size() == 2 && pdu[0] == r.pdu[0] + 0x80);
    return;
  }
  FUZZ_CLAIM(pdu.size() == r.answer_bytes && pdu[0] == r.pdu[0]);
  if (r.pdu[0] <= 4) {
    FUZZ_CLAIM(pdu[1] == pdu.size() - 2);
  } else {
    FUZZ_CLAIM(get16(&pdu[1]) == get16(&r.pdu[1]));
    FUZZ_CLAIM(r.pdu[0] != 16 || get16(&pdu[3]) == get16(&r.pdu[3]));
  }
}

bool answer_tcp(View input) {
  Cursor in(input);
  const Request r = request_of(in);
  std::array<std::uint8_t, hal::max_frame_bytes> request{}, buffer{};
  const std::size_t size = hal::frame_tcp(r.view(), r.transaction, r.unit, request.data());
  FUZZ_CLAIM(size == 7 + r.bytes && get16(&request[4]) == r.bytes + 1);
  const View stream = in.rest();
  const auto pdu = hal::receive_tcp(std::span(request).first(size), buffer, Peer{Cursor(stream)});
  if (!pdu) return false;
  FUZZ_CLAIM(stream.size() >= 7 + pdu->size() && get16(&stream[0]) == r.transaction && get16(&stream[2]) == 0);
  FUZZ_CLAIM(get16(&stream[4]) == pdu->size() + 1 && stream[6] == static_cast<std::uint8_t>(r.unit));
  FUZZ_CLAIM(std::equal(pdu->begin(), pdu->end(), stream.begin() + 7));
  const auto checked = hal::check_answer(*pdu, r.view(), r.answer_bytes);
  if (!checked && checked.error().error == hal::LinkError::bad_frame) return false;
  check_pdu(*pdu, r, !checked);
  return true;
}

/// A CRC-16 of Modbus by division, another way than the product's.
bool crc_fits(View frame) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : frame) {
    for (int bit = 0; bit < 8; ++bit) {
      const unsigned in = (crc ^ static_cast<unsigned>(byte >> bit)) & 1U;
      crc = crc >> 1 ^ (in != 0 ? 0xA001U : 0U);
    }
  }
  return crc == 0;
}

bool answer_rtu(View input) {
  Cursor in(input);
  Request r = request_of(in);
  r.unit = 1 + r.unit % 247;
  std::array<std::uint8_t, hal::max_frame_bytes> request{}, buffer{};
  const std::size_t size = hal::frame_rtu(r.view(), r.unit, request.data());
  FUZZ_CLAIM(size == r.bytes + 3 && crc_fits(View(request).first(size)));
  const View stream = in.rest();
  const auto pdu = hal::receive_rtu(std::span(request).first(size), r.answer_bytes, buffer, Peer{Cursor(stream)});
  if (!pdu) return false;
  const std::size_t frame = pdu->size() + 3;
  const auto stands_at = [&](std::size_t at) {
    return stream.size() >= at + frame && crc_fits(stream.subspan(at, frame)) && stream[at] == r.unit &&
           std::equal(pdu->begin(), pdu->end(), stream.begin() + static_cast<std::ptrdiff_t>(at + 1));
  };
  const bool echoed = stream.size() >= size &&
                      std::equal(stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(size), request.begin());
  FUZZ_CLAIM(stands_at(0) || (echoed && stands_at(size)));
  const auto checked = hal::check_answer(*pdu, r.view(), r.answer_bytes);
  if (!checked && checked.error().error == hal::LinkError::bad_frame) return false;
  check_pdu(*pdu, r, !checked);
  return true;
}

/// A right answer behind the request's bytes of the input; by choice a refusal.
void append_answer(Bytes& input, const Request& r, bool refused) {
  input.push_back(static_cast<std::uint8_t>(refused ? r.pdu[0] + 0x80 : r.pdu[0]));
  if (refused) {
    input.push_back(2);
    return;
  }
  if (r.pdu[0] <= 4) {
    input.push_back(static_cast<std::uint8_t>(r.answer_bytes - 2));
    input.insert(input.end(), r.answer_bytes - 2, std::uint8_t{0x5A});
  } else {
    input.insert(input.end(), r.pdu.begin() + 1, r.pdu.begin() + 5);
  }
}

void repair_tcp(Bytes& input, std::uint32_t choice) {
  if (input.size() < request_bytes) input.resize(request_bytes);
  Cursor in(input);
  const Request r = request_of(in);
  if (input.size() < request_bytes + 9) {
    input.resize(request_bytes + 7);
    append_answer(input, r, choice % 3 == 0);
  }
  std::uint8_t* mbap = input.data() + request_bytes;
  if ((choice & 1) != 0) put16(mbap, r.transaction);
  if ((choice & 2) != 0) put16(mbap + 2, 0);
  if ((choice & 4) != 0) put16(mbap + 4, static_cast<unsigned>(input.size() - request_bytes - 6));
  if ((choice & 8) != 0) mbap[6] = static_cast<std::uint8_t>(r.unit);
  if ((choice & 16) != 0) mbap[7] = r.pdu[0];
  if ((choice & 32) != 0) mbap[8] = static_cast<std::uint8_t>(r.answer_bytes - 2);
}

void repair_rtu(Bytes& input, std::uint32_t choice) {
  if (input.size() < request_bytes) input.resize(request_bytes);
  Cursor in(input);
  Request r = request_of(in);
  r.unit = 1 + r.unit % 247;
  std::array<std::uint8_t, hal::max_frame_bytes> request{};
  const std::size_t size = hal::frame_rtu(r.view(), r.unit, request.data());
  if ((choice & 1) != 0) input.resize(request_bytes);
  if ((choice & 2) != 0 && input.size() == request_bytes) {
    input.insert(input.end(), request.begin(), request.begin() + static_cast<std::ptrdiff_t>(size));  // an echo
  }
  const std::size_t frame = r.answer_bytes + 3;
  const std::size_t at = (choice & 2) != 0 ? request_bytes + size : request_bytes;
  if (input.size() < at + frame) {
    input.resize(at);
    input.push_back(static_cast<std::uint8_t>(r.unit));
    append_answer(input, r, choice % 5 == 0);
    input.insert(input.end(), 2, std::uint8_t{0});
  }
  const bool refused = input[at + 1] == r.pdu[0] + 0x80;
  const std::size_t checked = (refused ? 5 : frame) - 2;
  if (input.size() < at + checked + 2) return;
  const std::uint16_t crc = hal::crc16(View(input).subspan(at, checked));
  input[at + checked] = static_cast<std::uint8_t>(crc & 0xFF);
  input[at + checked + 1] = static_cast<std::uint8_t>(crc >> 8);
}

/// One of each function, answered, refused, and cut short.
std::vector<Bytes> seeds_by(void (*repair)(Bytes&, std::uint32_t), std::uint32_t answered, std::uint32_t refused) {
  std::vector<Bytes> all;
  for (std::uint8_t f = 0; f < 7; ++f) {
    const Bytes request = {f, 0, 10, 4, 1, 9};
    for (const std::uint32_t choice : {answered, refused}) {
      Bytes input = request;
      repair(input, choice);
      all.push_back(input);
    }
    all.push_back(request);
  }
  return all;
}

std::vector<Bytes> tcp_seeds() { return seeds_by(repair_tcp, 0xF, 0x3F & ~0x30); }
std::vector<Bytes> rtu_seeds() {
  std::vector<Bytes> all = seeds_by(repair_rtu, 1, 5);
  for (const Bytes& echoed : seeds_by(repair_rtu, 3, 15)) all.push_back(echoed);
  return all;
}

}  // namespace

const Target modbus_tcp{"modbus_tcp", 300, answer_tcp, repair_tcp, tcp_seeds, nullptr};
const Target modbus_rtu{"modbus_rtu", 600, answer_rtu, repair_rtu, rtu_seeds, nullptr};

}  // namespace airside::fuzz
