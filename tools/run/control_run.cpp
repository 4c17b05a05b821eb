#include "tools/run/control_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <numeric>
#include <span>
#include <stdexcept>

#include "airside/controller/cycle.hpp"
#include "airside/controller/history.hpp"
#include "airside/controller/instances.hpp"
#include "hal/log/log_record.hpp"
#include "hal/points/signal_limits.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/input_error.hpp"
#include "hal/weights/blob_file.hpp"
#include "sim/simulated_plant.hpp"

namespace airside::tools {

namespace {

template <Topology T>
using Payload = BlobPayload<T, NetworkWeights<T, float>::count>;

/// Rows of a run, as the loop makes them.
class Recorder {
 public:
  Recorder(const Site& site, const sim::PlantModel& model, CivilTime until, const OnProgress& progress)
      : blank_(hal::make_log_row(site.counts)),
        model_(model),
        from_(next_row(model.time())),
        until_(until),
        progress_(progress) {}

  template <Topology T>
  void add(CivilTime t, const Expected<Reading<T>>& sensed, const Decision& decision, double setpoint_degc) {
    run.rows.push_back(blank_);
    hal::LogRow& row = run.rows.back();
    hal::fill_log_row<T>(row, t, sensed, decision, setpoint_degc);
    using L = Layout<T>;
    const auto value = row.value.begin();
    double power = 0;
    for (int i = 0; i < T::powers; ++i) power += value[L::power + i];
    CycleSample sample{t, 0, {value, value + L::rooms}, setpoint_degc};
    if (&model_.truth() != &model_) {
      // Scores are about the room, not about what broken sensors say of it.
      const sim::Sensors& room = model_.truth().sensors();
      power = std::accumulate(room.power_kw.begin(), room.power_kw.end(), 0.0);
      sample.room_temp_degc = room.room_temp_degc;
      sample.setpoint_degc = room.setpoint_degc;
    }
    run.energy.push_back({t, power});
    if (starts_cycle(t)) {
      for (const double s : sample.room_temp_degc) sample.room_mean_degc += s / L::rooms;
      run.cycles.push_back(std::move(sample));
    }
    if (progress_ && starts_cycle(t)) {
      progress_(static_cast<double>(t.seconds + cycle_s - from_.seconds) /
                static_cast<double>(until_.seconds - from_.seconds));
    }
  }

  ControlRun run;

 private:
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
    return true;
  }
};

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
    if (t.second_of_day() % period_s_ == 0) absorb(plant_.actuate(decide(t, sensed).command));
  }
  const Decision& decide(CivilTime t, const Expected<Reading<T>>& sensed) {
    const double expert = expert_setpoint_degc(settings_, t);
    const double proposal = choose_(t, *sensed, last_degc_);
    decision_ = {.time = t, .command = envelope_.limit(proposal, last_degc_, expert)};
    decision_.expert_degc = expert;
    return decision_;
  }
  void absorb(const Expected<Applied>& applied) { last_degc_ = applied->setpoint_degc; }
  const Decision& decision() const { return decision_; }
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

template <Topology T>
ControlRun run_chooser(const Site& site, const ControllerSettings& settings, sim::PlantModel& model, CivilTime until,
                       const OnProgress& progress, int period_s, typename Chooser<T>::Choose choose) {
  sim::SimulatedPlant<T> plant(model, site.points);
  sim::SimulatedClock clock(model);
  const CivilTime from = next_row(model.time());
  Recorder recorder(site, model, until, progress);
  Chooser<T> chooser(settings, plant, period_s, std::move(choose));
  ChooserSink<T> sink{recorder};
  run_cycles<T>(plant, clock, chooser, sink, from, until);
  (void)clock.sleep_until(until);  // where the next run begins: no row stands twice
  return std::move(recorder.run);
}

template <Topology T>
typename Reading<T>::Vector values_of(const hal::LogRow& row) {
  return Eigen::Map<const typename Reading<T>::Vector>(row.value.data());
}

template <Topology T>
std::unique_ptr<Controller<T>> make_controller(const Site& site, const ControllerSettings& settings,
                                               std::uint64_t seed) {
  auto controller = std::make_unique<Controller<T>>();
  controller->configure(settings, hal::signal_limits<T>(site.points), hal::box_kernels(), seed);
  return controller;
}

