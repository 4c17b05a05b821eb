#pragma once
// The weights in use, given out as a blob that anybody may inspect and a key's owner may sign for another room.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "airside/controller/instances.hpp"
#include "firmware/edge/weights/weights_trial.hpp"
#include "hal/storage/storage_file.hpp"

namespace airside::edge {

/// Writes `weights.blob` into the state folder: the first row of a day, when a trial is confirmed, and at an orderly
/// end. Unsigned and for any site; the provenance says where, until when and from what it was learned. Weights on
/// trial are not given out, nor is a room that has none. What cannot be written is said once, and tried again a day
/// later. Cost: one blob's file a day, synced and renamed; no heap after construction.
template <Topology T>
class WeightsExport {
 public:
  static constexpr const char* file_name = "weights.blob";

  WeightsExport(std::string state_dir, std::string site, hal::Sync sync);

  /// Opens the folder, and finds out from when the blob is that lies there. Before, nothing is written.
  void open();
  /// After a row's commit.
  void row(CivilTime t, const Controller<T>& controller, const TrialRecord& trial);
  /// Why weights cannot be given out where something that is no file is in their place; tried again each row.
  hal::StoreResult<void> blocked() const;
  /// At an orderly end after row t.
  void end(CivilTime t, const Controller<T>& controller, const TrialRecord& trial);

 private:
  using Payload = typename WeightBlob<T>::Payload;

  static std::int64_t day_of(CivilTime t);
  void give(CivilTime t, const Controller<T>& controller, const TrialRecord& trial);
  void note_provenance(CivilTime t, const TrialRecord& trial);
  hal::StoreResult<void> write(std::span<const std::byte> blob);

  std::string state_dir_, site_;
  hal::Sync sync_;
  std::unique_ptr<std::array<std::byte, WeightBlob<T>::max_bytes>> bytes_;
  std::unique_ptr<Payload> payload_;
  hal::StorageFile dir_;
  std::int64_t day_ = -1;  ///< of the blob that lies there
  std::uint64_t given_cycles_ = 0;
  TrialState seen_ = TrialState::none;
  hal::StoreFault failure_ = hal::StoreFault::none;
};

}  // namespace airside::edge
