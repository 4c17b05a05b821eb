#pragma once
// What the box is doing, as one small JSON file that anything may read: written whole or not at all, without heap.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "airside/controller/decision.hpp"
#include "airside/forecast/candidate_record.hpp"
#include "airside/held_rooms.hpp"
#include "airside/supervision/mode_arbiter.hpp"
#include "hal/storage/store_error.hpp"

namespace airside::edge {

/// One snapshot. Units in the names; texts must outlive the call.
struct StatusSnapshot {
  std::string_view site;
  std::string_view topology;
  ActiveMode control_mode;
  const Decision& decision;
  Fault fault = Fault::none;
  double setpoint_degc = Decision::none;
  std::span<const double> room_temp_degc = {};
  double target_degc = Decision::none;
  HoldRule hold = HoldRule::mean;
  std::string_view fault_signal = {};  ///< name of the signal at fault, or empty
  CivilTime stopped_at = {};           ///< by the site's clock, where the daemon has ended in order; 0: it runs
  CivilTime release_ends = {};         ///< of a release for a time; 0: there is none
  CivilTime lost_until = {};           ///< as of DaemonState; 0: nothing was lost at this start
  std::uint64_t cycles = 0, rejected_updates = 0, replay_transitions = 0, generation = 0;
  bool has_weights = false;
  CivilTime first_row = {};  ///< where none has been run since the start; 0: one has
  /// What the row or its decision met that lasts and is not in the mode arbiter: an AHU that gives no reading, a signal
  /// that is lost. An alarm too.
  Reason met = Reason::none;
  CivilTime met_since = {};
  double room_mean_degc = Decision::none, held_degc = Decision::none;  ///< of the rooms above
  std::string_view storage = "ok";                                     ///< or what is wrong with it
  std::string_view storage_remedy = {};                                ///< what a person does about it
  std::string_view clock = "ok";  ///< or what a plant's clock did of late: "read wrong", "jumped"
  std::uint64_t link_timeouts = 0, link_bad_frames = 0, link_wrong_ids = 0, link_exceptions = 0;
  std::uint64_t setpoint_writes = 0;        ///< since the daemon's start
  std::string_view trial = "none";          ///< of pushed weights
  std::string_view trial_refusal = "none";  ///< why the last pushed blob was refused
  std::string_view trial_refusal_field = {};
  std::uint32_t pushed_crc = 0;               ///< checksum of the last blob that was taken
  const ModeArbiter* mode_arbiter = nullptr;  ///< every active reason becomes an alarm
  /// After its instant, when the row began and when it had been committed; none where a simulated plant sets the pace.
  double row_late_ms = Decision::none, row_done_ms = Decision::none;
  double ours_error_k = Decision::none, schedule_error_k = Decision::none;
  bool serves_band = false;                              ///< the objective is "band"; what follows is of it
  std::uint64_t band_cycles = 0, band_ready_cycles = 0;  ///< learned, and needed before its choice counts
  double warmest_above_k = Decision::none;               ///< most that a zone is above its own setpoint
  double most_open_damper = Decision::none;              ///< 0..1
  const CandidateRecord* candidates = nullptr;           ///< of the last decision; nullptr, or of none: not shown
};

/// Writes `status.json` into a folder, replacing it atomically. A link, a pipe or a device in its place, or in that of
/// `status.json.new`, is never followed nor written to: it is taken away. A folder there is left to a person.
class StatusFile {
 public:
  /// Errors: none here; a folder that cannot be opened makes every write() fail. "": there is no status.
  explicit StatusFile(std::string dir);
  /// Writes a snapshot; what fails, and what was taken away, is said once.
  /// Errors: the old snapshot is still there if this one could not be written. Where a folder stands at
  /// `status.json.new`, the snapshot is written by way of another name, and wrong_kind returned all the same: a person
  /// must look.  Cost: no heap.
  hal::StoreResult<void> write(CivilTime now, const StatusSnapshot& status);
  /// Whether the last write() succeeded.
  bool is_well() const { return failure_ == hal::StoreFault::none; }
  /// Whether it took something away that was no file.
  bool cleared() const { return cleared_; }

 private:
  /// Size of the text; 0 where it does not fit.
  std::size_t format(CivilTime now, const StatusSnapshot& status);
  /// Takes away what is at `name` unless that is a file, or nothing. Errors: wrong_kind for a folder.
  hal::StoreResult<void> clear(int dir, const char* name);
  hal::StoreResult<void> replace(CivilTime now, const StatusSnapshot& status);
  static hal::StoreResult<void> stage(int dir, const char* name, std::span<const std::byte> bytes);

  std::string path_;
  std::array<char, 6656> text_{};
  bool cleared_ = false;
  hal::StoreFault failure_ = hal::StoreFault::none;
};

}  // namespace airside::edge