template <Topology T>
void read_history(Controller<T>& controller, std::span<const hal::LogRow> rows, typename HistoryReader<T>::Head head,
                  typename HistoryReader<T>::Starts starts = HistoryReader<T>::Starts::every_row) {
  HistoryReader<T> reader(controller, head, starts);
  for (const hal::LogRow& row : rows) reader.row(row.time, values_of<T>(row), row.setpoint_degc);
}

/// Without a site scope: pretrained weights are meant to travel; a scope belongs to a signed blob.
template <Topology T>
BlobBytes blob_of(const Controller<T>& controller, const std::string& provenance, CivilTime end) {
  auto payload = std::make_unique<Payload<T>>();
  give_payload<T>(controller, *payload);
  provenance.copy(payload->provenance.data(), payload->provenance.size() - 1);
  BlobHeader header;
  header.created_s = end.seconds;
  BlobBytes bytes(WeightBlob<T>::size(payload->head_states));
  WeightBlob<T>::encode(header, *payload, bytes);
  return bytes;
}

/// Calls f with the site's topology type.
template <class F>
void dispatch(const Site& site, F&& f) {
  with_topology(site.counts.name.c_str(), std::forward<F>(f));
}

template <Topology T>
Scaler<T> scaler_of(const Site& site, std::span<const hal::LogRow> rows) {
  ScalerFit<T> fit;
  for (const hal::LogRow& row : rows) {
    const auto value = values_of<T>(row);
    if (value.allFinite()) fit.add(value);
  }
  return fit.fit(site.settings);
}

template <Topology T>
ControlRun control(const Site& site, sim::PlantModel& model, Controller<T>& controller, CivilTime until,
                   const OnProgress& progress) {
  sim::SimulatedPlant<T> plant(model, site.points);
  sim::SimulatedClock clock(model);
  const CivilTime from = next_row(model.time());
  Recorder recorder(site, model, until, progress);
  ControllerSink<T> sink{recorder};
  run_cycles<T>(plant, clock, controller, sink, from, until);
  (void)clock.sleep_until(until);  // where the next run begins: no row stands twice
  recorder.run.rejected_updates = controller.learning().rejected;
  recorder.run.optimiser_steps = sink.steps.total;
  return std::move(recorder.run);
}

void append(ControlRun& run, ControlRun&& more) {
  run.rows.insert(run.rows.end(), more.rows.begin(), more.rows.end());
  run.cycles.insert(run.cycles.end(), more.cycles.begin(), more.cycles.end());
  run.energy.insert(run.energy.end(), more.energy.begin(), more.energy.end());
  run.rejected_updates = more.rejected_updates;
  run.optimiser_steps += more.optimiser_steps;
}

template <Topology T>
ControlRun run_varied_schedule(const Site& site, sim::PlantModel& plant, CivilTime until, std::uint64_t seed,
                               const OnProgress& progress) {
  // docs/method.md, open point 27: the working setpoint of each day is drawn from {19.5 .. 21.5}. Limits of the site's
  // machinery bind nobody in a twin: by default they would make 20 of 19.5, and two steps of one that is larger than
  // the expert's.
  constexpr double lowest_degc = 19.5, step_k = 0.5;
  ControllerSettings unbound = site.settings;
  unbound.limit_min_degc = std::min(site.settings.limit_min_degc, lowest_degc);
  unbound.limit_change_k = site.settings.limit_max_degc - unbound.limit_min_degc;
  SplitMix64 draw(seed ^ 0x57A71Cu);
  std::int64_t day = -1;
  double work_degc = site.settings.expert_work_degc;
  return run_chooser<T>(site, unbound, plant, until, progress, cycle_s,
                        [&, draw, day, work_degc](CivilTime t, const Reading<T>&, double) mutable {
                          if (t.day() != day) {
                            day = t.day();
                            work_degc = lowest_degc + step_k * draw.below(5);
                          }
                          return in_working_hours(site.settings, t) ? work_degc : site.settings.expert_off_degc;
                        });
}

/// Days 2 and on are remembered as an agent would: a transition a cycle, the first when the day's first cycle ends.
template <Topology T>
void learn_fixed(Controller<T>& controller, std::span<const hal::LogRow> later) {
  const std::uint64_t before = controller.replay().total_pushed();
  using Reader = HistoryReader<T>;
  read_history<T>(controller, later, Reader::Head::learn, Reader::Starts::every_cycle);
  const std::uint64_t cycles = controller.replay().total_pushed() - before;
  const std::uint64_t steps = cycles * static_cast<std::uint64_t>(controller.settings().updates_per_cycle);
  for (std::uint64_t i = 0; i < steps; ++i) (void)controller.train_step();
}

