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

/// A figure of the study over rooms and seeds. degC.
struct MeasuredFigure {
  double mean, sd;
};

/// DAE of the rooms without a kind of signal less that with all of them, room by room and seed by seed.
/// Source: docs/results.md, "Sites that lack signals".
MeasuredFigure measured_cost_degc(SignalKind kind);

/// The cost in words: "+0.020 ± 0.005 °C of DAE", or "nothing measurable (...)" where it lies within its spread of
/// nothing.
std::string cost_text(const MeasuredFigure& cost);

/// DAE in the same study: with all signals; with room temperatures, setpoint and outdoor_temp alone.
struct MeasuredDae {
  MeasuredFigure whole, bare;
};
constexpr MeasuredDae measured_dae_degc = {{0.0504, 0.0091}, {0.0535, 0.0092}};
constexpr const char* measured_on = "twelve RC rooms with three seeds each";

}  // namespace airside::tools
