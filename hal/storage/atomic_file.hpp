#pragma once
// Replaces a file so that a power cut leaves the old content or the new one.

#include <cstddef>
#include <span>
#include <string>

#include "hal/storage/storage_file.hpp"
#include "hal/storage/store_error.hpp"

namespace airside::hal {

/// Writes `bytes` to `path` by way of `path.PID.new`, a file of this process's own: write, sync, rename, sync the
/// folder. One that was killed leaves it behind; nobody reads it. Errors: no_space, read_only, io, not_found; the old
/// file then still stands. If the very last step fails, the new file stands and may fall back to the old one in a power
/// cut.
StoreResult<void> write_file_atomically(const std::string& path, std::span<const std::byte> bytes,
                                        Sync sync = Sync::full);

/// The same for `name` in an open folder, whatever its path leads to by now: for folders that others may write to.
StoreResult<void> write_file_atomically(const StorageFile& folder, const std::string& name,
                                        std::span<const std::byte> bytes, Sync sync = Sync::full);

}  // namespace airside::hal
