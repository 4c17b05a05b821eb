#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "hal/text/civil_text.hpp"
#include "tools/gap/bills/bill_verdict.hpp"
#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

namespace {

/// What a calendar year's bills ask for: a replay and its lead days lie within one.
struct BilledYear {
  CivilTime from, to;
};

std::vector<BilledYear> years_of(const BillTable& bills) {
  std::map<int, BilledYear> years;
  for (const BillPeriod& p : bills.periods) {
    const int year = hal::civil_date(p.from).year;
    const CivilTime first{sim::civil_midnight(year, 1, 1).seconds + sim::lead_days * seconds_per_day};
    const CivilTime from = std::max(p.from, first);
    const auto [at, added] = years.try_emplace(year, BilledYear{from, p.to});
    if (!added) at->second.to = std::max(at->second.to, p.to);
  }
  std::vector<BilledYear> all;
  for (const auto& [year, billed] : years) {
    if (billed.from < billed.to) all.push_back(billed);
  }
  return all;
}

/// All boxes on, no fan coil, the weather file's weather: what a model with controls of its own does not look at.
sim::Recording recording_of(const BilledYear& year, const sim::Channels& channels,
                            const std::shared_ptr<const sim::Weather>& station) {
  constexpr double setpoint_degc = 22;
  sim::Recording recording;
  recording.from = year.from;
  recording.station = station;
  sim::RecordedRow row;
  row.setpoint_degc = setpoint_degc;
  row.vav_on.assign(static_cast<std::size_t>(channels.rooms), 1);
  row.fcu_on.assign(static_cast<std::size_t>(channels.fcus), 0);
  for (CivilTime t = year.from; t < year.to; t.seconds += row_s) {
    const sim::WeatherRecord weather = station->at(t);
    row.outdoor_temp_degc = weather.outdoor_temp_degc;
    row.rain = weather.rain;
    recording.rows.push_back(row);
  }
  return recording;
}

/// Adds what one year's table says of the bills in it.
void add_energy(const sim::ChannelTable& table, const BilledYear& year, const BillTable& bills,
                const std::vector<int>& columns, Eigen::MatrixXd& kwh) {
  constexpr double hours = static_cast<double>(row_s) / seconds_per_hour;
  for (std::size_t i = 0; i < bills.periods.size(); ++i) {
    const CivilTime from = std::max(bills.periods[i].from, year.from), to = std::min(bills.periods[i].to, year.to);
    if (!(from < to)) continue;
    const Eigen::Index first = (from.seconds - year.from.seconds) / row_s, rows = (to.seconds - from.seconds) / row_s;
    const double whole = bills.periods[i].days() / (static_cast<double>(rows) / rows_per_day);
    for (std::size_t m = 0; m < columns.size(); ++m)
      kwh(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(m)) +=
          whole * hours * table.col(columns[m]).segment(first, rows).sum();
  }
}

}  // namespace

std::size_t bill_runs(const Library& library, const BillTable& bills) {
  return years_of(bills).size() * (1 + library.parameters.size() + 2 * library.candidates.size());
}

BillResponses bill_responses(const Engine& engine, const Library& library, const BillTable& bills,
                             const std::vector<int>& meters, std::shared_ptr<const sim::Weather> station, int jobs,
                             const std::function<void()>& done) {
  const sim::Channels channels = engine.channels();
  std::vector<int> columns;
  for (const int meter : meters) columns.push_back(channels.power() + meter);
  BillResponses out;
  std::vector<Changes> changes{{}};
  for (const sim::EffectAt& at : library.parameters) {
    out.parameters.push_back({at, at.effect->prior_sd, {}});
    changes.push_back({{at, at.effect->null_value + at.effect->prior_sd}});
  }
  for (const sim::EffectAt& at : library.candidates) {
    for (const double probe : at.effect->probe) {
      out.candidates.push_back({at, probe - at.effect->null_value, {}});
      changes.push_back({{at, probe}});
    }
  }
  std::vector<Eigen::MatrixXd> kwh(changes.size(),
                                   Eigen::MatrixXd::Zero(std::ssize(bills.periods), std::ssize(meters)));
  std::mutex one_at_a_time;
  for (const BilledYear& year : years_of(bills)) {
    const sim::Recording recording = recording_of(year, channels, station);
    in_parallel(changes.size(), jobs, [&](std::size_t i) {
      add_energy(engine.simulate(changes[i], recording), year, bills, columns, kwh[i]);
      const std::lock_guard lock(one_at_a_time);
      if (done) done();
    });
  }
  out.base = kwh.front();
  for (std::size_t i = 0; i < out.parameters.size(); ++i) out.parameters[i].kwh = kwh[1 + i] - out.base;
  for (std::size_t i = 0; i < out.candidates.size(); ++i)
    out.candidates[i].kwh = kwh[1 + out.parameters.size() + i] - out.base;
  return out;
}

}  // namespace airside::tools::gap
