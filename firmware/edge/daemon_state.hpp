#pragma once
// What the daemon knows beyond its own life: state, log, weights that come and go. Each row ends in one commit.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "airside/controller/history.hpp"
#include "airside/controller/instances.hpp"
#include "firmware/edge/box_folders.hpp"
#include "firmware/edge/weights/weights_export.hpp"
#include "firmware/edge/weights/weights_trial.hpp"
#include "hal/log/log_csv.hpp"
#include "hal/site/site_file.hpp"
#include "hal/storage/durable_store.hpp"

namespace airside::edge {

/// What a row commits beside the learning state. Plain bytes.
template <Topology T>
struct RowRecord {
  CycleState<T> cycle;
  Decision decision;
  CivilTime row_time;
  std::uint32_t blob_crc = 0;      ///< of the site's weights that this state grew from
  std::uint32_t believed_day = 0;  ///< of the last row by a clock that could be right, CivilTime::day(); 0: unknown
  TrialRecord trial;               ///< of weights that were pushed since
};

/// The folders of one box and the controller that they are for, which must outlive this.
template <Topology T>
class DaemonState {
  using Learning = LearningState<T, float>;
  using Ring = ReplayRing<T, float>;
  using Payload = BlobPayload<T, NetworkWeights<T, float>::count>;

 public:
  /// `columns`: what the site's logs have.
  DaemonState(const hal::SiteFile& site, const hal::TopologyCounts& columns, hal::Sync sync, Controller<T>& controller);

  /// Sizes of the durable state of this topology and build.
  static hal::StoreLayout layout(const Shape& site, ControlCycle cycle = default_cycle);

  /// Reads blob and history, then opens log, state and inbox. A folder that fails is tried again by every row.
  /// Errors: hal::InputError for a bad blob or history, which leaves no folder behind, or a state folder in use.
  void open();
  /// Loads the newest good state, else begins from the blob, else leaves the controller as it is. Returns the time of
  /// the last row, 0 where there was no state.
  CivilTime resume();
  /// The last day on which a clock that could be right was read; 0: unknown.
  CivilTime believed() const { return {record_.believed_day * seconds_per_day}; }
  /// Reads what open() would read and leaves everything as it is. Returns the keys, for people. Errors: as of open(),
  /// but for the state folder; and for a bad history without weights or bad key files, which a start leaves out.
  std::string check();

  /// One row: log it unless its time cannot be right, look into the inbox, commit. Order matters: the log first, then
  /// the commit that names its end. Cost: no heap.
  void row(CivilTime t, const Expected<Reading<T>>& sensed, bool has_date);
  /// After a row whose commit is done: the weights for whoever asks for them.
  void give_weights(CivilTime t);
  /// At an orderly end.
  void end();

  /// As of BoxFolders.
  const char* storage() const { return folders_.storage(); }
  const char* storage_remedy() const { return folders_.remedy(); }
  bool is_well() const { return folders_.is_well(); }
  /// There was state, and none of it is whole and of this version and topology.
  bool state_lost() const { return state_lost_; }
  /// Until when what was lost had been learned, as far as row record or log know; 0 where nothing was lost.
  CivilTime lost_until() const { return lost_until_; }
  /// Another daemon uses the state folder, so the AHU is its.
  bool taken_over() const { return taken_over_; }
  bool release_waits() const { return trial_.release_waits(); }
  CivilTime release_ends() const { return trial_.release_ends(); }
  const TrialRecord& trial() const { return record_.trial; }
  std::uint64_t generation() const { return folders_.store() ? folders_.store()->generation() : 0; }

 private:
  enum class Found {
    nothing,  ///< that fits; the controller is as it was made
    state,
    nothing_read,  ///< the controller is as it was
  };

  hal::StoredState state(CivilTime t);
  std::uint32_t load_blob();
  void load_history();
  void begin_from_blob();
  void remember_history();
  Found load_state(bool late = false);
  void lose_state();
  void archive_foreign_state();
  void resume_late(CivilTime t);
  void find_late_loss(CivilTime t);
  Found forget();
  Found forget_weights();
  static RowRecord<T> fresh_record();

  const hal::SiteFile& site_;
  Controller<T>& controller_;
  std::unique_ptr<Payload> payload_;  ///< of the site's blob: a state that comes late may be one of other weights
  std::optional<hal::Log> history_;   ///< until resume() has ended
  std::uint32_t blob_crc_ = 0;
  std::size_t blob_bytes_ = 0;
  BoxFolders folders_;
  hal::TopologyCounts columns_;
  Shape shape_;
  hal::LogRow log_row_;
  RowRecord<T> record_ = fresh_record();
  WeightsTrial<T> trial_;
  WeightsExport<T> export_;
  /// This process has committed once: until then the medium may hold weights that forget() discarded.
  bool has_committed_ = false, row_committed_ = false;
  bool learning_exchanged_ = false;  ///< and not committed yet
  bool state_lost_ = false, taken_over_ = false;
  bool is_new_ = false;                  ///< at the start nothing said that this box had ever committed
  bool record_was_whole_ = false;        ///< the last load found a whole row record, with its counters and releases
  CivilTime logged_until_, lost_until_;  ///< the first: at the start
};

}  // namespace airside::edge
