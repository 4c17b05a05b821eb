#pragma once
// One older learning state beside the durable store: what a box goes back to when pushed weights do not prove
// themselves.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hal/store_error.hpp"

namespace airside::hal {

/// The file `previous` of the state folder. Written whole before weights are exchanged, so that it always stands while
/// a trial runs; bytes in FORMATS.md.
class StateCopy {
 public:
  /// `meaning`: as in StoreLayout; a copy of another one is not read.
  StateCopy(std::string dir, std::uint64_t meaning, Sync sync = Sync::full)
      : dir_(std::move(dir)), meaning_(meaning), sync_(sync) {}

  /// Replaces the copy. Errors: no_space, read_only, io; the old copy then still stands. Cost: one file, no heap.
  StoreResult<void> save(std::span<const std::byte> learning);
  /// Reads it back. Errors: not_found; other_layout; wrong_size; io where its digest does not hold. `into` is then
  /// unspecified.
  StoreResult<void> load(std::span<std::byte> into) const;

 private:
  std::string dir_;
  std::uint64_t meaning_;
  Sync sync_;
};

}  // namespace airside::hal