template <Topology T>
Pretraining pretrain_as(const Site& site, sim::PlantModel& model, CivilTime until, const PretrainOptions& options,
                        const OnProgress& progress) {
  ControllerSettings settings = site.settings;
  if (options.updates_per_cycle > 0) settings.updates_per_cycle = options.updates_per_cycle;
  auto controller = make_controller<T>(site, settings, options.seed);
  SplitMix64 init(options.seed);
  initialise_uniform(controller->learning().weights, init);
  const CivilTime day_two = std::min(CivilTime{(model.time().day() + 1) * 86400}, until);
  Pretraining out;
  const bool dynamic = options.pretrainer == Pretrainer::agent;
  out.run = options.pretrainer == Pretrainer::drawn_schedules
                ? run_varied_schedule<T>(site, model, until, options.seed, progress)
                : run_schedule(site, model, dynamic ? day_two : until, dynamic ? OnProgress() : progress);
  const auto second = std::ranges::find_if(out.run.rows, [&](const hal::LogRow& r) { return !(r.time < day_two); });
  const std::span<const hal::LogRow> first_day{out.run.rows.begin(), second}, later{second, out.run.rows.end()};
  controller->start(scaler_of<T>(site, first_day));
  read_history<T>(*controller, first_day, HistoryReader<T>::Head::learn);
  if (dynamic) {
    append(out.run, control<T>(site, model, *controller, until, progress));
  } else {
    learn_fixed<T>(*controller, later);
    out.run.optimiser_steps = controller->learning().learner.steps();
  }
  out.transitions = controller->replay().total_pushed();
  out.blob = blob_of<T>(*controller, options.provenance, until);
  return out;
}

}  // namespace

MetricsSettings metrics_settings(const Site& site) {
  MetricsSettings m;
  m.target_degc = site.settings.target_degc;
  m.work_start_s = static_cast<int>(std::lround(site.settings.work_start_h * 3600));
  m.work_end_s = static_cast<int>(std::lround(site.settings.work_end_h * 3600));
  m.weekdays_only = site.settings.weekday_only != 0;
  return m;
}

Metrics metrics_of(const Site& site, const ControlRun& run) {
  return compute_metrics(run.cycles, run.energy, metrics_settings(site));
}

ControlRun run_schedule(const Site& site, sim::PlantModel& plant, CivilTime until, const OnProgress& progress) {
  ControlRun run;
  dispatch(site, [&]<class T>(T) {
    run = run_chooser<T>(
        site, site.settings, plant, until, progress, cycle_s,
        [&site](CivilTime t, const Reading<T>&, double) { return expert_setpoint_degc(site.settings, t); });
  });
  return run;
}

Pretraining pretrain(const Site& site, sim::PlantModel& plant, CivilTime until, const PretrainOptions& options,
                     const OnProgress& progress) {
  Pretraining out;
  dispatch(site, [&]<class T>(T) { out = pretrain_as<T>(site, plant, until, options, progress); });
  return out;
}

BlobBytes fine_tune(const Site& site, const BlobBytes& source, const std::vector<hal::LogRow>& rows,
                    const FineTuneOptions& options, const OnProgress& progress) {
  BlobBytes out;
  dispatch(site, [&]<class T>(T) {
    auto controller = make_controller<T>(site, site.settings, options.seed);
    double gain = site.settings.head_gain_prior, gain_sd = site.settings.head_gain_prior_sd;
    if (source.empty()) {
      SplitMix64 init(options.seed);
      initialise_uniform(controller->learning().weights, init);
      controller->start(scaler_of<T>(site, rows));
    } else {
      auto payload = std::make_unique<Payload<T>>();
      hal::decode_blob<T>(source, site.file.scope, "source blob", *payload);
      take_payload<T>(*controller, *payload);
      if (payload->head_states != 0) {
        gain = controller->learning().head.gain(site.settings);
        gain_sd = std::max(0.1, 2 * controller->learning().head.gain_sd());
      }
    }
    controller->learning().head.reset(site.settings, gain, gain_sd);
    read_history<T>(*controller, rows, HistoryReader<T>::Head::learn);
    if (controller->replay().size() == 0) {
      throw hal::InputError("log", fmt::format("{} rows without one 18-min stretch of constant setpoint", rows.size()),
                            "at least four successive 6-min rows under one setpoint", "log some days of the schedule");
    }
    for (int i = 0; i < options.steps; ++i) {
      (void)controller->train_step();
      if (progress && i % 50 == 49) progress((i + 1.0) / options.steps);
    }
    out = blob_of<T>(*controller, options.provenance, rows.back().time);
  });
  return out;
}

