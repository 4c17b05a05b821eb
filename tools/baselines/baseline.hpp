#pragma once
// What an operator could have instead of the learned controller: one interface for all of them, so that a
// study drives every method through the same plant, the same instants and the same rounding.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "airside/civil_time.hpp"
#include "airside/settings.hpp"
#include "sim/plant_model.hpp"

namespace airside::tools {

/// What a controller knows when it must decide. A reading that is not finite counts as missing.
struct CycleObservation {
  CivilTime time;
  sim::Sensors sensors;               ///< S and E at `time`
  double previous_setpoint_degc = 0;  ///< applied from the decision before until now
  double target_degc = 25.25;
};

/// A logged row of the days before the controller takes over.
struct HistoryRow {
  CivilTime time;
  sim::Sensors sensors;
  double setpoint_degc = 0;  ///< applied from `time` until the next row
};

/// The kind of plant that a peer stands on. An engineer tunes on the plant, so each kind has gains of its own
/// (tuned.hpp).
enum class PlantKind : std::uint8_t { rc, energyplus };

class BaselineController {
 public:
  virtual ~BaselineController() = default;

  /// For tables and legends.
  virtual std::string name() const = 0;
  /// The expert days that every method is given before the first decision, 6 min apart, in order of time.
  virtual void observe_history(std::span<const HistoryRow> rows) { static_cast<void>(rows); }
  /// Whether anything that it decides depends on those days, be it by the setpoint that they end with.
  virtual bool heeds_history() const { return false; }
  /// How often decide() is called and its setpoint written, s: a whole number of rows, whole in a cycle; `cycle_s`, the
  /// site's control cycle, except where the method is defined otherwise.
  virtual int decision_period_s(int cycle_s) const { return cycle_s; }
  /// False: its source's own range holds, though this site would never let it be written.
  virtual bool keeps_to_site() const { return true; }
  /// The setpoint to hold until the next decision: admissible and rounded. degC.
  virtual double decide(const CycleObservation& now) = 0;
};

/// Mean of the finite room temperatures, degC; NaN when there is none.
double room_mean_degc(const sim::Sensors& sensors);

/// Clamped to the action range of `site`, then rounded to its resolution. degC. Source: docs/method.md, open point 18.
double admissible_setpoint_degc(double setpoint_degc, const ControllerSettings& site);

/// Builds a baseline by the name that studies and command lines use; see baseline_names(). What is tuned takes the
/// gains that were found on plants of that kind (tuned.hpp). Errors: hal::InputError on a name that is not in
/// baseline_names().
std::unique_ptr<BaselineController> make_baseline(std::string_view name, const ControllerSettings& site,
                                                  PlantKind plant = PlantKind::rc);

/// All names that make_baseline() knows, in the order in which tables list them.
std::vector<std::string> baseline_names();

}  // namespace airside::tools
