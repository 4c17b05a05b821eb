#include "firmware/cortex_m/semihosting.hpp"

#include <array>

namespace airside::cortex_m {
namespace {

enum Operation : std::uint32_t { sys_open = 0x01, sys_write = 0x05, sys_get_cmdline = 0x15, sys_exit_extended = 0x20 };

using Word = std::uint32_t;

Word call(Operation operation, const Word* arguments) {
  register Word r0 asm("r0") = operation;
  register const Word* r1 asm("r1") = arguments;
  asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

Word address(const void* p) { return reinterpret_cast<Word>(p); }

/// The console opened for writing is standard output, opened for appending standard error.
Word open_console(Stream stream) {
  static constexpr char console[] = ":tt";
  constexpr Word write_mode = 4, append_mode = 8;
  const std::array<Word, 3> arguments{address(console), stream == Stream::output ? write_mode : append_mode, 3};
  return call(sys_open, arguments.data());
}

}  // namespace

void semihosting_write(Stream stream, std::string_view text) {
  static std::array<Word, 2> handles{};  // 0: not yet open
  Word& handle = handles[static_cast<std::size_t>(stream)];
  if (handle == 0) handle = open_console(stream);
  const std::array<Word, 3> arguments{handle, address(text.data()), static_cast<Word>(text.size())};
  call(sys_write, arguments.data());
}

std::string_view semihosting_arguments(std::span<char> buffer) {
  std::array<Word, 2> arguments{address(buffer.data()), static_cast<Word>(buffer.size())};
  asm volatile("" : : "r"(arguments.data()) : "memory");
  return call(sys_get_cmdline, arguments.data()) == 0 ? std::string_view(buffer.data(), arguments[1])
                                                      : std::string_view();
}

void semihosting_exit(int code) {
  constexpr Word application_exit = 0x20026;
  const std::array<Word, 2> arguments{application_exit, static_cast<Word>(code)};
  call(sys_exit_extended, arguments.data());
  for (;;) asm volatile("wfi");
}

}  // namespace airside::cortex_m
