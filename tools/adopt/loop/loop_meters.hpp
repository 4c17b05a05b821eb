#pragma once
// Meters of one air loop alone, where the engine can tell its share; and how much outdoor air the loop always takes.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/adopt/loop/air_loop.hpp"
#include "tools/adopt/model/model_view.hpp"

namespace airside::tools {

/// The names that such meters have, whether or not a loop has them all.
inline constexpr const char* loop_fans_meter = "Loop Fans:Electricity";
inline constexpr const char* loop_cooling_meter = "Loop Cooling:Electricity";
inline constexpr const char* loop_heating_meter = "Loop Heating:Electricity";
inline constexpr const char* loop_gas_meter = "Loop Heating:NaturalGas";

/// A plant of chilled or hot water serves others too: what it takes is metered for the whole building alone.
struct LoopMeters {
  nlohmann::json patch = nlohmann::json::object();  ///< Meter:Custom objects
  bool fans = false;
  bool cooling = false;  ///< every cooling coil is the loop's own, without a plant
  bool heating = false;  ///< the same of heating coils, those of its terminals included
};

/// Fans and coils of the supply side, of what outdoor air passes before, and of the terminals.
LoopMeters loop_meters(const ModelView& model, const AirLoop& loop);

/// The coils of a loop: on its branches, in its coil systems and packaged unit, and those of its terminals.
std::vector<ModelObject> loop_coils(const ModelView& model, const AirLoop& loop);

/// Its Controller:OutdoorAir; empty where it has none.
ModelObject outdoor_air_controller(const ModelView& model, const AirLoop& loop);

/// Least outdoor air, share of the design flow: of the model's hard fields, else of the patch's sizes. 0: unknown.
double least_outdoor_share(const ModelView& model, const AirLoop& loop, const nlohmann::json& sizes);

}  // namespace airside::tools
