#pragma once
// The one loop of lib on a simulated room, by topology: driven by the controller, or by anything that chooses a
// setpoint. For the sources beside this header; who runs a room calls control_run.hpp.

#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "airside/controller/cycle.hpp"
#include "airside/controller/history.hpp"
#include "airside/controller/instances.hpp"
#include "hal/points/signal_limits.hpp"
#include "hal/weights/blob_file.hpp"
#include "sim/simulated_plant.hpp"
#include "tools/run/control_run.hpp"
#include "tools/run/recorder.hpp"

namespace airside::tools {

template <Topology T>
using SitePayload = BlobPayload<T, NetworkWeights<T, float>::count>;

/// Anything that chooses a setpoint, in the shape that run_cycles() drives; it goes through the same envelope.
/// What chooses more often than once a cycle writes its choices between two cycles itself: the loop knows cycles only.
template <Topology T>
class Chooser {
 public:
  using Choose = std::function<double(CivilTime, const Reading<T>&, double last_degc)>;
  /// `period_s`: rows or cycles between two choices, in s.
  Chooser(const ControllerSettings& settings, sim::SimulatedPlant<T>& plant, int period_s, Choose choose)
      : settings_(settings),
        envelope_(settings),
        plant_(plant),
        period_s_(period_s),
        choose_(std::move(choose)),
        decision_{.time = {}, .command = envelope_.limit(settings.expert_off_degc, settings.expert_off_degc, 0)} {}

  void observe(CivilTime t, const Expected<Reading<T>>& sensed) {
    if (t.second_of_day() % period_s_ != 0) return;
    const Decision& chosen = decide(t, sensed);  // before it is written: arguments have no order
    absorb(chosen, plant_.actuate(chosen.command));
  }
  const Decision& decide(CivilTime t, const Expected<Reading<T>>& sensed) {
    const double expert = expert_setpoint_degc(settings_, t);
    const double proposal = choose_(t, *sensed, last_degc_);
    decision_ = {.time = t, .command = envelope_.limit(proposal, last_degc_, expert)};
    decision_.expert_degc = expert;
    return decision_;
  }
  void absorb(const Decision&, const Expected<Applied>& applied) { last_degc_ = applied->setpoint_degc; }
  const Decision& decision() const { return decision_; }
  const ControllerSettings& settings() const { return settings_; }
  double last_degc() const { return last_degc_; }

 private:
  ControllerSettings settings_;
  SafetyEnvelope envelope_;
  sim::SimulatedPlant<T>& plant_;
  int period_s_;
  Choose choose_;
  Decision decision_;
  double last_degc_ = std::numeric_limits<double>::quiet_NaN();
};

template <Topology T>
struct ChooserSink {
  Recorder& recorder;
  bool row(CivilTime t, const Expected<Reading<T>>& sensed, const Chooser<T>& chooser) {
    recorder.add<T>(t, sensed, chooser.decision(), chooser.last_degc());
    return true;
  }
};

/// The site's counts, as a controller of topology T takes them.
template <Topology T>
Shape shape_of(const Site& site) {
  return shape_in<T>(site.counts.shape());
}

template <Topology T>
ControlRun run_chooser(const Site& site, const ControllerSettings& settings, sim::PlantModel& model, CivilTime until,
                       const OnProgress& progress, int period_s, typename Chooser<T>::Choose choose) {
  sim::SimulatedPlant<T> plant(model, site.points, shape_of<T>(site), site.file.stand_ins);
  sim::SimulatedClock clock(model);
  const CivilTime from = next_row(model.time());
  Recorder recorder(site, model, until, progress);
  Chooser<T> chooser(settings, plant, period_s, std::move(choose));
  ChooserSink<T> sink{recorder};
  run_cycles<T>(plant, clock, chooser, sink, from, until);
  (void)clock.sleep_until(until);  // where the next run begins: no row is there twice
  return std::move(recorder.run);
}

template <Topology T>
std::unique_ptr<Controller<T>> make_controller(const Site& site, const ControllerSettings& settings,
                                               std::uint64_t seed) {
  auto controller = std::make_unique<Controller<T>>();
  controller->configure(settings, hal::signal_limits<T>(site.points, shape_of<T>(site), site.file.stand_ins),
                        hal::box_kernels(), seed);
  return controller;
}

template <Topology T>
void read_history(const Site& site, Controller<T>& controller, std::span<const hal::LogRow> rows,
                  typename HistoryReader<T>::Head head,
                  typename HistoryReader<T>::Starts starts = HistoryReader<T>::Starts::every_row) {
  HistoryReader<T> reader(controller, head, starts);
  for (const hal::LogRow& row : rows)
    reader.row(hal::reading_of<T>(row, shape_of<T>(site), site.counts.sides), row.setpoint_degc);
}

/// Without a site scope: pretrained weights are meant to travel; a scope belongs to a signed blob.
template <Topology T>
BlobBytes blob_of(const Controller<T>& controller, const std::string& provenance, CivilTime end) {
  auto payload = std::make_unique<SitePayload<T>>();
  give_payload<T>(controller, *payload);
  provenance.copy(payload->provenance.data(), payload->provenance.size() - 1);
  BlobHeader header;
  header.created_s = end.seconds;
  BlobBytes bytes(WeightBlob<T>::size(*payload));
  WeightBlob<T>::encode(header, *payload, bytes);
  return bytes;
}

/// Calls f with the site's topology type.
template <class F>
void for_topology_of(const Site& site, F&& f) {
  with_topology(site.counts.name.c_str(), std::forward<F>(f));
}

template <Topology T>
Scaler<T> scaler_of(const Site& site, std::span<const hal::LogRow> rows) {
  const auto limits = hal::signal_limits<T>(site.points, shape_of<T>(site), site.file.stand_ins);
  ScalerFit<T> fit;
  for (const hal::LogRow& row : rows) {
    auto value = hal::signals_of<T>(row, shape_of<T>(site));
    fill_stand_ins<T>(limits, value);
    if (value.allFinite()) fit.add(value);
  }
  return fit.fit(site.settings);
}

template <Topology T>
ControlRun control(const Site& site, sim::PlantModel& model, Controller<T>& controller, CivilTime until,
                   const OnProgress& progress) {
  sim::SimulatedPlant<T> plant(model, site.points, shape_of<T>(site), site.file.stand_ins);
  sim::SimulatedClock clock(model);
  const CivilTime from = next_row(model.time());
  Recorder recorder(site, model, until, progress);
  ControllerSink<T> sink{recorder};
  run_cycles<T>(plant, clock, controller, sink, from, until);
  (void)clock.sleep_until(until);  // where the next run begins: no row is there twice
  recorder.run.rejected_updates = controller.learning().rejected;
  recorder.run.optimiser_steps = sink.steps.total;
  return std::move(recorder.run);
}

}  // namespace airside::tools
