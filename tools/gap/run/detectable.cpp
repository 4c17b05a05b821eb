#include "tools/gap/run/detectable.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace airside::tools::gap {

std::vector<Detectable> detectable_sizes(const GapRun& run) {
  std::vector<Detectable> sizes;
  const std::vector<Candidate>& candidates = run.responses.test.candidates;
  for (std::size_t i = 0; i < candidates.size(); i += 2) {
    const sim::Effect& e = *candidates[i].at.effect;
    Detectable d{candidates[i].at, std::numeric_limits<double>::quiet_NaN(), e.high, false};
    for (const Score& score : run.verdict.ranking) {
      if (score.candidate / 2 != i / 2) continue;
      const Candidate& c = candidates[score.candidate];
      const double limit = log_likelihood_limit(run.rules, run.verdict.nulls, score.candidate);
      d.size = e.null_value + (c.probe - e.null_value) * score.steps_sd * std::sqrt(limit);
      d.bound = c.probe > e.null_value ? e.high : e.low;
      d.visible = std::abs(d.size - e.null_value) <= std::abs(d.bound - e.null_value);
    }
    sizes.push_back(d);
  }
  return sizes;
}

std::string invisible_text(const std::vector<Detectable>& sizes) {
  std::string text;
  for (const Detectable& d : sizes) {
    if (!d.visible) text += (text.empty() ? "not visible with these sensors: " : ", ") + d.at.id();
  }
  return text;
}

std::string own_control_text(const Engine& engine) {
  std::vector<std::string> played = engine.played_schedules();
  if (engine.plays_setpoint()) played.insert(played.begin(), "the supply setpoint");
  return (played.empty() ? std::string("No recorded command is played.")
                         : fmt::format("What is played of the record: {}.", fmt::join(played, ", "))) +
         " Thermostats, dampers, fan coils, people and plant run under the model's own control and schedules where "
         "they are not in it. What a thermostat makes good does not show in its room: such an effect shows in meters "
         "and dampers alone, later and less clearly than with recorded commands, and a control that differs from the "
         "model's looks like a load.";
}

}  // namespace airside::tools::gap
