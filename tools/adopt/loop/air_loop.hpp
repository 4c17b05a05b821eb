#pragma once
// One air loop of a foreign model: what the air passes on its way to the zones.

#include <string>
#include <vector>

#include "tools/adopt/model/model_view.hpp"

namespace airside::tools {

constexpr std::size_t max_terminals = 32;  ///< as many boxes as a site can have

enum class TerminalKind {
  fixed,       ///< the same flow all day: the supply temperature alone decides what a room gets
  modulating,  ///< the zone's thermostat moves a damper
  reheat,      ///< as modulating or fixed, with a coil of its own
};
const char* text_of(TerminalKind kind);

struct LoopTerminal {
  std::string type, name, zone;
  TerminalKind kind = TerminalKind::fixed;
  bool damper = false;      ///< the engine reports its damper's position
  bool thermostat = false;  ///< the zone has one
  bool people = false;      ///< and people; known after a run
};

/// Equipment on the supply side, between two nodes.
struct LoopComponent {
  std::string type, name, inlet, outlet;
};

/// A packaged unit, where coils and fan are not on the loop one by one.
struct UnitaryEquipment {
  std::string type, name;
  std::string control_type;               ///< of AirLoopHVAC:UnitarySystem: Load, SetPoint or SingleZoneVAV
  std::vector<std::string> coil_outlets;  ///< nodes inside the unit, behind its cooling and its heating coil
};

struct AirLoop {
  std::string name, supply_outlet, demand_inlet;
  std::vector<LoopComponent> components;  ///< in the air's order
  UnitaryEquipment unit;                  ///< empty type: none
  LoopComponent fan;                      ///< the supply fan; empty type: none
  bool blow_through = false;              ///< the fan is upstream of the coils
  std::string mixed_air_node;             ///< outlet of the outdoor-air system; empty: no outdoor air
  std::string outdoor_stream_node;        ///< outdoor air where it meets return air
  bool outdoor_air_treated = false;       ///< a coil or a heat exchanger is upstream of that node
  std::vector<LoopTerminal> terminals;
  std::vector<std::string> fcu_zones;  ///< zones of the loop that also have a fan coil unit
  std::vector<std::string> notes;      ///< plenums, other equipment in the zones

  TerminalKind kind() const;  ///< of most terminals
};

/// The name of the air loop to adopt: `wanted`, or the only one.
/// Errors: hal::InputError where the model has none, several and none is named, or not the named one; it lists them.
std::string chosen_air_loop(const ModelView& model, const std::string& wanted);

/// Walks the loop: supply side, supply path, terminals, zones.
/// Errors: hal::InputError for names that lead nowhere, a path that runs in a circle, a loop without a zone, with two
///   supply outlets, or with more than max_terminals.
AirLoop walk_air_loop(const ModelView& model, const std::string& name);

}  // namespace airside::tools
