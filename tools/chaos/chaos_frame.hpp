#pragma once
// Requests and answers as the proxy reads and changes them. Frames of Modbus TCP, header included.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/modbus/wire.hpp"
#include "tools/chaos/chaos_script.hpp"

namespace airside::tools {

/// A request with at least a function.
ChaosRequest parsed(const std::vector<std::uint8_t>& adu);
/// What a server says to a write that it takes.
std::vector<std::uint8_t> confirmation_of(const std::vector<std::uint8_t>& asked);
std::vector<std::uint8_t> exception_to(const std::vector<std::uint8_t>& asked, int code);
/// Place of register `addr` in a register answer; 0: it is not there.
std::size_t place_of(const ChaosRequest& r, const std::vector<std::uint8_t>& answer, int addr);
/// Faults that change values are none in an exchange without them.
bool touches(const ChaosFault& fault, const ChaosRequest& r);

/// The written registers of a request of function 6 or 16, changed.
template <class Change>
void change_written(std::vector<std::uint8_t>& asked, const Change& change) {
  const auto one = [&](std::size_t at) {
    hal::put16(&asked[at],
               static_cast<unsigned>(std::clamp(change(static_cast<double>(hal::get16(&asked[at]))), 0.0, 65535.0)));
  };
  if (asked[7] == 6 && asked.size() >= 12) one(10);
  if (asked[7] != 16) return;
  for (std::size_t at = 13; at + 1 < asked.size(); at += 2) one(at);
}

}  // namespace airside::tools
