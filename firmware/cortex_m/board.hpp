#pragma once
// What startup.cpp and the linker script give to the program and expect of it: memory that has a name, the stack's
// paint, a counter.

#include <cstddef>
#include <cstdint>

/// The program: called once memory and FPU are ready. Returns the exit code.
int run_image();

namespace airside::cortex_m {

/// Objects for the large RAM, not for the one next to the core. Zero at reset.
#define AIRSIDE_LARGE_RAM [[gnu::section(".large_ram")]]

/// Bytes of the stack that were touched since reset, and all there are.
std::size_t stack_deepest();
std::size_t stack_size();

/// Instructions since reset, where the emulator counts them (QEMU -icount shift=0; steps of 40). The timer is that of
/// the MPS2 board and ticks at 25 MHz. Not a measure of time: caches, wait states and double issue are not in it.
void start_instruction_counter();
std::uint64_t instructions();

}  // namespace airside::cortex_m
