#pragma once
// A folder of files that appear together, or not at all.

#include <filesystem>
#include <initializer_list>
#include <optional>

#include "hal/text/unfinished.hpp"

namespace airside::hal {

/// Files are written into a staging folder `NAME.PID.part` beside the target, or `.PID.part` inside it where the target
/// exists already, and moved at the end. A run that stops half-way, or that a signal ends, leaves nothing
/// (clean_up_on_signals()); what a killed one has left, the next one for the same target removes.
/// Errors: InputError when the folder cannot be made or filled.
class StagedFolder {
 public:
  explicit StagedFolder(std::filesystem::path target);
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  /// Where to write meanwhile.
  const std::filesystem::path& path() const { return staging_; }
  /// Moves everything to the target, `last` after all other files: who finds it finds them, also after a run that was
  /// killed meanwhile; a signal that can wait does. Files of the same names that lie there are replaced, those that are
  /// `superseded` removed, others stay.
  void commit(const std::filesystem::path& last, std::initializer_list<const char*> superseded = {});

 private:
  void remove_left_over() const;
  void replace_files(const std::filesystem::path& last, std::initializer_list<const char*> superseded) const;
  [[noreturn]] void fail(const std::error_code& error) const;

  std::filesystem::path target_, staging_;
  std::optional<UnfinishedPath> unfinished_;
};

}  // namespace airside::hal
