#pragma once
// What can go wrong when state is written to storage, as values: the daemon runs on in RAM and raises an alarm.

#include <cstdint>
#include <string>
#include <tl/expected.hpp>

namespace airside::hal {

enum class StoreFault : std::uint8_t {
  none = 0,
  no_space = 1,       ///< disk full, quota or file size limit
  read_only = 2,      ///< file system or folder cannot be written
  io = 3,             ///< the device failed a read, write or sync
  locked = 4,         ///< another process uses the folder
  not_found = 5,      ///< the folder does not exist and cannot be made
  wrong_size = 6,     ///< a span does not have the size that the store was opened with
  other_layout = 7,   ///< valid state of another topology, control cycle or build stands there
  log_shorter = 8,    ///< the log ends before the committed position: rows were lost
  out_of_order = 9,   ///< a row is not after the last one
  row_too_long = 10,  ///< a row does not fit the buffer
  unread = 11,        ///< state stands there that could not be read when it was asked for: load it before committing
  removed = 12,       ///< files were removed or replaced while they were in use
  wrong_kind = 13,    ///< a link, a pipe or a folder is at the place of a file, or a link at that of a folder
};

/// A fault, the errno behind it (0 where there is none) and what was being done.
struct StoreError {
  StoreFault fault = StoreFault::none;
  int error_number = 0;
  const char* step = "";  ///< static text such as "sync row record"
};

template <class V>
using StoreResult = tl::expected<V, StoreError>;

/// Whether the same call may succeed the next time: the system failed it, or what lies in the way may be taken away.
constexpr bool may_pass(const StoreError& error) {
  return error.fault == StoreFault::wrong_kind || (error.error_number != 0 && error.fault != StoreFault::not_found);
}

/// "disk full", "another process uses it" ...
const char* text_of(StoreFault fault);

/// What a person does about it: "free some space; ...".
const char* remedy_of(StoreFault fault);

/// One sentence for the log and the page: step, fault, errno's text, remedy.
std::string describe(const StoreError& error);

/// Sorts an errno of open, write or sync into a fault.
StoreError store_error(int error_number, const char* step);

/// Whether writes are forced to the medium. none: simulations; a killed process still loses nothing, a power cut may.
enum class Sync : std::uint8_t { full, none };

}  // namespace airside::hal
