#include "hal/modbus/frame.hpp"

namespace airside::hal {

const char* text_of(LinkError error) {
  switch (error) {
    case LinkError::backing_off: return "waiting before the next attempt";
    case LinkError::connect_failed: return "cannot connect";
    case LinkError::timed_out: return "no answer before the deadline";
    case LinkError::closed_by_peer: return "connection closed by the device";
    case LinkError::bad_frame: return "answer is not a valid frame";
    case LinkError::wrong_transaction: return "answer to another request";
    case LinkError::wrong_unit: return "answer of another unit";
    case LinkError::exception_answer: return "device refused the request";
    case LinkError::bad_request: return "request outside what Modbus allows";
    case LinkError::other_connection: return "not on a connection that was not read first";
  }
  return "unknown";
}

std::size_t frame_tcp(std::span<const std::uint8_t> pdu, std::uint16_t transaction, int unit, std::uint8_t* out) {
  put16(out, transaction);
  put16(out + 2, 0);
  put16(out + 4, static_cast<unsigned>(pdu.size() + 1));
  out[6] = static_cast<std::uint8_t>(unit);
  std::ranges::copy(pdu, out + mbap_bytes);
  return mbap_bytes + pdu.size();
}

std::size_t frame_rtu(std::span<const std::uint8_t> pdu, int unit, std::uint8_t* out) {
  out[0] = static_cast<std::uint8_t>(unit);
  std::ranges::copy(pdu, out + 1);
  const std::size_t checked = 1 + pdu.size();
  const std::uint16_t crc = crc16({out, checked});
  out[checked] = static_cast<std::uint8_t>(crc & 0xFFU);
  out[checked + 1] = static_cast<std::uint8_t>(crc >> 8);
  return checked + 2;
}

LinkResult<void> check_answer(std::span<const std::uint8_t> answer, std::span<const std::uint8_t> pdu,
                              std::size_t answer_bytes) {
  if (answer.size() == 2 && answer[0] == (pdu[0] | exception_bit)) {
    return tl::unexpected(LinkFault{LinkError::exception_answer, answer[1]});
  }
  const auto bad = tl::unexpected(LinkFault{LinkError::bad_frame});
  if (answer[0] != pdu[0] || answer.size() != answer_bytes) return bad;
  if (pdu[0] <= 4) {
    if (answer[1] != answer_bytes - 2) return bad;
    return {};
  }
  // A write is confirmed by its own address, and by its count; a single value may come back clamped.
  const std::ptrdiff_t confirmed = pdu[0] == 16 ? 5 : 3;
  if (!std::equal(answer.begin(), answer.begin() + confirmed, pdu.begin())) return bad;
  return {};
}

}  // namespace airside::hal
