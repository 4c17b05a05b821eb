#include "tools/gap/model/engine.hpp"

#include <algorithm>
#include <mutex>
#include <numeric>

#include "sim/rc/rc_replay.hpp"
#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

bool only_on_sensors(const std::vector<sim::EffectOp>& ops) {
  return !ops.empty() && std::all_of(ops.begin(), ops.end(),
                                     [](const sim::EffectOp& op) { return op.on == sim::EffectOp::On::sensor; });
}

sim::ChannelTable RcEngine::simulate(const Changes& changes, const sim::Recording& recording) const {
  return shown(sim::changed_room(room_, changes), changes, recording);
}

sim::ChannelTable RcEngine::shown(const sim::RcRoom& room, const Changes& changes,
                                  const sim::Recording& recording) const {
  const sim::Recording lived = sim::changed_recording(recording, changes);
  return sim::changed_sensors(sim::replay_rc(room, lived, true, false, weathers_->of(lived)), channels(), changes);
}

/// A reference period tells parameters to a few hundredths; the rest of the usual 10 to 20 % shows as structure.
sim::ChannelTable RcEngine::simulate_differing(std::uint64_t seed, const Changes& changes,
                                               const sim::Recording& recording) const {
  sim::Perturbation by;
  by.relative = by.zone_relative = by.flow_relative = 0.05;
  by.sensor_bias_k = 0.05;
  by.supply_offset_k = by.neighbour_k = by.site_temp_k = by.fcu_dial_k = 0.1;
  return shown(with_other_structure(measured_room(sim::changed_room(room_, changes), seed, seed % 2 == 1, by), seed),
               changes, recording);
}

std::array<bool, sim::facades> RcEngine::has_facade() const {
  const auto any = [](const std::vector<double>& m2) { return std::accumulate(m2.begin(), m2.end(), 0.0) > 0; };
  return {any(room_.window_north_m2), any(room_.window_east_m2), any(room_.window_south_m2), any(room_.window_west_m2)};
}

std::vector<sim::ChannelTable> simulate_all(const Engine& engine, const std::vector<Task>& tasks, int jobs,
                                            const std::function<void()>& done) {
  std::vector<sim::ChannelTable> tables(tasks.size());
  std::mutex mutex;
  in_parallel(tasks.size(), jobs, [&](std::size_t i) {
    tables[i] = engine.simulate(tasks[i].changes, *tasks[i].recording);
    const std::lock_guard lock(mutex);
    if (done) done();
  });
  return tables;
}

}  // namespace airside::tools::gap
