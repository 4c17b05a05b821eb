#include "tools/gap/model/energyplus_engine.hpp"

#include <algorithm>
#include <limits>

#include "sim/energyplus/adopted/model_index.hpp"
#include "sim/json/merge_patch.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "tools/gap/any_model/effect_patch.hpp"
#include "tools/gap/any_model/model_graph.hpp"
#include "tools/gap/model/patched_model.hpp"

namespace airside::tools::gap {

sim::ChannelTable EnergyPlusEngine::simulate(const Changes& changes, const sim::Recording& recording) const {
  const sim::EnergyPlusTwin twin = changed_twin(changes);
  sim::Recording lived = sim::changed_recording(recording, changes);
  if (twin.own) lived.from.seconds -= lived.from.seconds % twin.step_s;  // a clock may run ahead by half a step
  const sim::Channels at = channels();
  sim::ChannelTable table = sim::replay_energyplus(twin, lived, {.cache = cache_, .memory = &memory_});
  if (twin.own) {
    if (!duties_) table.middleCols(at.fcu_duty(), at.fcus).setConstant(std::numeric_limits<double>::quiet_NaN());
  } else if (duties_) {
    const auto free = sim::replay_energyplus(twin, lived, {.thermostats = true, .cache = cache_, .memory = &memory_});
    table.rightCols(at.fcus) = free.rightCols(at.fcus);
  } else {
    table.rightCols(at.fcus).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return sim::changed_sensors(std::move(table), at, changes);
}

sim::EnergyPlusTwin EnergyPlusEngine::changed_twin(const Changes& changes) const {
  sim::EnergyPlusTwin twin = twin_;
  twin.model =
      sim::merge_patched(std::move(twin.model), model_changes(twin_.model, twin_.names, twin_.own, changes), "effects");
  twin.loops = sim::changed_loops(twin_.loops, changes, twin_.own ? &sim::Effect::any_model : &sim::Effect::energyplus);
  return twin;
}

std::string EnergyPlusEngine::why_not(const sim::EffectAt& at) const {
  if (!twin_.own) return {};
  const auto rooms = static_cast<int>(twin_.own->zones.size());
  if (at.effect->place == sim::PlaceKind::zone && at.place >= rooms) {
    const std::string& zone = twin_.own->fcu_zones.at(static_cast<std::size_t>(at.place - rooms));
    for (std::size_t i = 0; i < twin_.own->zones.size(); ++i) {
      if (sim::engine_case(twin_.own->zones[i]) == sim::engine_case(zone))
        return "the same zone as room " + std::to_string(i + 1);
    }
  }
  const auto& changes = at.effect->common;
  const auto any = [](const std::vector<sim::EffectOp>& ops, sim::EffectOp::On on, const char* field) {
    return std::any_of(ops.begin(), ops.end(),
                       [&](const sim::EffectOp& op) { return op.on == on && (*field == 0 || op.field == field); });
  };
  if (!twin_.own->outdoor_measured && any(changes, sim::EffectOp::On::weather, "outdoor_temp"))
    return "the log has no outdoor temperature";
  if (!plays_setpoint() &&
      (any(at.effect->any_model, sim::EffectOp::On::loop, "") || any(changes, sim::EffectOp::On::command, "setpoint")))
    return "no recorded supply setpoint is played";
  return why_not_applicable(twin_.model, *twin_.own, at);
}

std::optional<sim::RcRoom> EnergyPlusEngine::stand_in() const {
  if (twin_.own) return std::nullopt;
  const sim::Channels at = channels();
  const std::vector<std::string> names = sim::room_names();
  if (std::find(names.begin(), names.end(), name_) != names.end()) {
    sim::RcRoom room = sim::load_room(name_);
    if (room.vavs == at.rooms && room.fcus == at.fcus && room.powers == at.powers) return room;
  }
  return sim::make_room(at.rooms, at.fcus, at.powers);
}

std::array<bool, sim::facades> EnergyPlusEngine::has_facade() const {
  if (twin_.own) return ModelGraph(twin_.model, *twin_.own).has_facade();
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
