#pragma once
// A folder of files that appear together, or not at all.

#include <filesystem>
#include <optional>

#include "hal/text/unfinished.hpp"

namespace airside::hal {

/// Files are written into a staging folder beside the target, or inside it where the target exists already, and moved
/// at the end. A run that stops half-way, or that a signal ends, leaves nothing (clean_up_on_signals()).
/// Errors: InputError when the folder cannot be made or filled.
class StagedFolder {
 public:
  explicit StagedFolder(std::filesystem::path target);
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  /// Where to write meanwhile.
  const std::filesystem::path& path() const { return staging_; }
  /// Moves everything to the target, `last` after all other files: who finds it finds them. Files of the same names
  /// that lie there are replaced, others stay.
  void commit(const std::filesystem::path& last);

 private:
  [[noreturn]] void fail(const std::error_code& error) const;

  std::filesystem::path target_, staging_;
  std::optional<UnfinishedPath> unfinished_;
};

}  // namespace airside::hal
