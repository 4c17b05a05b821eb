#pragma once
// One older learning state beside the durable store: what a box goes back to when pushed weights do not prove
// themselves.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "hal/storage/store_error.hpp"

namespace airside::hal {

/// The file `previous` of the state folder, known by a digest that the row record keeps: the copy stands as
/// `previous.new` before the commit that names it, and becomes `previous` after it. Whichever generation a power cut
/// leaves finds its own copy under one of the two names. Bytes in docs/formats.md.
class StateCopy {
 public:
  /// `meaning`: as in StoreLayout; a copy of another one is not read.
  StateCopy(std::string dir, std::uint64_t meaning, Sync sync = Sync::full)
      : dir_(std::move(dir)), meaning_(meaning), sync_(sync) {}

  /// Writes a copy beside the one that `in_force` names and returns its digest, never 0.
  /// Errors: no_space, read_only, io; the copy in force then still stands. Cost: one file, no heap.
  StoreResult<std::uint64_t> save(std::span<const std::byte> learning, std::uint64_t in_force);
  /// Makes the copy named by a commit the only one; one that is it already stays. Errors: as save().
  StoreResult<void> settle(std::uint64_t digest);
  /// Reads the copy of this digest back. Errors: not_found; other_layout; wrong_size; io where its digest does not
  /// hold. `into` is then unspecified.
  StoreResult<void> load(std::span<std::byte> into, std::uint64_t digest) const;
  /// Whether a copy can be written where one belongs. Errors: wrong_kind where something that is no file lies under one
  /// of the two names. Cost: two files looked at, no heap.
  StoreResult<void> blocked() const;

 private:
  StoreResult<void> load_from(const char* name, std::span<std::byte> into, std::uint64_t digest) const;
  std::string dir_;
  std::uint64_t meaning_;
  Sync sync_;
};

}  // namespace airside::hal
