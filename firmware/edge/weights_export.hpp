#pragma once
// The weights in use, given out as a blob that anybody may inspect and a key's owner may sign for another room.

#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>
#include <span>
#include <string>

#include "airside/controller/history.hpp"
#include "airside/controller/instances.hpp"
#include "firmware/edge/say.hpp"
#include "firmware/edge/weights_trial.hpp"
#include "hal/storage/storage_file.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::edge {

/// Writes `weights.blob` into the state folder: the first row of a day, when a trial is confirmed, and at an orderly
/// end. Unsigned and for any site; the provenance says where, until when and from what it was learned. Weights on
/// trial are not given out, nor is a room that has none. What cannot be written is said once, and tried again a day
/// later. Cost: one blob's file a day, synced and renamed; no heap after construction.
template <Topology T>
class WeightsExport {
 public:
  static constexpr const char* file_name = "weights.blob";

  WeightsExport(std::string state_dir, std::string site, hal::Sync sync)
      : state_dir_(std::move(state_dir)),
        site_(std::move(site)),
        sync_(sync),
        bytes_(std::make_unique<std::array<std::byte, WeightBlob<T>::max_bytes>>()),
        payload_(std::make_unique<Payload>()) {}

  /// Opens the folder, and finds out from when the blob is that lies there. Before, nothing is written.
  void open() {
    auto opened = hal::StorageFile::open_dir(state_dir_.c_str());
    if (!opened) return;
    dir_ = std::move(*opened);
    const auto file = hal::StorageFile::open(dir_.descriptor(), file_name, false, "open given weights");
    BlobHeader header;
    if (!file) return;
    const auto got = file->read_at(std::as_writable_bytes(std::span(&header, 1)), 0, "read given weights");
    if (got && *got == sizeof header && header.magic == BlobHeader{}.magic) day_ = day_of({header.created_s});
  }

  /// After a row's commit.
  void row(CivilTime t, const Controller<T>& controller, const TrialRecord& trial) {
    const bool confirmed = trial.state == TrialState::confirmed && seen_ == TrialState::on_trial;
    seen_ = trial.state;
    if (day_of(t) != day_ || confirmed) give(t, controller, trial);
  }

  /// Why weights cannot be given out where something that is no file is in their place; tried again each row.
  hal::StoreResult<void> blocked() const {
    if (failure_ != hal::StoreFault::wrong_kind) return {};
    return tl::make_unexpected(hal::StoreError{failure_, 0, "open weights to give out"});
  }

  /// At an orderly end after row t.
  void end(CivilTime t, const Controller<T>& controller, const TrialRecord& trial) {
    if (controller.learning().cycles != given_cycles_) give(t, controller, trial);
  }

 private:
  using Payload = typename WeightBlob<T>::Payload;

  static std::int64_t day_of(CivilTime t) { return t.seconds / 86400; }

  void give(CivilTime t, const Controller<T>& controller, const TrialRecord& trial) {
    if (!dir_.is_open() || controller.cycle().has_weights == 0 || trial.state == TrialState::on_trial) return;
    if (auto now = hal::StorageFile::open_dir(state_dir_.c_str())) dir_ = std::move(*now);  // it may be another
    day_ = day_of(t);
    given_cycles_ = controller.learning().cycles;
    give_payload<T>(controller, *payload_);
    note_provenance(t, trial);
    const BlobHeader header{.created_s = t.seconds};
    const std::size_t size = WeightBlob<T>::encode(header, *payload_, *bytes_);
    const hal::StoreResult<void> written = write(std::span<const std::byte>(*bytes_).first(size));
    if (!written && failure_ != written.error().fault) {
      say("weights cannot be given out: {} ({})", hal::text_of(written.error().fault), written.error().step);
    }
    failure_ = written ? hal::StoreFault::none : written.error().fault;
    if (failure_ == hal::StoreFault::wrong_kind) day_ = -1;
  }

  void note_provenance(CivilTime t, const TrialRecord& trial) {
    std::array<char, hal::civil_text_size> time{};
    hal::write_civil_text(time.data(), t);
    auto& text = payload_->provenance;
    text = {};
    auto end = fmt::format_to_n(
        text.data(), text.size() - 1, "learned by airsided in \"{}\" ({}) until {}: {} decisions", site_,
        name_of(payload_->site).c_str(), std::string_view(time.data(), time.size()), given_cycles_);
    if (trial.blob_crc == 0 || trial.state == TrialState::none) return;
    const std::size_t used = std::min(end.size, text.size() - 1);
    fmt::format_to_n(text.data() + used, text.size() - 1 - used, "; pushed weights {:08x} {}", trial.blob_crc,
                     text_of(trial.state));
  }

  hal::StoreResult<void> write(std::span<const std::byte> blob) {
    constexpr const char* staged = "weights.blob.new";
    const auto file = hal::StorageFile::open(dir_.descriptor(), staged, true, "open weights to give out");
    if (!file) return tl::make_unexpected(file.error());
    hal::StoreResult<void> done = file->truncate(0, "truncate weights to give out");
    if (done) done = file->write_at(blob, 0, "write weights to give out");
    if (done) done = file->sync(sync_, "sync weights to give out");
    if (done && ::renameat(dir_.descriptor(), staged, dir_.descriptor(), file_name) != 0) {
      done = tl::make_unexpected(hal::store_error(errno, "rename weights to give out"));
    }
    if (!done) {
      ::unlinkat(dir_.descriptor(), staged, 0);
      return done;
    }
    if (sync_ == hal::Sync::full && ::fsync(dir_.descriptor()) != 0) {
      return tl::make_unexpected(hal::store_error(errno, "sync folder"));
    }
    return {};
  }

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
