#include "tools/gap/model/energyplus_engine.hpp"

#include <limits>

#include "sim/json/merge_patch.hpp"

namespace airside::tools::gap {

sim::ChannelTable EnergyPlusEngine::simulate(const Changes& changes, const sim::Recording& recording) const {
  sim::EnergyPlusTwin twin = twin_;
  twin.model =
      sim::merge_patched(std::move(twin.model), sim::model_patch(twin_.model, twin_.names, changes), "effects");
  twin.loops = sim::changed_loops(twin_.loops, changes);
  const sim::Recording lived = sim::changed_recording(recording, changes);
  const sim::Channels at = channels();
  sim::ChannelTable table = sim::replay_energyplus(twin, lived, {.cache = cache_, .memory = &memory_});
  if (duties_) {
    const auto free = sim::replay_energyplus(twin, lived, {.thermostats = true, .cache = cache_, .memory = &memory_});
    table.rightCols(at.fcus) = free.rightCols(at.fcus);
  } else {
    table.rightCols(at.fcus).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return sim::changed_sensors(std::move(table), at, changes);
}

std::array<bool, sim::facades> EnergyPlusEngine::has_facade() const {
  constexpr const char* names[] = {" North ", " East ", " South ", " West "};
  std::array<bool, sim::facades> has{};
  const auto glazing = twin_.model.find("WindowMaterial:SimpleGlazingSystem");
  if (glazing == twin_.model.end()) return has;
  for (const auto& [name, object] : glazing->items()) {
    for (std::size_t f = 0; f < has.size(); ++f) has[f] = has[f] || name.find(names[f]) != std::string::npos;
  }
  return has;
}

}  // namespace airside::tools::gap
