#include "tools/gap/model/log_window.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools::gap {

namespace {

/// Order of a log's values: rooms, FCU temperatures, VAV on, FCU on, powers, MAU, outdoor, rain.
struct LogColumns {
  explicit LogColumns(const sim::Channels& c)
      : fcu_temp(c.rooms),
        vav_on(fcu_temp + c.fcus),
        fcu_on(vav_on + c.rooms),
        power(fcu_on + c.fcus),
        mau(power + c.powers),
        outdoor(mau + 1),
        rain(outdoor + 1) {}
  int fcu_temp, vav_on, fcu_on, power, mau, outdoor, rain;
};

double held(double value, double last) { return std::isfinite(value) ? value : last; }

/// Dampers of a row in their columns; air that stands is no supply.
void take_sides(const hal::LogRow& row, const hal::TopologyCounts& site, const sim::Channels& channels,
                Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> to) {
  for (std::size_t i = 0; i < site.sides.size() && i < row.side.size(); ++i) {
    const hal::SideColumn side = site.sides[i];
    if (side.signal == hal::SideSignal::damper && side.place <= channels.dampers)
      to(channels.damper() + side.place - 1) = row.side[i];
    if (side.signal == hal::SideSignal::ahu_on && row.side[i] == 0)
      to(channels.supply_temp()) = std::numeric_limits<double>::quiet_NaN();
  }
}

/// The first that is known of each: before it nothing else is.
std::vector<double> first_commands(std::span<const hal::LogRow> rows, std::size_t behind, std::size_t count) {
  std::vector<double> first(count, 0.0);
  for (std::size_t k = 0; k < count; ++k) {
    const auto known = std::find_if(rows.begin(), rows.end(),
                                    [&](const hal::LogRow& row) { return std::isfinite(row.side[behind + k]); });
    if (known != rows.end()) first[k] = known->side[behind + k];
  }
  return first;
}

}  // namespace

Window window_of(std::span<const hal::LogRow> rows, const sim::Channels& channels,
                 std::shared_ptr<const sim::Weather> station, const std::string& place, const hal::TopologyCounts& site,
                 std::size_t commands) {
  constexpr std::int64_t day = 86400;
  const auto refuse = [&place](const std::string& found) {
    throw hal::InputError(place, found, "at least two whole days of 6-min rows, midnight to midnight",
                          "log for longer, or name a longer period");
  };
  if (rows.empty()) refuse("no row");
  const std::int64_t from = (rows.front().time.seconds + day - 1) / day * day;
  const std::int64_t to = (rows.back().time.seconds + row_s) / day * day;
  if (to - from < 2 * day) refuse(fmt::format("{} rows", rows.size()));
  const LogColumns at(channels);
  const auto count = static_cast<std::size_t>((to - from) / row_s);
  Window window;
  window.recording.from = {from};
  window.recording.station = std::move(station);
  sim::ChannelTable table = sim::ChannelTable::Constant(static_cast<Eigen::Index>(count), channels.count(),
                                                        std::numeric_limits<double>::quiet_NaN());
  sim::RecordedRow now;
  now.vav_on.assign(static_cast<std::size_t>(channels.rooms), 1);
  now.fcu_on.assign(static_cast<std::size_t>(channels.fcus), 0);
  now.outdoor_temp_degc = now.rain = std::numeric_limits<double>::quiet_NaN();
  now.setpoint_degc = rows.front().setpoint_degc;
  now.commands = first_commands(rows, site.sides.size(), commands);
  std::size_t next = 0;
  std::int64_t last_seen = from;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t t = from + static_cast<std::int64_t>(i) * row_s;
    while (next < rows.size() && rows[next].time.seconds < t) ++next;
    if (next < rows.size() && rows[next].time.seconds == t) {
      const hal::LogRow& row = rows[next];
      const auto value = [&](int column) {
        return site.stand_in(column) ? std::numeric_limits<double>::quiet_NaN()
                                     : row.value[static_cast<std::size_t>(column)];
      };
      last_seen = t;
      now.setpoint_degc = held(row.setpoint_degc, now.setpoint_degc);
      for (int v = 0; v < channels.rooms; ++v) {
        double& on = now.vav_on[static_cast<std::size_t>(v)];
        on = held(value(at.vav_on + v), on);
        table(static_cast<Eigen::Index>(i), v) = value(v);
      }
      for (int f = 0; f < channels.fcus; ++f) {
        double& on = now.fcu_on[static_cast<std::size_t>(f)];
        const double shown = value(at.fcu_on + f);
        on = held(shown, on);
        table(static_cast<Eigen::Index>(i), channels.fcu_temp() + f) = value(at.fcu_temp + f);
        table(static_cast<Eigen::Index>(i), channels.fcu_duty() + f) = shown;
      }
      for (int p = 0; p < channels.powers; ++p) {
        table(static_cast<Eigen::Index>(i), channels.power() + p) = value(at.power + p);
      }
      table(static_cast<Eigen::Index>(i), channels.mau_temp()) = value(at.mau);
      table(static_cast<Eigen::Index>(i), channels.supply_temp()) = row.supply_temp_degc;
      take_sides(row, site, channels, table.row(static_cast<Eigen::Index>(i)));
      for (std::size_t k = 0; k < commands; ++k)
        now.commands[k] = held(row.side[site.sides.size() + k], now.commands[k]);
      now.outdoor_temp_degc = held(value(at.outdoor), now.outdoor_temp_degc);
      now.rain = held(value(at.rain), now.rain);
    } else if (t - last_seen > day) {
      refuse(fmt::format("a gap of more than a day before {}", hal::civil_text({t})));
    }
    window.recording.rows.push_back(now);
  }
  window.measured = binned(table, channels);
  return window;
}

}  // namespace airside::tools::gap
