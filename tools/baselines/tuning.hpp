#pragma once
// The search for the gains of the peers: which controllers have gains, over which grid, and how the grid is walked.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tools/baselines/tuned.hpp"

namespace airside::tools {

/// One gain and the values that it may take, rising.
struct TuningAxis {
  std::string name;
  std::vector<double> values;
  bool ends_at_first = false;  ///< the first value is where the gain ends, such as a Kp of 0, not where the grid does
};

/// A peer with gains to be tuned.
struct TunablePeer {
  std::string method;  ///< as in baseline_names(), e.g. "pid-tuned"
  std::vector<TuningAxis> axes;
  std::unique_ptr<BaselineController> (*make)(const ControllerSettings&, std::span<const double> gains);
  std::vector<double> (*frozen)(const TunedGains&);  ///< its gains in the source's table, in the order of the axes
};

/// PID, integral, both ARX and MPC.
const std::vector<TunablePeer>& tunable_peers();

/// The outcome of a search over a grid.
struct GridSearch {
  struct Trial {
    std::vector<double> gains;
    double cost = 0;
  };
  Trial best;                      ///< the first of equals
  std::vector<Trial> trials;       ///< all that were tried, in order
  std::vector<std::string> edges;  ///< axes on whose edge the best stands: widen these
};

/// Costs of some candidates (lower is better; one that is not finite loses), in their order.
using CandidateCosts = std::function<std::vector<double>(std::span<const std::vector<double>>)>;

/// Tries every point of the grid. Errors: hal::InputError when no cost is finite.
GridSearch search_grid(std::span<const TuningAxis> axes, const CandidateCosts& costs);

/// Walks the grid downhill from the point nearest to `start`: to the best neighbour on an axis, or on a diagonal where
/// no axis leads on, until no neighbour is better.
/// Errors: hal::InputError when no cost is finite.
GridSearch descend_grid(std::span<const TuningAxis> axes, std::span<const double> start, const CandidateCosts& costs);

}  // namespace airside::tools
