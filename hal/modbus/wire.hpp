#pragma once
// Bytes on a file descriptor against one absolute deadline, and the checksum of serial Modbus. A peer that
// trickles, stalls or hangs up can cost no more than the deadline.

#include <cstddef>
#include <cstdint>
#include <span>

namespace airside::hal {

/// Nanoseconds of CLOCK_MONOTONIC; jumps of the wall clock do not reach it.
std::int64_t monotonic_ns();

/// Nanoseconds of a duration. Units: s.
constexpr std::int64_t to_ns(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }

enum class WireResult : std::uint8_t { done, timed_out, closed };

/// Sends all bytes before the deadline. Works on sockets and serial lines, blocking or not.
WireResult send_all(int fd, std::span<const std::uint8_t> bytes, std::int64_t deadline_ns);

/// Receives exactly bytes.size() bytes before the deadline; `received` says how many came.
WireResult receive_exact(int fd, std::span<std::uint8_t> bytes, std::int64_t deadline_ns, std::size_t& received);

/// What stands on a line that should be silent.
enum class IdleState : std::uint8_t { silent, bytes_waiting, closed };
IdleState idle_state(int fd);

/// Reads and drops bytes until the line has been silent for silence_ns. False: still busy at the deadline.
bool drain_until_silent(int fd, std::int64_t silence_ns, std::int64_t deadline_ns);

/// A 16-bit number as Modbus has it on the wire, high byte first.
inline void put16(std::uint8_t* at, unsigned value) {
  at[0] = static_cast<std::uint8_t>(value >> 8);
  at[1] = static_cast<std::uint8_t>(value & 0xFFU);
}
inline unsigned get16(const std::uint8_t* at) { return unsigned{at[0]} << 8 | at[1]; }

/// CRC-16 of serial Modbus, low byte first on the wire. Source: Modbus over Serial Line V1.02, 6.2.2.
std::uint16_t crc16(std::span<const std::uint8_t> bytes);

}  // namespace airside::hal
