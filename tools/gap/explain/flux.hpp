#pragma once
// Where no effect explains the gap: the heat that is missing in each zone, reconstructed from the temperatures through
// the model's own responses, and described: where, when, how much, with what it goes and with what it does not.

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/gap/inference/selection.hpp"
#include "tools/gap/verdict/rules.hpp"

namespace airside::tools::gap {

struct HeatRules {
  double pulse_kw = 4;                               ///< for 30 min
  std::vector<double> pulse_hours = {2, 8, 14, 20};  ///< of day; a bin's response is that of the nearest
  int refinements = 4;                               ///< real simulations that correct the linear responses
  double limit_sd = 4;                               ///< standard deviations below which it is noise ..
  double least_kw = 0.3;                             ///< .. and below this nobody would look for it
  double model_share = 0.18;                         ///< sd of an amount from the twin's other errors, of the amount
  Nuisance nuisance = {};
};

/// How heat goes with something known.
struct HeatDriver {
  std::string name;      ///< "outdoor temperature", "fan coil on"
  bool weather = false;  ///< temperature, sun, rain
  double r = 0;          ///< correlation of the 30-min means
  double r_days = 0;  ///< the same after each one's mean day was taken off, times the root of the share of the heat's
                      ///< variance that is left then: what the clock does not explain already
  bool linked = false, clearly_not = false;
};

/// Standard deviations of amounts are of all that may be wrong: chance, how days differ, the twin's other errors.
struct ZoneHeat {
  int zone = 0;  ///< 0-based, VAV zones first
  bool above_noise = false;
  double mean_kw = 0, mean_sd_kw = 0;      ///< over all hours but the first day's
  double from_h = 0, to_h = 24;            ///< when the mean day is above half of its peak
  double active_kw = 0, active_sd_kw = 0;  ///< in those hours
  double peak_kw = 0;                      ///< of the mean day
  double kwh_per_day = 0;
  double weekday_kw = 0, weekend_kw = 0;  ///< in those hours; NaN where there is no such day
  double days_share = 0;                  ///< of days on which it is at least half of that
  std::vector<HeatDriver> drivers;
  std::string brief, text;  ///< where, when and how much; the same with what it goes with; empty where it is noise
};

struct UnknownHeat {
  Eigen::MatrixXd heat_kw, sd_kw;  ///< bins x zones; into the air
  std::vector<ZoneHeat> zones;     ///< all, in order
  std::vector<double> smoothing;   ///< of each zone: weight of the squared second differences
  double residual_ratio = 0;       ///< mean square of what the heat leaves of the whitened temperatures
  std::string text;                ///< of the largest, and how many more; or that there is none
};

/// Heat u of each zone in each 30-min bin, from room and fan-coil temperatures.
///   min over u of (r - G u)' M (r - G u) + sum over zones of lambda_z |D2 u_z|^2,
/// G the whitened responses to a pulse in each zone (linear, every day the same, half a day long), M the metric that
/// marginalises parameters, D2 second differences in time, lambda_z of each zone by the evidence (MacKay 1992). Then r
/// is corrected by what a real simulation with u shows beyond G u, and u solved again, `refinements` times.
///   cov u = s^2 (G'MG + lambda D2'D2)^-1, s^2 the mean square left over, at least 1.
/// A zone's level is known less well than its changes: where the level that prevails is within 3 standard deviations of
/// none, it is taken as none.
/// Shape: `responses` of the window, as the fit's.  Units: kW into the zones' air.
/// Errors: as Engine::simulate.
/// Cost: zones x pulse_hours + refinements + 1 simulations; G'G + lambda D2'D2 is a block band, so linear algebra grows
/// with the days.
UnknownHeat reconstruct_heat(const Engine& engine, const Window& window, const ReferenceFit& fit,
                             const Responses& responses, const Changes& fitted_parameters, int jobs,
                             const HeatRules& rules = {});

/// The recording with heat in its zones; after the last bin that one's.  Shape: bins x zones.  kW.
sim::Recording heated(sim::Recording recording, const Eigen::MatrixXd& heat_kw);

/// Standard deviation of a weighted sum of one zone's bins.
using HeatSd = std::function<double(int zone, const Eigen::VectorXd& weights)>;

/// Fills zones and text of `heat`, whose heat_kw is there.
void describe_heat(UnknownHeat& heat, const sim::Recording& recording, const sim::Channels& channels,
                   const HeatSd& sd_of, const HeatRules& rules);

/// Numbers by zone and the text; with `series` also heat and sd, one list a zone.
nlohmann::json json_of(const UnknownHeat& heat, bool series = true);

}  // namespace airside::tools::gap
