#pragma once
// Text and an exit code through a debugger or QEMU (Arm semihosting 3.0). Only the test image uses it: a product has
// its own serial line.

#include <cstdint>
#include <span>
#include <string_view>

namespace airside::cortex_m {

enum class Stream : std::uint8_t { output, remarks };

/// Writes text to the debugger's standard output, or (remarks) to its standard error.
void semihosting_write(Stream stream, std::string_view text);

/// Arguments given to the image, into `buffer`; empty where there are none.
std::string_view semihosting_arguments(std::span<char> buffer);

[[noreturn]] void semihosting_exit(int code);

}  // namespace airside::cortex_m
