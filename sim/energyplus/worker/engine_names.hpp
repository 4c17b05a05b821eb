#pragma once
// From names of a model to the running engine's handles. A wrong name gives -1 in the engine's interface, and using it
// silently reads 0: here every name is checked.

#include <stdexcept>
#include <string>
#include <vector>

#include "sim/energyplus/worker/engine_api.hpp"

namespace airside::sim {

constexpr int no_handle = -1;

/// What a model lacks, in words for its user.
class NameError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class EngineNames {
 public:
  EngineNames(const EngineApi& api, EngineState state) : api_(api), state_(state) {}

  /// Asks for an output variable; before the engine runs.
  void request(const char* variable, const std::string& key) const;
  /// Handles, once the engine is ready.  Errors: NameError.
  int variable(const char* name, const std::string& key) const;
  int schedule(const std::string& name) const;
  int meter(const std::string& name) const;
  /// no_handle where the model has no such variable.
  int variable_if_any(const char* name, const std::string& key) const;

  double value(int variable) const { return api_.getVariableValue(state_, variable); }
  double meter_j(int meter) const { return api_.getMeterValue(state_, meter); }
  void act(int schedule, double value) const { api_.setActuatorValue(state_, schedule, value); }
  bool raining() const { return api_.isRaining(state_) != 0; }

 private:
  std::vector<std::string> meters() const;

  const EngineApi& api_;
  EngineState state_;
};

constexpr const char* zone_temp_variable = "Zone Mean Air Temperature";
constexpr const char* node_temp_variable = "System Node Temperature";
constexpr const char* outdoor_temp_variable = "Site Outdoor Air Drybulb Temperature";

}  // namespace airside::sim
