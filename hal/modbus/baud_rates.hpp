#pragma once
// The speeds of a serial line.

#include <array>

namespace airside::hal {

/// Baud. libmodbus opens a line of any other at 9600, and says nothing.
constexpr std::array baud_rates = {1200,   2400,   4800,   9600,   19200,  38400, 57600,
                                   115200, 230400, 460800, 500000, 576000, 921600};

}  // namespace airside::hal
