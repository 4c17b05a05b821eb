#pragma once
// Where a training will put its weights: tried and reserved before hours are spent, and never the end of what they
// made.

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "hal/text/unfinished.hpp"

namespace airside::tools {

class BlobPlace {
 public:
  /// Reserves `bytes` in a file beside `path`, which becomes the blob at the end.
  /// Errors: hal::InputError for a place that cannot be written or has no room for so much.
  BlobPlace(std::string path, std::size_t bytes);
  ~BlobPlace();
  BlobPlace(const BlobPlace&) = delete;
  BlobPlace& operator=(const BlobPlace&) = delete;

  /// Writes, syncs and renames: the file is the old or the new one. Where the place has been lost meanwhile the blob is
  /// kept in the folder for temporary files.
  /// Errors: hal::InputError, saying where the blob is kept.
  void write(std::span<const std::byte> blob);

 private:
  [[noreturn]] void keep_elsewhere(std::span<const std::byte> blob, int error);

  std::string path_, part_;
  int file_ = -1;
  std::optional<hal::UnfinishedPath> unfinished_;
};

}  // namespace airside::tools
