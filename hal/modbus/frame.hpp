#pragma once
// Modbus frames, TCP and serial: requests as bytes, and answers taken from whatever bytes come. Nothing here knows a
// socket, so every answer that a peer may give can be tried on the code that judges it.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tl/expected.hpp>

#include "hal/modbus/wire.hpp"

namespace airside::hal {

enum class LinkError : std::uint8_t {
  backing_off,        ///< the last attempt failed; the next one is not due yet
  connect_failed,     ///< nobody answers at the address
  timed_out,          ///< no whole answer before the deadline
  closed_by_peer,     ///< FIN, RST or a vanished device
  bad_frame,          ///< protocol number, length, checksum or echo do not fit
  wrong_transaction,  ///< a late or invented answer
  wrong_unit,         ///< another unit's answer
  exception_answer,   ///< the device refused; the code is beside it
  bad_request,        ///< the caller's function, address or count is none that Modbus knows
  other_connection,   ///< not written: the connection is not the one that the caller has verified
};
const char* text_of(LinkError error);

/// Why an exchange gave nothing. `exception` is the device's code with exception_answer, else 0.
struct LinkFault {
  LinkError error;
  std::uint8_t exception = 0;
};
template <class V>
using LinkResult = tl::expected<V, LinkFault>;

constexpr std::size_t mbap_bytes = 7;                                    ///< before the PDU on TCP
constexpr std::size_t max_pdu_bytes = 253;                               ///< function and content
constexpr std::size_t max_frame_bytes = mbap_bytes + max_pdu_bytes + 2;  ///< of either kind
constexpr std::uint8_t exception_bit = 0x80;  ///< of an answer's function: the device refuses

inline LinkFault link_fault(WireResult wire) {
  return {wire == WireResult::timed_out ? LinkError::timed_out : LinkError::closed_by_peer};
}

/// Writes a request to `out`, max_frame_bytes long, and returns its length.
std::size_t frame_tcp(std::span<const std::uint8_t> pdu, std::uint16_t transaction, int unit, std::uint8_t* out);
std::size_t frame_rtu(std::span<const std::uint8_t> pdu, int unit, std::uint8_t* out);

/// Whether an answer of `answer_bytes` is what the request `pdu` asked for.  Shape: answer: at least 2 bytes.
/// Errors: bad_frame; exception_answer with the device's code.
LinkResult<void> check_answer(std::span<const std::uint8_t> answer, std::span<const std::uint8_t> pdu,
                              std::size_t answer_bytes);

/// Takes one answer to `request` from `receive(std::span<std::uint8_t> exactly, std::size_t& received) -> WireResult`
/// and returns its PDU, a part of `buffer`.  Shape: buffer: max_frame_bytes.
/// Errors: as `receive` says; bad_frame, wrong_transaction, wrong_unit.
template <class Receive>
LinkResult<std::span<const std::uint8_t>> receive_tcp(std::span<const std::uint8_t> request,
                                                      std::span<std::uint8_t> buffer, Receive&& receive) {
  std::size_t received = 0;
  WireResult got = receive(buffer.first(mbap_bytes), received);
  if (got != WireResult::done) return tl::unexpected(link_fault(got));
  const std::size_t length = get16(&buffer[4]);
  if (get16(&buffer[2]) != 0 || length < 3 || length > 1 + max_pdu_bytes) {
    return tl::unexpected(LinkFault{LinkError::bad_frame});
  }
  if (get16(&buffer[0]) != get16(&request[0])) return tl::unexpected(LinkFault{LinkError::wrong_transaction});
  if (buffer[6] != request[6]) return tl::unexpected(LinkFault{LinkError::wrong_unit});
  got = receive(buffer.subspan(mbap_bytes, length - 1), received);
  if (got != WireResult::done) return tl::unexpected(link_fault(got));
  return buffer.subspan(mbap_bytes, length - 1);
}

/// The same on a serial line: `answer_bytes` is the PDU's length where the device does not refuse.
template <class Receive>
LinkResult<std::span<const std::uint8_t>> receive_rtu(std::span<const std::uint8_t> request, std::size_t answer_bytes,
                                                      std::span<std::uint8_t> buffer, Receive&& receive) {
  constexpr std::size_t exception_frame = 5;
  std::size_t have = 0;
  bool echo_dropped = false;
  const auto fill_to = [&](std::size_t wanted) {
    if (have >= wanted) return WireResult::done;
    std::size_t more = 0;
    const WireResult got = receive(buffer.subspan(have, wanted - have), more);
    have += more;
    return got;
  };
  while (true) {
    WireResult got = fill_to(exception_frame);
    if (got != WireResult::done) return tl::unexpected(link_fault(got));
    const bool refused = buffer[1] == (request[1] | exception_bit);
    const std::size_t frame = refused ? exception_frame : answer_bytes + 3;
    got = fill_to(frame);
    if (got != WireResult::done) return tl::unexpected(link_fault(got));
    if (crc16(buffer.first(frame)) == 0) {
      if (buffer[0] != request[0]) return tl::unexpected(LinkFault{LinkError::wrong_unit});
      return buffer.subspan(1, frame - 3);
    }
    // Some adapters hear their own request: drop exactly that, once. What has come tells whether to wait for the rest.
    const auto echoes = [&](std::size_t bytes) {
      return std::equal(request.begin(), request.begin() + static_cast<std::ptrdiff_t>(bytes), buffer.begin());
    };
    if (echo_dropped || !echoes(std::min(have, request.size()))) {
      return tl::unexpected(LinkFault{LinkError::bad_frame});
    }
    got = fill_to(request.size());
    if (got != WireResult::done) return tl::unexpected(link_fault(got));
    if (!echoes(request.size())) return tl::unexpected(LinkFault{LinkError::bad_frame});
    std::copy(buffer.begin() + static_cast<std::ptrdiff_t>(request.size()),
              buffer.begin() + static_cast<std::ptrdiff_t>(have), buffer.begin());
    have -= request.size();
    echo_dropped = true;
  }
}

}  // namespace airside::hal
