#pragma once
// The daemon's status.json as somebody beside it sees it: read whole when it was replaced, and judged by its age.

#include <cstdint>
#include <ctime>
#include <string>

namespace airside::mqtt {

/// Watches one file. The daemon replaces it whole every 6 min, so it is never seen half-written.
class StatusWatch {
 public:
  explicit StatusWatch(std::string path) : path_(std::move(path)) {}

  /// Looks whether there is another status. `now_s` is of a clock that nobody sets.
  void poll(double now_s);
  /// Counts the statuses that were read; 0: none yet.
  std::uint64_t version() const { return version_; }
  /// One JSON object on one line, as the daemon wrote it.
  const std::string& text() const { return text_; }
  /// Whether the daemon writes: a status that is younger than 15 min, and does not say that it has stopped.
  bool is_current(double now_s) const;
  /// What keeps the file from being read, "" where nothing does.
  const std::string& complaint() const { return complaint_; }
  const std::string& path() const { return path_; }

 private:
  void refuse(std::string complaint);

  std::string path_, text_, complaint_ = "no status yet";
  std::uint64_t version_ = 0;
  std::uint64_t inode_ = 0;
  std::timespec changed_{};  ///< time of the file's last change, by the file system
  double seen_s_ = 0;        ///< when this status was first seen
  bool stopped_ = false;
};

}  // namespace airside::mqtt
