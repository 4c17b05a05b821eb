#pragma once
// Any simulated room, with a script of faults between it and whoever looks at it: what the sensors show, and what the
// AHU makes of its setpoint. The room itself goes on as it would.

#include <limits>

#include "sim/faults/fault_script.hpp"
#include "sim/plant_model.hpp"

namespace airside::sim {

class FaultyModel final : public PlantModel {
 public:
  /// `inner` must outlive this; hours of the script count from its present.
  FaultyModel(PlantModel& inner, FaultScript script);

  CivilTime time() const override { return inner_.time(); }
  int step_s() const override { return inner_.step_s(); }
  void advance_to(CivilTime t) override;
  void set_setpoint(double setpoint_degc) override;
  const Sensors& sensors() const override { return shown_; }
  const PlantModel& truth() const override { return inner_; }
  std::string description() const override;

  /// Adds a fault that begins now.
  void begin(FaultKind kind, double for_h, int signal, double magnitude);
  /// Ends all faults.
  void clear();
  /// Whether a fault acts, or has ended less than `after_h` hours ago.
  bool disturbed(double after_h = 0) const;
  /// What stands in the AHU's setpoint register.  degC.
  double standing_degc() const { return standing_degc_; }

 private:
  struct Running {
    ScriptedFault fault;
    double kept = std::numeric_limits<double>::quiet_NaN();  ///< stuck: the value that is repeated
    bool has_begun = false;
    std::int64_t turns = 0;  ///< of somebody who fights
  };
  double hours() const { return static_cast<double>(inner_.time().seconds - start_.seconds) / 3600; }
  bool acts(const ScriptedFault& fault) const;
  /// The shown value of a signal, in the order of fault_signals().
  double& signal(int index);
  bool is_side(int index) const;
  bool is_offered(int index);
  void lose(int index);
  void hands();
  void show();
  void pass_on(double setpoint_degc);

  PlantModel& inner_;
  CivilTime start_;
  std::vector<Running> faults_;
  Sensors shown_;
  double standing_degc_;
  double not_offered_ = 0;  ///< in the place of a signal that the room does not show
};

}  // namespace airside::sim
