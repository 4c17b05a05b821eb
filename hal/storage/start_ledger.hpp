#pragma once
// How often a program was started lately without having ended in order: a crash loop must not control anything.

#include <cstdint>
#include <string>

#include "hal/storage/store_error.hpp"

namespace airside::hal {

/// The last starts, in one small file `starts` of a folder; written whole, checked by digest.
class StartLedger {
 public:
  /// Opens or makes the file. Errors: none; where it cannot be had, every start looks like the first.
  explicit StartLedger(const std::string& dir, Sync sync = Sync::full) : dir_(dir), sync_(sync) {}

  /// Notes a start now and returns how many there were within `window_s`, this one included. Both the wall clock and
  /// the time since the machine's start count, so that neither a clock that is set nor a reboot hides a loop.
  int record(std::int64_t window_s);
  /// The program has run well, or ends in order: nothing is left of the past.
  void clear();
  /// Writes what record() could not.
  void keep();
  /// Whether the last record() reached the file; where it did not, a crash loop is not seen.
  bool is_kept() const { return kept_; }

 private:
  static constexpr int most = 8;
  struct Start {
    std::int64_t wall_s = 0, since_boot_s = 0;
  };
  struct File {
    std::uint64_t magic = 0, count = 0;
    Start start[most]{};
    std::uint64_t digest = 0;
  };
  bool read(File& file) const;
  bool write(File& file) const;

  std::string dir_;
  Sync sync_;
  File last_;  ///< what record() wrote, or could not
  bool kept_ = true;
};

}  // namespace airside::hal
