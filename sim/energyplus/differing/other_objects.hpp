#pragma once
// An EnergyPlus room in other objects than its twin's, which say the same or nearly.

#include <nlohmann/json.hpp>

#include "sim/energyplus/options.hpp"

namespace airside::sim {

struct OtherObjects {
  std::uint64_t seed = 1;
  double modulation_per_k = 0;  ///< opening added a K above 25.25; 0: fixed dampers
};

/// The model in other objects: air mixes by ZoneCrossMixing, façades leak by EffectiveLeakageArea or ventilation, heat
/// comes from ElectricEquipment instead of OtherEquipment and the reverse, insulation is thinner instead of more
/// conductive, furniture heavier instead of more, boxes open less instead of being smaller, windows lie under eaves.
/// `nominal`: the same model before anything was changed in it on purpose, which tells what is to be said otherwise.
/// Made for twin.epJSON's names; objects that are absent stay so.
nlohmann::json other_objects(nlohmann::json model, const nlohmann::json& nominal, const ModelNames& names,
                             RoomLoopOptions& loops, const OtherObjects& how);

}  // namespace airside::sim
