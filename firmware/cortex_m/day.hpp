#pragma once
// One day of a controller that starts from a blob and the log of a day under the schedule, as it would on a box. The
// same source runs on the microcontroller and on the host, and every number that comes out is printed as its bits.

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

#include "airside/controller/cycle.hpp"
#include "airside/controller/history.hpp"
#include "airside/controller/instances.hpp"
#include "airside/controller/weight_payload.hpp"
#include "firmware/cortex_m/line_writer.hpp"
#include "firmware/cortex_m/room_model.hpp"

namespace airside::cortex_m {

using Topo = FiveZone;
using Box = Controller<Topo, float>;
using Payload = BlobPayload<Topo, NetworkWeights<Topo, float>::count>;

constexpr CivilTime schedule_day{18809 * std::int64_t{86400}};  ///< 2021-07-01, a Thursday
constexpr CivilTime scored_day{schedule_day.seconds + 86400};

/// Lets the room live a day under the schedule; on_row(t, value, setpoint) for each row.
template <class OnRow>
void live_by_schedule(RoomModel& room, const ControllerSettings& settings, CivilTime day, OnRow&& on_row) {
  for (int row = 0; row < rows_per_day; ++row) {
    const CivilTime t{day.seconds + row * std::int64_t{row_s}};
    room.sleep_until(t);
    const Expected<Reading<Topo>> sensed = room.sense();
    const double setpoint = expert_setpoint_degc(settings, t);
    room.set_degc(setpoint);
    if (sensed) on_row(t, sensed->value, setpoint);
  }
}

/// Bytes of a plain object, for its checksum.
template <class Object>
std::span<const std::byte> bytes_of(const Object& object) {
  return std::as_bytes(std::span(&object, 1));
}

/// Writes a line for every row, and one more for every decision.
class DayLog {
 public:
  explicit DayLog(LineWriter& out) : out_(out) {}

  bool row(CivilTime t, const Expected<Reading<Topo>>& sensed, const Box& box) {
    out_.text("row ").number(t.second_of_day() / row_s).text(" standing ");
    sensed ? out_.bits(sensed->setpoint_degc) : out_.text("none");
    out_.end();
    if (control_cycle(box.settings()).starts(t)) decision(t, box);
    return true;
  }

 private:
  void decision(CivilTime t, const Box& box) {
    const Decision& d = box.decision();
    out_.text("cycle ")
        .number(control_cycle(box.settings()).of_day(t))
        .text(" setpoint ")
        .bits(d.command.setpoint_degc());
    out_.text(" applied ").bits(box.cycle().last_setpoint_degc);
    out_.text(" ").text(text_of(d.mode)).text(" reason ").number(static_cast<int>(d.reason));
    out_.text(" fault ").number(static_cast<int>(d.fault)).text(" at ").number(d.fault_signal);
    out_.text(" mean ").bits(d.room_mean_degc).text(" network ").bits(d.network_degc);
    out_.text(" head ").bits(d.head_degc).text(" confidence ").bits(d.confidence).text(" loss ").bits(d.loss.total);
    out_.text(" weights ").hex(crc32c(bytes_of(box.learning().weights)), 8).end();
  }

  LineWriter& out_;
};

/// Runs the day. `work` is memory for the blob's payload; the controller's own scratch will do, since it is made anew
/// afterwards. Returns whether the blob was taken and the state at the end holds numbers only.
template <class Plant_, class Clock_>
bool run_day(Box& box, Payload& work, std::span<const std::byte> blob, Plant_& plant, Clock_& clock, RoomModel& room,
             Scenario scenario, LineWriter& out) {
  const auto header = WeightBlob<Topo>::decode(blob, {}, work);
  if (!header) {
    out.text("blob refused: ").text(text_of(header.error().fault)).text(", ").text(header.error().field).end();
    return false;
  }
  out.text("blob ")
      .hex(crc32c(blob), 8)
      .text(" of ")
      .number(static_cast<std::int64_t>(blob.size()))
      .text(" bytes")
      .end();
  // The payload may lie in the controller's scratch, which start() needs: the weights are taken first.
  take_head<Topo>(box, work);
  box.begin_from(work.scaler, work.weights, strict_kernels<float>());

  HistoryReader<Topo> history(box, HistoryReader<Topo>::Head::leave);
  live_by_schedule(room, box.settings(), schedule_day,
                   [&](CivilTime t, const auto& value, double setpoint) { history.row(t, value, setpoint); });
  out.text("history ").number(history.transitions()).text(" transitions").end();

  room.begin_day(scenario, scored_day);
  DayLog log(out);
  run_cycles<Topo>(plant, clock, box, log, scored_day, CivilTime{scored_day.seconds + 86400});

  const auto& learning = box.learning();
  const auto& learner = learning.learner;
  out.text("steps ").number(static_cast<std::int64_t>(learner.steps()));
  out.text(" refused ").number(static_cast<std::int64_t>(learning.rejected));
  out.text(" head updates ").number(learning.head.updates());
  out.text(" transitions ").number(static_cast<std::int64_t>(box.replay().total_pushed()));
  out.text(" kept ").number(box.replay().size()).end();
  const auto covariance = learning.head.covariance();
  const std::span head_covariance(covariance.data(), static_cast<std::size_t>(covariance.size()));
  out.text("weights ").hex(crc32c(bytes_of(learning.weights)), 8);
  out.text(" target ").hex(crc32c(bytes_of(learner.target())), 8);
  out.text(" moments ").hex(crc32c(bytes_of(learner.first_moment())), 8);
  out.text(" ").hex(crc32c(bytes_of(learner.second_moment())), 8);
  out.text(" head ").hex(crc32c(bytes_of(learning.head.theta()), crc32c(std::as_bytes(head_covariance))), 8);
  std::uint32_t replay = 0;
  for (int i = 0; i < box.replay().size(); ++i) replay = crc32c(bytes_of(box.replay().slot(i)), replay);
  out.text(" replay ").hex(replay, 8).end();
  return all_finite(learning.weights) && learning.head.finite();
}

}  // namespace airside::cortex_m
