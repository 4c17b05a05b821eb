#include "firmware/edge/weights/weights_export.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>
#include <utility>

#include "airside/controller/history.hpp"
#include "firmware/edge/report/say.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::edge {

template <Topology T>
WeightsExport<T>::WeightsExport(std::string state_dir, std::string site, hal::Sync sync)
    : state_dir_(std::move(state_dir)),
      site_(std::move(site)),
      sync_(sync),
      bytes_(std::make_unique<std::array<std::byte, WeightBlob<T>::max_bytes>>()),
      payload_(std::make_unique<Payload>()) {}

template <Topology T>
void WeightsExport<T>::open() {
  auto opened = hal::StorageFile::open_dir(state_dir_.c_str());
  if (!opened) return;
  dir_ = std::move(*opened);
  const auto file = hal::StorageFile::open(dir_.descriptor(), file_name, false, "open given weights");
  BlobHeader header;
  if (!file) return;
  const auto got = file->read_at(std::as_writable_bytes(std::span(&header, 1)), 0, "read given weights");
  if (got && *got == sizeof header && header.magic == BlobHeader{}.magic) day_ = day_of({header.created_s});
}

template <Topology T>
void WeightsExport<T>::row(CivilTime t, const Controller<T>& controller, const TrialRecord& trial) {
  const bool confirmed = trial.state == TrialState::confirmed && seen_ == TrialState::on_trial;
  seen_ = trial.state;
  if (day_of(t) != day_ || confirmed) give(t, controller, trial);
}

template <Topology T>
hal::StoreResult<void> WeightsExport<T>::blocked() const {
  if (failure_ != hal::StoreFault::wrong_kind) return {};
  return tl::make_unexpected(hal::StoreError{failure_, 0, "open weights to give out"});
}

template <Topology T>
void WeightsExport<T>::end(CivilTime t, const Controller<T>& controller, const TrialRecord& trial) {
  if (controller.learning().cycles != given_cycles_) give(t, controller, trial);
}

template <Topology T>
std::int64_t WeightsExport<T>::day_of(CivilTime t) {
  return t.seconds / seconds_per_day;
}

template <Topology T>
void WeightsExport<T>::give(CivilTime t, const Controller<T>& controller, const TrialRecord& trial) {
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

template <Topology T>
void WeightsExport<T>::note_provenance(CivilTime t, const TrialRecord& trial) {
  std::array<char, hal::civil_text_size> time{};
  hal::write_civil_text(time.data(), t);
  auto& text = payload_->provenance;
  text = {};
  auto end =
      fmt::format_to_n(text.data(), text.size() - 1, "learned by airsided in \"{}\" ({}) until {}: {} decisions", site_,
                       name_of(payload_->site).c_str(), std::string_view(time.data(), time.size()), given_cycles_);
  if (trial.blob_crc == 0 || trial.state == TrialState::none) return;
  const std::size_t used = std::min(end.size, text.size() - 1);
  fmt::format_to_n(text.data() + used, text.size() - 1 - used, "; pushed weights {:08x} {}", trial.blob_crc,
                   text_of(trial.state));
}

template <Topology T>
hal::StoreResult<void> WeightsExport<T>::write(std::span<const std::byte> blob) {
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

#define AIRSIDE_INSTANTIATE(Tag) template class WeightsExport<Tag>;
AIRSIDE_FOR_EACH_TOPOLOGY(AIRSIDE_INSTANTIATE)
#undef AIRSIDE_INSTANTIATE

}  // namespace airside::edge
