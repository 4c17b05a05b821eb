#pragma once
// What a site recorded, in the form in which a model can live through it again: the commands of its boxes and fan
// coils, the setpoint, and the weather that was measured. And what came out: one column a sensor.

#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "airside/signals.hpp"
#include "sim/weather/weather.hpp"

namespace airside::sim {

/// One row: commands that hold for 6 min from its time, and the weather sensors' reading at its time.
struct RecordedRow {
  double setpoint_degc = 0;
  std::vector<double> vav_on;  ///< 0/1, one a VAV
  std::vector<double> fcu_on;  ///< 0/1, one an FCU
  double outdoor_temp_degc = 0;
  double rain = 0;
  std::vector<double> zone_heat_kw = {};  ///< zone, VAV zones first; heat into the air that no model has; empty: none
  std::vector<double> commands = {};      ///< of further schedules, in the order in which a model names them
};

/// Where a recording goes on at another time: whole days were left out, or it goes back.
struct LaterStretch {
  std::size_t row = 0;  ///< the first of it
  CivilTime from;
};

/// A stretch without gaps.  Row i is at from + i * row_s, by the site's clock; but for later stretches, which no engine
/// lives through at once.
struct Recording {
  CivilTime from;
  std::vector<RecordedRow> rows;
  std::shared_ptr<const Weather> station;  ///< for what the site does not measure: sun, humidity, wind
  std::vector<LaterStretch> later = {};    ///< in order of row

  CivilTime time(std::size_t row) const {
    LaterStretch in{0, from};
    for (const LaterStretch& stretch : later) {
      if (stretch.row <= row) in = stretch;
    }
    return {in.from.seconds + static_cast<std::int64_t>(row - in.row) * row_s};
  }
  CivilTime to() const { return time(rows.size()); }
  /// The row that holds at t; before `from` those of the first day, repeated; after the end the last.
  const RecordedRow& at(CivilTime t) const;
};

/// Days that a replay lives through before the recording begins, so that walls and masses do not remember the start.
constexpr int lead_days = 4;

/// How a log shows a column otherwise than rows of 6 min do.
struct ChannelGrain {
  int step_min = 0;       ///< a value each so long; 0: each half an hour or less
  bool instants = false;  ///< values are those of an instant at the step's begin, not means of the step
  double floor = 0;       ///< least standard deviation of the noise, K or kW; 0: the usual one
  std::string title;      ///< what its owner calls it; empty: as usual
};

/// The columns of a replay. Order: room temperatures, FCU temperatures, MAU outlet, supply, powers, FCU duties,
/// dampers.
struct Channels {
  int rooms = 0, fcus = 0, powers = 0;
  int dampers = 0;                       ///< of a model that moves them itself: one a room, or none
  std::vector<ChannelGrain> grain = {};  ///< one a column, or none
  int fcu_temp() const { return rooms; }
  int mau_temp() const { return rooms + fcus; }
  int supply_temp() const { return mau_temp() + 1; }
  int power() const { return supply_temp() + 1; }
  int fcu_duty() const { return power() + powers; }
  int damper() const { return fcu_duty() + fcus; }
  int count() const { return damper() + dampers; }
  /// "room_temp_1_degc", "power_2_kw", "fcu_duty_3", "damper_1".
  std::string name(int column) const;
  /// "K", "kW" or "-": of a difference.
  const char* unit(int column) const;
};

/// Shape: rows of the recording x Channels::count(). Units: degC, kW, 0..1. NaN: not measured.
using ChannelTable = Eigen::MatrixXd;

/// The station's weather with the measured outdoor temperature and rain in its place, from lead_days before the stretch
/// to its end; before it, the first day is repeated, in intervals of 3 min or what is asked for.
/// Errors: hal::InputError if the station does not cover the stretch.
std::shared_ptr<const Weather> measured_weather(const Recording& recording, int interval_s = 180);

/// The measured weathers of the recordings that are lived through again and again, each made once.
class MeasuredWeathers {
 public:
  /// measured_weather(), with its skies kept; recordings of the same station, start, outdoor temperature and rain share
  /// it.  Thread-safe.  Errors: as measured_weather().
  std::shared_ptr<const Weather> of(const Recording& recording);

 private:
  struct Known {
    std::shared_ptr<const Weather> station;
    CivilTime from;
    std::vector<double> measured;
    std::shared_ptr<const Weather> weather;
  };
  static constexpr std::size_t most = 8;
  std::mutex mutex_;
  std::vector<Known> known_;  ///< oldest first, at most `most`
};

}  // namespace airside::sim
