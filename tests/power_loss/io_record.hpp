#pragma once
// The write log of a real process: what io_probe.cpp (preloaded into airsided) records, one entry a call, as a byte
// stream in the order of the calls. Names are paths below AIRSIDE_IO_ROOT.

#include <cstdint>
#include <type_traits>

namespace airside::power_loss {

enum class IoKind : std::uint16_t {
  start = 0,        ///< a process begins
  create = 1,       ///< name, inode: a file that was not there before
  write = 2,        ///< inode, offset, payload
  truncate = 3,     ///< inode, offset: new size
  allocate = 4,     ///< inode, offset: at least this size
  sync_file = 5,    ///< inode
  sync_dir = 6,     ///< name of the folder
  rename = 7,       ///< name, zero byte, new name
  unlink = 8,       ///< name
  failed_sync = 9,  ///< inode: the kernel may have dropped what was to be written, and call it clean
  failed = 10,      ///< some other call
};

/// Stands before `name_bytes` of name and `payload_bytes` of payload.
struct IoEntry {
  static constexpr std::uint32_t mark = 0x4F494149;  // "IAIO" in file order
  std::uint32_t magic = mark;
  IoKind kind = IoKind::start;
  std::uint16_t name_bytes = 0;
  std::uint64_t inode = 0;
  std::uint64_t offset = 0;
  std::uint64_t payload_bytes = 0;
};
static_assert(sizeof(IoEntry) == 32 && std::has_unique_object_representations_v<IoEntry>);

}  // namespace airside::power_loss
