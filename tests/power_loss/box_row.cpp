#include "power_loss/box_row.hpp"

#include <algorithm>

#include "firmware/edge/daemon_state.hpp"

namespace airside::power_loss {

hal::StoreLayout box_layout() { return edge::DaemonState<FiveZone>::layout(capacity_of<FiveZone>()); }

RowFacts facts_of_box_row(std::span<const std::byte> row) {
  using Row = edge::RowRecord<FiveZone>;
  alignas(Row) std::array<std::byte, sizeof(Row)> copy;
  std::copy_n(row.begin(), sizeof(Row), copy.begin());
  const auto* record = reinterpret_cast<const Row*>(copy.data());
  const edge::TrialRecord& trial = record->trial;
  return {record->row_time,      trial.counter[0].highest, trial.blob_crc, trial.state == edge::TrialState::rolled_back,
          trial.previous_digest, trial.counter[0].key};
}

}  // namespace airside::power_loss
