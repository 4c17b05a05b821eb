#pragma once
// A file that is written piece by piece and appears whole or not at all.

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "hal/text/unfinished.hpp"

namespace airside::hal {

/// Writes to `NAME.part` beside the target and renames it at the end: what stood there before stays until then, and a
/// run that stops half-way leaves no file that looks whole, and no part where a signal ends it (clean_up_on_signals()).
/// A pipe or a device is written directly. For host tools: a power cut may lose it; the box's files go by way of
/// write_file_atomically().
/// Errors: InputError when the file cannot be made, written, or put in its place; the part is removed.
class StagedFile {
 public:
  explicit StagedFile(const std::string& path);
  ~StagedFile();
  StagedFile(const StagedFile&) = delete;
  StagedFile& operator=(const StagedFile&) = delete;

  void write(std::string_view text);
  /// Closes and renames; without it nothing appears. A second call does nothing.
  void commit();

 private:
  [[noreturn]] void fail(int error) const;

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;    ///< as it was given, for complaints
  std::string target_;  ///< behind a link
  std::string part_;    ///< the target itself where it is a pipe or a device
  std::optional<UnfinishedPath> unfinished_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace airside::hal
