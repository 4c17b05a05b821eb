#pragma once
// The figures that every method is judged by: one definition, used by studies, reports and tests alike.
// They are computed from what a run logged: one sample a control cycle, and the power readings of every row.

#include <limits>
#include <span>
#include <vector>

#include "airside/civil_time.hpp"
#include "airside/demand/zone_comfort.hpp"

namespace airside::tools {

/// The start of one control cycle: the temperatures read then and the setpoint applied from then on.
/// Shape: room_temp_degc one entry a room, the same number in every sample.
struct CycleSample {
  CivilTime time;
  double room_mean_degc = 0;
  std::vector<double> room_temp_degc;
  double setpoint_degc = 0;
  /// By which the room head's forecast of the cycle that ended then was wrong; NaN: it had none.
  double head_error_k = std::numeric_limits<double>::quiet_NaN();
  double network_error_k = std::numeric_limits<double>::quiet_NaN();  ///< the same of the network's forecast
  /// What the residual forecaster saw then; empty: nothing.
  std::vector<float> residual_features = {};
};

/// The plant's electric power (all meters summed), held until the next row.
struct EnergyRow {
  CivilTime time;
  double power_kw = 0;
};

/// What counts as target and as scored time. Source: docs/method.md 2, 6.3, 9.
struct MetricsSettings {
  double target_degc = 25.25;
  int work_start_s = 7 * 3600;            ///< second of day; the first scored cycle starts at or after it
  int work_end_s = 19 * 3600;             ///< second of day; the last scored cycle starts before it
  int cycle_s = default_cycle.seconds();  ///< control cycle; 1080 s gives k = 24..63, 40 scored samples a day
  int row_s = airside::row_s;             ///< spacing of the energy rows
  double reference_setpoint_degc = 20.5;  ///< of the energy-saved area
  bool weekdays_only = false;             ///< score Monday to Friday only (energy_kwh still counts every row)
};

/// One calendar day. Sums and means run over its scored samples unless said otherwise.
struct DayMetrics {
  CivilTime midnight;
  int samples = 0;                       ///< scored samples, 40 a full day
  double dae_degc = 0;                   ///< mean |Sbar - target|
  std::vector<double> room_dae_degc;     ///< mean |S_r - target|, one a room
  double worst_room_dae_degc = 0;        ///< the largest of them
  double darv_degc = 0;                  ///< working hours
  double darv_full_day_degc = 0;         ///< all cycles of the day
  double cdh_degch = 0;                  ///< sum max(0, Sbar - A) h
  double hdh_degch = 0;                  ///< sum max(0, A - Sbar) h
  double degree_hours_above_degch = 0;   ///< sum max(0, Sbar - target) h
  double degree_hours_below_degch = 0;   ///< sum max(0, target - Sbar) h
  double saved_area_degch = 0;           ///< sum over all cycles of (A - reference) h, signed
  double saved_area_unsigned_degch = 0;  ///< the same of |A - reference|
};

/// A whole run. Means are over its days. Days without a scored sample are left out of `days`.
struct Metrics {
  std::vector<DayMetrics> days;
  double dae_degc = 0;                   ///< average DAE
  double me_degc = 0;                    ///< max over days of DAE
  double day1_dae_degc = 0;              ///< DAE of the first scored day
  double darv_degc = 0;                  ///< mean of the daily DARV, working hours
  double darv_full_day_degc = 0;         ///< mean of the daily DARV over all cycles
  double cdh_degch = 0;                  ///< total over the run
  double hdh_degch = 0;                  ///< total over the run
  double degree_hours_degch = 0;         ///< above + below, mean a day
  double degree_hours_above_degch = 0;   ///< mean a day
  double degree_hours_below_degch = 0;   ///< mean a day
  double hvac_kwh = 0;                   ///< total over all rows
  double hvac_kwh_per_day = 0;           ///< hvac_kwh / (rows' duration in days)
  double saved_area_degch = 0;           ///< mean a day, signed: positive saves cooling
  double saved_area_unsigned_degch = 0;  ///< mean a day
  std::vector<double> room_dae_degc;     ///< mean over days, one a room
  double rooms_dae_degc = 0;             ///< their mean over the rooms
  double worst_room_dae_degc = 0;        ///< mean over days of the day's worst room
};

/// Computes every figure of a run.
///   DAE_d = (1/n) sum |Sbar - target|;  ME = max_d DAE_d
///   DARV_d = (1/(n-3)) sum_{t=3..n} |(A_t - A_{t-1}) - (A_{t-1} - A_{t-2})|, anew each day; a term whose
///   three samples are not successive cycles is left out, and the divisor is always the number of terms less
///   one
/// Errors: hal::InputError on no sample, on a value that is not finite, on times that do not increase, on a
///   changing number of rooms, and when no sample falls into working hours.
/// Source: docs/method.md 9.
Metrics compute_metrics(std::span<const CycleSample> samples, std::span<const EnergyRow> energy,
                        const MetricsSettings& settings = {});

/// Mean and spread of one figure over repetitions (seeds, rooms).
struct Spread {
  double mean = 0;
  double sd = 0;  ///< sample standard deviation (n - 1); 0 for one value
  int count = 0;
};

/// Mean and sample standard deviation; an empty span gives count 0.
Spread spread_of(std::span<const double> values);

/// Spread of one member over runs: spread_of(runs, &Metrics::dae_degc).
Spread spread_of(std::span<const Metrics> runs, double Metrics::*figure);

/// Whether a cycle that starts at `time` is scored.
bool is_scored(CivilTime time, const MetricsSettings& settings = {});

constexpr double open_damper = 0.95;  ///< a box that has no more to give

}  // namespace airside::tools
