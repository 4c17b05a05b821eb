#pragma once
// What a run of the loop leaves behind, row by row, and the sinks that fill it.

#include <cstdint>
#include <numeric>
#include <utility>

#include "airside/controller/cycle.hpp"
#include "hal/log/log_record.hpp"
#include "sim/plant_model.hpp"
#include "tools/run/control_run.hpp"

namespace airside::tools {

/// Rows of a run, as the loop makes them.
class Recorder {
 public:
  Recorder(const Site& site, const sim::PlantModel& model, CivilTime until, const OnProgress& progress)
      : counts_(site.counts),
        cycle_(control_cycle(site.settings)),
        blank_(hal::make_log_row(site.counts)),
        model_(model),
        from_(next_row(model.time())),
        until_(until),
        progress_(progress) {}

  template <Topology T>
  void add(CivilTime t, const Expected<Reading<T>>& sensed, const Decision& decision, double setpoint_degc) {
    run.rows.push_back(blank_);
    hal::LogRow& row = run.rows.back();
    hal::fill_log_row<T>(row, shape_in<T>(counts_.shape()), t, sensed, decision, setpoint_degc);
    hal::fill_sides<T>(row, counts_.sides, sensed);
    const auto value = row.value.begin();
    double power = 0;
    const std::vector<double>& metered = model_.truth().sensors().power_kw;
    const int first = 2 * counts_.vavs + 2 * counts_.fcus;
    for (int i = 0; i < counts_.powers; ++i) {
      const auto k = static_cast<std::size_t>(i);
      // A stand-in is no meter: then the plant's own counts.
      power += counts_.stand_in(first + i) && k < metered.size() ? metered[k] : value[first + i];
    }
    CycleSample sample{t, 0, {value, value + counts_.vavs}, setpoint_degc};
    if (&model_.truth() != &model_) {
      // Scores are about the room, not about what broken sensors say of it.
      const sim::Sensors& room = model_.truth().sensors();
      power = std::accumulate(room.power_kw.begin(), room.power_kw.end(), 0.0);
      sample.room_temp_degc = room.room_temp_degc;
      sample.setpoint_degc = room.setpoint_degc;
    }
    run.energy.push_back({t, power});
    if (cycle_.starts(t)) {
      for (const double s : sample.room_temp_degc) sample.room_mean_degc += s / counts_.vavs;
      sample.head_error_k = decision.head_error_k;
      sample.network_error_k = decision.network_error_k;
      run.cycles.push_back(std::move(sample));
    }
    if (progress_ && cycle_.starts(t)) {
      progress_(static_cast<double>(t.seconds + cycle_.seconds() - from_.seconds) /
                static_cast<double>(until_.seconds - from_.seconds));
    }
  }

  ControlRun run;

 private:
  hal::TopologyCounts counts_;
  ControlCycle cycle_;
  hal::LogRow blank_;
  const sim::PlantModel& model_;
  CivilTime from_, until_;
  const OnProgress& progress_;
};

/// Counts optimiser steps, which the learner forgets when the gate refuses them.
class StepCount {
 public:
  template <class Controller_>
  void row(const Controller_& controller) {
    const auto& learning = controller.learning();
    const bool refused = learning.rejected != rejected_;
    total += refused ? static_cast<std::uint64_t>(controller.settings().updates_per_cycle)
                     : learning.learner.steps() - steps_;
    rejected_ = learning.rejected;
    steps_ = learning.learner.steps();
  }
  std::uint64_t total = 0;

 private:
  std::uint64_t steps_ = 0, rejected_ = 0;
};

template <Topology T>
struct ControllerSink {
  Recorder& recorder;
  StepCount steps = {};
  bool row(CivilTime t, const Expected<Reading<T>>& sensed, const Controller<T>& controller) {
    steps.row(controller);
    recorder.add<T>(t, sensed, controller.decision(), controller.cycle().last_setpoint_degc);
    const auto& residual = controller.cycle().residual;
    if (control_cycle(controller.settings()).starts(t) && residual.has_features != 0) {
      recorder.run.cycles.back().residual_features.assign(residual.features.x.begin(), residual.features.x.end());
    }
    return true;
  }
};

}  // namespace airside::tools
