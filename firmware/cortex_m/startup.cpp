// From reset to run_image(): vector table, FPU, memory, a painted stack. A fault ends the program with a line that
// names it.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "firmware/cortex_m/board.hpp"
#include "firmware/cortex_m/line_writer.hpp"
#include "firmware/cortex_m/semihosting.hpp"

extern "C" {
// From the linker script; only their addresses mean something.
extern std::uint32_t stack_bottom, stack_top, data_load, data_begin, data_end, bss_begin, bss_end, large_begin,
    large_end;

[[noreturn]] void reset();
[[noreturn]] void run_from_reset();
[[noreturn]] void abort();
void fault();
[[noreturn]] void fault_at(const std::uint32_t* frame);
}

namespace airside::cortex_m {
namespace {

constexpr std::uint32_t paint = 0xA5A5A5A5;

std::span<std::uint32_t> words(std::uint32_t& begin, std::uint32_t& end) {
  return {&begin, static_cast<std::size_t>(&end - &begin)};
}

/// CMSDK timer 0 of the MPS2 board, counting down from all ones.
struct Timer {
  std::uint32_t control, value, reload;
};
volatile Timer& timer() { return *reinterpret_cast<volatile Timer*>(0x40000000); }

}  // namespace

std::size_t stack_size() { return words(stack_bottom, stack_top).size_bytes(); }

std::size_t stack_deepest() {
  const auto stack = words(stack_bottom, stack_top);
  const auto touched = std::find_if(stack.begin(), stack.end(), [](std::uint32_t word) { return word != paint; });
  return static_cast<std::size_t>(stack.end() - touched) * sizeof(std::uint32_t);
}

void start_instruction_counter() {
  timer().reload = 0xFFFFFFFF;
  timer().value = 0xFFFFFFFF;
  timer().control = 1;
}

std::uint64_t instructions() {
  constexpr std::uint64_t a_tick = 40;
  return a_tick * (0xFFFFFFFF - timer().value);
}

}  // namespace airside::cortex_m

using namespace airside::cortex_m;

/// Before anything else: without this the first floating-point instruction, even a saved register, is a fault.
[[gnu::naked]] void reset() {
  asm volatile(
      "ldr r0, =0xE000ED88\n"  // CPACR: full access to coprocessors 10 and 11
      "ldr r1, [r0]\n"
      "orr r1, r1, #0xF00000\n"
      "str r1, [r0]\n"
      "dsb\n"
      "isb\n"
      "b run_from_reset\n");
}

void run_from_reset() {
  // Below where we stand now; what lies above belongs to this function.
  auto* const here = static_cast<std::uint32_t*>(__builtin_frame_address(0)) - 64;
  std::fill(&stack_bottom, here, paint);
  std::copy_n(&data_load, words(data_begin, data_end).size(), &data_begin);
  std::ranges::fill(words(bss_begin, bss_end), 0u);
  std::ranges::fill(words(large_begin, large_end), 0u);
  semihosting_exit(run_image());
}

/// To fault_at() with the frame that the processor left on the stack; from the stack's top if that has overflowed.
[[gnu::naked]] void fault() {
  asm volatile(
      "mov r0, sp\n"
      "ldr r1, =stack_bottom\n"
      "ldr r2, =stack_top\n"
      "cmp r0, r1\n"
      "it lo\n"
      "movlo sp, r2\n"
      "b fault_at\n");
}

void fault_at(const std::uint32_t* frame) {
  const auto word = [](std::uint32_t address) { return *reinterpret_cast<volatile std::uint32_t*>(address); };
  LineWriter line([](std::string_view text) { semihosting_write(Stream::remarks, text); });
  if (frame < &stack_bottom) {
    line.text("fault: the stack overflowed").end();
    semihosting_exit(3);
  }
  line.text("fault: at ").hex(frame[6], 8).text(", called from ").hex(frame[5], 8);
  line.text(", CFSR ").hex(word(0xE000ED28), 8).text(", HFSR ").hex(word(0xE000ED2C), 8);
  line.text(", address ").hex(word(0xE000ED38), 8).end();
  semihosting_exit(3);
}

// The C library's would bring in signals, and with them its heap.
extern "C" void abort() {
  semihosting_write(Stream::remarks, "fault: abort()\n");
  semihosting_exit(3);
}
// libgcc's divisions refer to the unwinder, which nothing here can ever start.
extern "C" void __aeabi_unwind_cpp_pr0() {}
extern "C" void __aeabi_unwind_cpp_pr1() {}

[[gnu::section(".vectors"), gnu::used]] constexpr std::array<void (*)(), 16> vectors_after_stack{reset, fault, fault,
                                                                                                 fault, fault, fault};
