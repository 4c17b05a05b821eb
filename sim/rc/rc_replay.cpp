#include "sim/rc/rc_replay.hpp"

#include <fmt/format.h>

#include <limits>

#include "hal/text/input_error.hpp"
#include "sim/rc/rc_plant.hpp"

namespace airside::sim {

namespace {

/// The room without whims, outages and noise: the mean of what it does.
RcRoom expected_room(RcRoom room) {
  room.occupancy_day_sd = room.occupancy_zone_sd = room.occupancy_noise_sd = room.arrival_sd_min = 0;
  room.vav_off_per_day = 0;
  room.mau_noise_sd_k = room.temp_noise_sd_k = room.power_noise_share = 0;
  room.seed = 0;
  return room;
}

/// Calls row(index, plant) at every recorded instant.
template <class Row>
void live_through(const RcRoom& room, const std::shared_ptr<const Recording>& recording,
                  const std::shared_ptr<const Weather>& weather, bool thermostats, bool rounded, Row&& row) {
  const CivilTime begin{recording->from.seconds - lead_days * seconds_per_day};
  RcPlant plant(room, weather, begin, 0, recording->at(begin).setpoint_degc);
  if (!rounded) plant.show_exact_values();
  plant.follow(recording, thermostats);
  while (plant.time() < recording->to()) {
    const CivilTime t = plant.time();
    plant.set_setpoint(recording->at(t).setpoint_degc);
    if (!(t < recording->from)) row(static_cast<std::size_t>((t.seconds - recording->from.seconds) / row_s), plant);
    plant.advance_to({t.seconds + row_s});
  }
}

}  // namespace

ChannelTable replay_rc(const RcRoom& room, const Recording& recording, bool duties, bool rounded,
                       std::shared_ptr<const Weather> weather) {
  const Channels channels{room.vavs, room.fcus, room.powers};
  for (const RecordedRow& row : recording.rows) {
    if (std::ssize(row.vav_on) != room.vavs || std::ssize(row.fcu_on) != room.fcus) {
      throw hal::InputError("room " + room.name, fmt::format("{} VAVs and {} FCUs", room.vavs, room.fcus),
                            fmt::format("{} and {} as in the log", row.vav_on.size(), row.fcu_on.size()),
                            "use the room and the log of one site");
    }
    if (!row.zone_heat_kw.empty() && std::ssize(row.zone_heat_kw) != room.zones()) {
      throw hal::InputError("room " + room.name, fmt::format("heat of {} zones", row.zone_heat_kw.size()),
                            fmt::format("of {}", room.zones()), "give every zone its own, VAV zones first");
    }
  }
  const RcRoom quiet = expected_room(room);
  const auto shared = std::make_shared<const Recording>(recording);
  if (!weather) weather = measured_weather(recording);
  ChannelTable table =
      ChannelTable::Constant(std::ssize(recording.rows), channels.count(), std::numeric_limits<double>::quiet_NaN());
  live_through(quiet, shared, weather, false, rounded, [&](std::size_t at, const RcPlant& plant) {
    auto row = table.row(static_cast<Eigen::Index>(at));
    const Sensors& s = plant.sensors();
    for (int i = 0; i < channels.rooms; ++i) row(i) = s.room_temp_degc[static_cast<std::size_t>(i)];
    for (int i = 0; i < channels.fcus; ++i) row(channels.fcu_temp() + i) = s.fcu_temp_degc[static_cast<std::size_t>(i)];
    row(channels.mau_temp()) = s.mau_temp_degc;
    row(channels.supply_temp()) = s.supply_temp_degc;
    for (int i = 0; i < channels.powers; ++i) row(channels.power() + i) = s.power_kw[static_cast<std::size_t>(i)];
  });
  if (!duties) return table;
  live_through(quiet, shared, weather, true, rounded, [&](std::size_t at, const RcPlant& plant) {
    for (int i = 0; i < channels.fcus; ++i) {
      table(static_cast<Eigen::Index>(at), channels.fcu_duty() + i) =
          plant.sensors().fcu_on[static_cast<std::size_t>(i)];
    }
  });
  return table;
}

}  // namespace airside::sim
