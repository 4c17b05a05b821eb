#include "tools/run/training/pretraining.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "tools/run/control_loop.hpp"
#include "tools/run/training/built_in_residual.hpp"

namespace airside::tools {

namespace {

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
  return run_chooser<T>(site, unbound, plant, until, progress, control_cycle(site.settings).seconds(),
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
void learn_fixed(const Site& site, Controller<T>& controller, std::span<const hal::LogRow> later) {
  const std::uint64_t before = controller.replay().total_pushed();
  using Reader = HistoryReader<T>;
  read_history<T>(site, controller, later, Reader::Head::learn, Reader::Starts::every_cycle);
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
  controller->draw_weights(init);
  const CivilTime day_two = std::min(CivilTime{(model.time().day() + 1) * 86400}, until);
  Pretraining out;
  const bool dynamic = options.pretrainer == Pretrainer::agent;
  out.run = options.pretrainer == Pretrainer::drawn_schedules
                ? run_varied_schedule<T>(site, model, until, options.seed, progress)
                : run_schedule(site, model, dynamic ? day_two : until, dynamic ? OnProgress() : progress);
  const auto second = std::ranges::find_if(out.run.rows, [&](const hal::LogRow& r) { return !(r.time < day_two); });
  const std::span<const hal::LogRow> first_day{out.run.rows.begin(), second}, later{second, out.run.rows.end()};
  controller->start(scaler_of<T>(site, first_day));
  read_history<T>(site, *controller, first_day, HistoryReader<T>::Head::learn);
  if (dynamic) {
    append(out.run, control<T>(site, model, *controller, until, progress));
  } else {
    learn_fixed<T>(site, *controller, later);
    out.run.optimiser_steps = controller->learning().learner.steps();
  }
  out.transitions = controller->replay().total_pushed();
  const bool has_residual = settings.head != 0 && settings.cycle_min == ControllerSettings().cycle_min;
  if (options.with_residual && has_residual) controller->take_residual(built_in_residual());
  out.blob = blob_of<T>(*controller, options.provenance, until);
  return out;
}

}  // namespace

Pretraining pretrain(const Site& site, sim::PlantModel& plant, CivilTime until, const PretrainOptions& options,
                     const OnProgress& progress) {
  Pretraining out;
  for_topology_of(site, [&]<class T>(T) { out = pretrain_as<T>(site, plant, until, options, progress); });
  return out;
}

}  // namespace airside::tools
