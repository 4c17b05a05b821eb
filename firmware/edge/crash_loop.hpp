#pragma once
// A daemon that was started too often in a short time must not control anything.

#include <cstdint>
#include <string>

#include "hal/storage/start_ledger.hpp"

namespace airside::edge {

/// Counts starts that had no orderly end, in the file `starts` of the state folder.
class CrashLoop {
 public:
  static constexpr std::int64_t window_s = 600;

  /// `limit`: this many starts within window_s are a loop; 0: never.
  CrashLoop(const std::string& state_dir, int limit, hal::Sync sync)
      : state_dir_(state_dir), limit_(limit), starts_(state_dir, sync) {}

  /// Notes this start. Where it cannot be written, that is said.
  void start();
  /// Whether this start is one too many; says so.
  bool is_met() const;
  /// Control begins.
  void begin();
  /// Once a row: after an hour that was run through nothing is left of the past.
  void row();
  /// An orderly end is no crash, whatever came before it.
  void end();
  /// Whether this start is noted; row() tries again where it is not.
  bool is_kept() const { return state_dir_.empty() || starts_.is_kept(); }

 private:
  std::string state_dir_;
  int limit_;
  hal::StartLedger starts_;
  int recent_starts_ = 0;
  std::int64_t began_ns_ = 0;  ///< of this run
};

}  // namespace airside::edge
