#pragma once
// A room that exists as a network only: its temperatures follow state and setpoint, all else is replayed from a log.

#include <memory>

#include "sim/learned/environment_file.hpp"
#include "sim/plant_model.hpp"

namespace airside::sim {

class LearnedPlant final : public PlantModel {
 public:
  /// Starts with the temperatures that the log has then.
  /// Errors: hal::InputError for a start that is no replayed row.
  LearnedPlant(std::shared_ptr<const LearnedEnvironment> environment, const hal::TopologyCounts& counts,
               CivilTime start, double setpoint_degc);

  CivilTime time() const override;
  int step_s() const override { return row_s; }
  /// Errors: std::invalid_argument if t is not a whole number of rows ahead; hal::InputError past the log.
  void advance_to(CivilTime t) override;
  void set_setpoint(double setpoint_degc) override;
  const Sensors& sensors() const override { return sensors_; }
  std::string description() const override;

 private:
  void show();

  std::shared_ptr<const LearnedEnvironment> environment_;
  int vavs_, fcus_, powers_;
  std::size_t row_ = 0;
  Eigen::VectorXd inputs_;  ///< [S E A] of the present row
  Sensors sensors_;
};

}  // namespace airside::sim
