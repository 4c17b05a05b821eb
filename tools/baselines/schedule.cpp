#include "tools/baselines/schedule.hpp"

#include <fmt/format.h>

#include "airside/supervision/schedule.hpp"

namespace airside::tools {

double ScheduleBaseline::decide(const CycleObservation& now) {
  return admissible_setpoint_degc(expert_setpoint_degc(site_, now.time), site_);
}

std::string ConstantBaseline::name() const { return fmt::format("constant {:.2f} °C", setpoint_degc_); }

}  // namespace airside::tools
