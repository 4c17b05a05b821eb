#include "tools/baselines/tuning.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "hal/text/input_error.hpp"
#include "tools/baselines/arx.hpp"
#include "tools/baselines/mpc.hpp"

namespace airside::tools {
namespace {

using Point = std::vector<std::size_t>;

std::unique_ptr<BaselineController> make_arx(const ControllerSettings& site, double rho, bool exogenous) {
  ArxSettings settings;
  settings.exogenous = exogenous;
  settings.rho = rho;
  return std::make_unique<ArxBaseline>(site, settings);
}

const std::vector<double> ki_per_h = {0.5, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14, 16, 20};
const std::vector<double> rhos = {-0.6, -0.5, -0.4, -0.3, -0.2, -0.1, -0.05, 0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6};

/// Points that were tried, and the best of them.
class Walk {
 public:
  Walk(std::span<const TuningAxis> axes, const CandidateCosts& costs) : axes_(axes), costs_(costs) {}

  /// Tries those of `points` that are new; whether one of them is the best now.
  bool try_all(const std::vector<Point>& points) {
    std::vector<std::vector<double>> gains;
    std::vector<Point> fresh;
    for (const Point& p : points) {
      if (!tried_.emplace(p, true).second) continue;
      fresh.push_back(p);
      gains.emplace_back();
      for (std::size_t a = 0; a < axes_.size(); ++a) gains.back().push_back(axes_[a].values[p[a]]);
    }
    if (fresh.empty()) return false;
    const std::vector<double> costs = costs_(gains);
    bool better = false;
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      result.trials.push_back({gains[i], costs[i]});
      if (!(costs[i] < result.best.cost)) continue;
      result.best = result.trials.back();
      at_ = fresh[i];
      better = true;
    }
    return better;
  }

  /// Steps of one on `moves` axes at least and at most.
  std::vector<Point> neighbours(std::size_t least, std::size_t most) const {
    std::vector<Point> out;
    std::size_t all = 1;
    for (std::size_t a = 0; a < axes_.size(); ++a) all *= 3;
    for (std::size_t code = 0; code < all; ++code) {
      Point p = at_;
      std::size_t moved = 0, rest = code;
      bool inside = true;
      for (std::size_t a = 0; a < axes_.size(); ++a, rest /= 3) {
        moved += rest % 3 != 0 ? 1 : 0;
        if (rest % 3 == 1) inside = inside && p[a]-- > 0;
        if (rest % 3 == 2) inside = inside && ++p[a] < axes_[a].values.size();
      }
      if (inside && moved >= least && moved <= most) out.push_back(p);
    }
    return out;
  }

  GridSearch finish() {
    if (!std::isfinite(result.best.cost)) {
      throw hal::InputError("gain search", result.trials.empty() ? "no candidate" : "no finite cost",
                            "at least one candidate that can be scored", "check the plant of the search");
    }
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      const bool first = at_[a] == 0 && !axes_[a].ends_at_first;
      if (first || at_[a] + 1 == axes_[a].values.size()) result.edges.push_back(axes_[a].name);
    }
    return std::move(result);
  }

  GridSearch result{{{}, std::numeric_limits<double>::infinity()}, {}, {}};

 private:
  std::span<const TuningAxis> axes_;
  const CandidateCosts& costs_;
  std::map<Point, bool> tried_;
  Point at_;
};

}  // namespace

const std::vector<TunablePeer>& tunable_peers() {
  static const std::vector<TunablePeer> peers = {
      {"pid-tuned",
       {{"kp", {0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1, 1.25, 1.5, 2, 2.5, 3}, true},
        {"ki_per_h", ki_per_h},
        {"kd_h", {0, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5}, true}},
       [](const ControllerSettings& site, std::span<const double> g) -> std::unique_ptr<BaselineController> {
         return std::make_unique<PidBaseline>(site, PidGains{g[0], g[1], g[2]}, "PID, tuned");
       },
       [](const TunedGains& g) {
         return std::vector<double>{g.pid.kp, g.pid.ki_per_h, g.pid.kd_h};
       }},
      {"integral-tuned",
       {{"ki_per_h", ki_per_h}},
       [](const ControllerSettings& site, std::span<const double> g) -> std::unique_ptr<BaselineController> {
         return std::make_unique<IntegralBaseline>(site, g[0]);
       },
       [](const TunedGains& g) { return std::vector<double>{g.integral_ki_per_h}; }},
      {"arx-2",
       {{"rho", rhos}},
       [](const ControllerSettings& site, std::span<const double> g) { return make_arx(site, g[0], false); },
       [](const TunedGains& g) { return std::vector<double>{g.arx_rho}; }},
      {"arx-rls",
       {{"rho", rhos}},
       [](const ControllerSettings& site, std::span<const double> g) { return make_arx(site, g[0], true); },
       [](const TunedGains& g) { return std::vector<double>{g.arx_rls_rho}; }},
      {"mpc",
       {{"move_weight", {0.0001, 0.0003, 0.001, 0.003, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 1, 2}, false},
        {"disturbance_share", {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6}, false}},
       [](const ControllerSettings& site, std::span<const double> g) -> std::unique_ptr<BaselineController> {
         MpcSettings settings;
         settings.move_weight = g[0];
         settings.disturbance_share = g[1];
         return std::make_unique<MpcBaseline>(site, settings);
       },
       [](const TunedGains& g) {
         return std::vector<double>{g.mpc_move_weight, g.mpc_disturbance_share};
       }},
  };
  return peers;
}

GridSearch search_grid(std::span<const TuningAxis> axes, const CandidateCosts& costs) {
  std::vector<Point> all = {{}};
  for (const TuningAxis& axis : axes) {
    std::vector<Point> longer;
    for (const Point& p : all) {
      for (std::size_t i = 0; i < axis.values.size(); ++i) {
        longer.push_back(p);
        longer.back().push_back(i);
      }
    }
    all = std::move(longer);
  }
  Walk walk(axes, costs);
  (void)walk.try_all(all);
  return walk.finish();
}

GridSearch descend_grid(std::span<const TuningAxis> axes, std::span<const double> start, const CandidateCosts& costs) {
  Point nearest;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const auto& values = axes[a].values;
    const auto closer = [&](double x, double y) { return std::abs(x - start[a]) < std::abs(y - start[a]); };
    nearest.push_back(
        static_cast<std::size_t>(std::min_element(values.begin(), values.end(), closer) - values.begin()));
  }
  Walk walk(axes, costs);
  bool better = walk.try_all({nearest});
  while (better) {
    better = walk.try_all(walk.neighbours(1, 1));
    if (!better && axes.size() > 1) better = walk.try_all(walk.neighbours(2, axes.size()));
  }
  return walk.finish();
}

}  // namespace airside::tools
