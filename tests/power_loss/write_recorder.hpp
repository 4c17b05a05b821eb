#pragma once
// Stands between the program and the kernel: records every write and sync of this test program, passes them on, and
// fails those that a test chooses. The code under test is the shipped one; only libc's entry points are replaced.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace airside::hal {

struct WriteOp {
  enum class Kind { write, sync, failed_sync, truncate } kind;
  std::string file;          ///< name without folder
  std::uint64_t offset = 0;  ///< of a write; size of a truncate
  std::vector<std::byte> bytes;
};

/// Records while it lives.
class WriteRecorder {
 public:
  WriteRecorder();
  ~WriteRecorder();
  WriteRecorder(const WriteRecorder&) = delete;
  WriteRecorder& operator=(const WriteRecorder&) = delete;

  std::vector<WriteOp> ops;
  int calls = 0;       ///< of pwrite, fdatasync, fsync and ftruncate
  int fail_at = -1;    ///< index of the call that fails; a failing pwrite still writes half of its bytes
  int fail_count = 1;  ///< so many calls from fail_at on fail
  int fail_errno = 0;
  bool fails_now();  ///< counts a call
};

}  // namespace airside::hal
