#pragma once
// Sites that lack signals: which are tried, and what it costs in the rooms, as measured.

#include <string>
#include <vector>

#include "hal/points/stand_ins.hpp"

namespace airside::tools {

/// A site without some signals, with the numbers that usually stand in for them.
struct MissingSignals {
  std::string name;  ///< what is missing, as it is printed
  hal::StandIns stand_ins;
};

/// What `airside study signals` tries: all signals there, each missing alone, all but outdoor_temp, all.
/// `counts`: of the site; each power meter is one of them, fan coils only where it has some.
std::vector<MissingSignals> missing_signal_cases(const hal::SignalCounts& counts);

/// DAE of the rooms without a kind of signal less that with all of them, degC; of one RC room, one seed, five days.
/// Source: docs/results.md, "Sites that lack signals".
double measured_cost_degc(SignalKind kind);

/// DAE in the same study, degC: with all signals; with room temperatures, setpoint and outdoor_temp alone.
struct MeasuredDae {
  double whole, bare;
};
constexpr MeasuredDae measured_dae_degc = {0.041, 0.047};

}  // namespace airside::tools