ControlRun run_controller(const Site& site, sim::PlantModel& plant, const BlobBytes& blob,
                          const std::vector<hal::LogRow>& history, CivilTime until, std::uint64_t seed,
                          const OnProgress& progress) {
  ControlRun run;
  dispatch(site, [&]<class T>(T) {
    auto controller = make_controller<T>(site, site.settings, seed);
    auto payload = std::make_unique<Payload<T>>();
    hal::decode_blob<T>(blob, site.file.scope, "weights", *payload);
    take_payload<T>(*controller, *payload);
    read_history<T>(*controller, history, HistoryReader<T>::Head::leave);
    run = control<T>(site, plant, *controller, until, progress);
  });
  return run;
}

ControlRun run_baseline(const Site& site, sim::PlantModel& plant, BaselineController& baseline,
                        const std::vector<hal::LogRow>& history, CivilTime until, const OnProgress& progress) {
  const int period_s = baseline.decision_period_s();
  if (period_s <= 0 || period_s % row_s != 0 || cycle_s % period_s != 0) {
    throw std::logic_error(fmt::format("{}: a period of {} s; rows are {} s apart, cycles {} s", baseline.name(),
                                       period_s, row_s, cycle_s));
  }
  ControllerSettings limits = site.settings;
  if (!baseline.keeps_to_site()) {
    limits.limit_min_degc = 0;
    limits.limit_max_degc = limits.limit_change_k = 50;
  }
  ControlRun run;
  dispatch(site, [&]<class T>(T) {
    using L = Layout<T>;
    const auto sensors_of = [](const double* value) {
      sim::Sensors s;
      const auto part = [value](int at, int n) { return std::vector<double>(value + at, value + at + n); };
      s.room_temp_degc = part(L::room_temp, L::rooms);
      s.fcu_temp_degc = part(L::fcu_temp, T::fcus);
      s.vav_on = part(L::vav_on, T::vavs);
      s.fcu_on = part(L::fcu_on, T::fcus);
      s.power_kw = part(L::power, T::powers);
      s.mau_temp_degc = value[L::mau_temp];
      s.outdoor_temp_degc = value[L::outdoor_temp];
      s.rain = value[L::rain];
      return s;
    };
    std::vector<HistoryRow> past;
    for (const hal::LogRow& row : history) past.push_back({row.time, sensors_of(row.value.data()), row.setpoint_degc});
    baseline.observe_history(past);
    double last_known = history.empty() ? plant.sensors().setpoint_degc : history.back().setpoint_degc;
    run = run_chooser<T>(site, limits, plant, until, progress, period_s,
                         [&](CivilTime t, const Reading<T>& reading, double last) {
                           CycleObservation now;
                           now.time = t;
                           now.sensors = sensors_of(reading.value.data());
                           now.sensors.setpoint_degc = reading.setpoint_degc;
                           now.sensors.supply_temp_degc = reading.supply_temp_degc;
                           now.previous_setpoint_degc = std::isfinite(last) ? last : last_known;
                           now.target_degc = site.settings.target_degc;
                           return baseline.decide(now);
                         });
  });
  return run;
}

ControlRun run_setpoints(const Site& site, sim::PlantModel& plant, const std::function<double()>& choose,
                         CivilTime until, const OnProgress& progress) {
  ControlRun run;
  dispatch(site, [&]<class T>(T) {
    run = run_chooser<T>(site, site.settings, plant, until, progress, cycle_s,
                         [&](CivilTime, const Reading<T>&, double) { return choose(); });
  });
  return run;
}

BlobBytes read_blob(const std::string& path, const Site& site) {
  BlobBytes bytes = hal::read_blob_file(path);
  dispatch(site, [&]<class T>(T) {
    auto payload = std::make_unique<Payload<T>>();
    hal::decode_blob<T>(bytes, site.file.scope, path, *payload);
  });
  return bytes;
}

std::size_t most_blob_bytes(const Site& site) {
  std::size_t bytes = 0;
  dispatch(site, [&]<class T>(T) { bytes = sizeof(BlobHeader) + sizeof(Payload<T>); });
  return bytes;
}

}  // namespace airside::tools
