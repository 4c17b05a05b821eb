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

}  // namespace airside::tools
