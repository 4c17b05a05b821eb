#pragma once
// A simulated building with its figures counted beside it, so that every method is judged by the same rows.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "sim/plant_model.hpp"
#include "tools/run/metrics.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {

/// Means over the scored days. "above" and "below" count hours in which people are there; where the model does not show
/// people, the site's working hours.
struct BuildingFigures {
  double dae_degc = 0;              ///< mean |mean of rooms - target|, working hours
  double above_degch = 0;           ///< zone degree-hours a day above cooling setpoint + 0.5 K, sum over zones
  double below_degch = 0;           ///< below heating setpoint - 0.5 K
  double saturated_h = 0;           ///< zone-hours a day with a damper above 0.95
  double setpoint_degc = 0;         ///< mean, working hours
  double darv_degc = 0;             ///< docs/method.md 9, working hours
  std::vector<double> kwh_per_day;  ///< one a meter of the site
  double total_kwh() const;
  double outside_degch() const { return above_degch + below_degch; }
};

/// Between processes and in files; kwh_per_day as a list.
nlohmann::json json_of(const BuildingFigures& f);
BuildingFigures figures_of(const nlohmann::json& j);

/// Counts from `from` on; before, it only passes on.
class MeteredModel final : public sim::PlantModel {
 public:
  /// `inner` and `site` must outlive this.
  MeteredModel(sim::PlantModel& inner, const Site& site, CivilTime from);

  CivilTime time() const override { return inner_.time(); }
  int step_s() const override { return inner_.step_s(); }
  void advance_to(CivilTime t) override;
  void set_setpoint(double setpoint_degc) override { inner_.set_setpoint(setpoint_degc); }
  const sim::Sensors& sensors() const override { return inner_.sensors(); }
  std::string description() const override { return inner_.description(); }

  /// Of what was counted so far.  Errors: std::logic_error before the first whole day; as compute_metrics().
  BuildingFigures figures() const;

 private:
  void count_step(double hours);
  void count_comfort(const sim::Sensors& now, double hours);
  void count_cycle();

  sim::PlantModel& inner_;
  const Site& site_;
  CivilTime from_;
  BuildingFigures sums_;
  double counted_h_ = 0;
  std::vector<CycleSample> cycles_;
};

}  // namespace airside::tools
