#pragma once
// Registers to physical numbers and back, as a Point says. The simulator rounds its sensors with the same
// functions, so a run over Modbus and a run in one process see the same bits.

#include <array>
#include <cstdint>
#include <span>

#include "airside/fault.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

/// The registers of one point; a coil or discrete input is 0 or 1 in the first. Shape: point.width() used.
struct Registers {
  std::array<std::uint16_t, 2> word{};
  int count = 1;
  std::span<const std::uint16_t> used() const { return {word.data(), static_cast<std::size_t>(count)}; }
};

/// raw = round((value - offset) / scale), halves away from zero; float32 is not rounded to an integer.
/// Errors: not_finite; out_of_range where the type cannot hold raw or raw is one of the point's sentinels.
/// Cost: no heap.
Expected<Registers> encode(const Point& point, double value);

/// value = raw * scale + offset, to the millionth.
/// Errors: not_finite for a sentinel, NaN or Inf; out_of_range beyond the point's min and max, or too few
/// registers. Cost: no heap.
Expected<double> decode(const Point& point, std::span<const std::uint16_t> registers);

/// What a reader of the point sees of a value: decode(encode(value)), NaN where either fails.
double rounded(const Point& point, double value);

/// Registers that every reader must take for "no value": the first sentinel, or NaN, or the type's extreme.
Registers invalid_registers(const Point& point);

}  // namespace airside::hal
