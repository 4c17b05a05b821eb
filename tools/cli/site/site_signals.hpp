#pragma once
// What a site lacks, its stand-ins, and what that costs.

#include <optional>
#include <string>
#include <vector>

#include "hal/log/log_csv.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_file.hpp"

namespace airside::tools {

/// Signals of one kind that a site has no sensor for, in words.
struct LackingSignals {
  std::string names;               ///< `rain`, `power_1 to power_3`
  std::string use;                 ///< what the signal is for
  std::string instead;             ///< the stand-in, or what is not done
  std::string cost;                ///< in one clause; a figure only where one was measured
  std::optional<double> stand_in;  ///< of [stand_in]
};

/// Every optional signal that the site lacks: inputs of the network with their stand-ins, then the side signals.
/// `counts`: with stand-ins and sides, as hal::counts_of() has them.
std::vector<LackingSignals> missing_signals(const hal::SiteFile& site, const hal::PointMap& map,
                                            const hal::TopologyCounts& counts);

/// The key facts: how many kinds are missing, each on a line of its own, and what the site shows beside the network's
/// inputs.
std::string signal_facts(const hal::SiteFile& site, const hal::TopologyCounts& counts,
                         const std::vector<LackingSignals>& missing);

}  // namespace airside::tools
