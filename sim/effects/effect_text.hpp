#pragma once
// What effect files say in text: places in names, wildcards, which sensor, which loop.

#include <string>
#include <vector>

#include "sim/effects/effect.hpp"

namespace airside::sim::effect_text {

/// "north", "east", "south" or "west".
std::string facade_name(int place);
void replace_all(std::string& text, const std::string& what, const std::string& with);
/// {n}, {zone}, {facade}, {Facade} filled in.
std::string filled(std::string text, const EffectAt& at, const std::string& zone);
/// The same in every text of an object; {m} becomes the number m, a text that is no more than that a number itself.
nlohmann::json filled(const nlohmann::json& object, const EffectAt& at, const std::string& zone, double m);
/// Whether `name` matches `pattern`, in which `*` stands for any text.
bool matches(const std::string& pattern, const std::string& name);
/// The model's zone at a place; empty for places that are none.
std::string zone_of(const EffectAt& at, const ModelNames& names);
/// The effect's own place, or every place of op.each.
std::vector<EffectAt> places_of_op(const EffectOp& op, const EffectAt& at, const ModelNames& names);

struct ColumnRange {
  int first = 0, count = 0;
};
/// "room_temp", "fcu_temp", "mau_temp", "supply_temp", "power"; count 0: unknown.
ColumnRange sensor_columns(const std::string& field, const Channels& channels);
/// Number of a loop by name; nullptr: unknown.
double* loop_field(RoomLoopOptions& loops, const std::string& field);

}  // namespace airside::sim::effect_text
