#pragma once
// The names in a folder without heap: opendir() would ask for it.

#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>

namespace airside::hal {

/// Calls `look(name)` for each name in the open folder until it returns false.
/// Errors: false where the folder cannot be listed; errno says why. Cost: 4 kB of stack, no heap.
template <class Look>
bool for_each_name(int dir_fd, const Look& look) {
  /// As the kernel writes it; getdents64(2).
  struct Entry {
    std::uint64_t inode;
    std::int64_t next;
    std::uint16_t length;
    std::uint8_t type;
  };
  constexpr std::size_t name_offset = 19;
  alignas(8) char entries[4096];
  if (::lseek(dir_fd, 0, SEEK_SET) < 0) return false;
  while (true) {
    const long got = ::syscall(SYS_getdents64, dir_fd, entries, sizeof entries);
    if (got <= 0) return got == 0;
    for (long at = 0; at < got;) {
      Entry entry;
      std::memcpy(&entry, entries + at, sizeof entry);
      if (!look(entries + at + name_offset)) return true;
      at += entry.length;
    }
  }
}

}  // namespace airside::hal
