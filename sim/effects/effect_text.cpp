#include "sim/effects/effect_text.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>

namespace airside::sim::effect_text {

namespace {

bool matches_from(const char* p, const char* s) {
  for (; *p != '\0' && *p != '*'; ++p, ++s) {
    if (*p != *s) return false;
  }
  if (*p == '\0') return *s == '\0';
  for (;; ++s) {
    if (matches_from(p + 1, s)) return true;
    if (*s == '\0') return false;
  }
}

}  // namespace

std::string facade_name(int place) {
  constexpr std::array names = {"north", "east", "south", "west"};
  return names.at(static_cast<std::size_t>(place));
}

void replace_all(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
}

std::string filled(std::string text, const EffectAt& at, const std::string& zone) {
  replace_all(text, "{n}", std::to_string(at.place + 1));
  replace_all(text, "{zone}", zone);
  if (at.effect->place == PlaceKind::facade) {
    std::string name = facade_name(at.place);
    replace_all(text, "{facade}", name);
    name[0] = static_cast<char>(std::toupper(name[0]));
    replace_all(text, "{Facade}", name);
  }
  return text;
}

nlohmann::json filled(const nlohmann::json& object, const EffectAt& at, const std::string& zone, double m) {
  if (object.is_string()) {
    const auto& text = object.get_ref<const std::string&>();
    if (text == "{m}") return m;
    std::string with = filled(text, at, zone);
    replace_all(with, "{m}", fmt::format("{}", m));
    return with;
  }
  if (!object.is_structured()) return object;
  nlohmann::json out = object;
  for (auto& part : out) part = filled(part, at, zone, m);
  return out;
}

bool matches(const std::string& pattern, const std::string& name) {
  return matches_from(pattern.c_str(), name.c_str());
}

std::string zone_of(const EffectAt& at, const ModelNames& names) {
  const int interior = static_cast<int>(names.interior_zones.size());
  int zone = -1;
  switch (at.effect->place) {
    case PlaceKind::zone:
    case PlaceKind::vav: zone = at.place; break;
    case PlaceKind::fcu: zone = interior + at.place; break;
    default: return {};
  }
  if (zone < interior) return names.interior_zones[static_cast<std::size_t>(zone)];
  return names.perimeter_zones[static_cast<std::size_t>(zone - interior)];
}

std::vector<EffectAt> places_of_op(const EffectOp& op, const EffectAt& at, const ModelNames& names) {
  if (op.each == PlaceKind::floor) return {at};
  // Effects that only lend their kind of place, so that names are filled in alike.
  const auto lender = [](PlaceKind kind) {
    Effect e;
    e.place = kind;
    return e;
  };
  static const Effect by_zone = lender(PlaceKind::zone), by_vav = lender(PlaceKind::vav),
                      by_fcu = lender(PlaceKind::fcu);
  const auto interior = static_cast<int>(names.interior_zones.size());
  const auto perimeter = static_cast<int>(names.perimeter_zones.size());
  const Effect& lent = op.each == PlaceKind::vav ? by_vav : op.each == PlaceKind::fcu ? by_fcu : by_zone;
  const int count = op.each == PlaceKind::vav ? interior : op.each == PlaceKind::fcu ? perimeter : interior + perimeter;
  std::vector<EffectAt> places;
  for (int i = 0; i < count; ++i) places.push_back({&lent, i});
  return places;
}

ColumnRange sensor_columns(const std::string& field, const Channels& channels) {
  if (field == "room_temp") return {0, channels.rooms};
  if (field == "fcu_temp") return {channels.fcu_temp(), channels.fcus};
  if (field == "mau_temp") return {channels.mau_temp(), 1};
  if (field == "supply_temp") return {channels.supply_temp(), 1};
  if (field == "power") return {channels.power(), channels.powers};
  return {};
}

double* loop_field(RoomLoopOptions& loops, const std::string& field) {
  if (field == "occupancy_scale") return &loops.occupancy_scale;
  if (field == "occupancy_shift_min") return &loops.occupancy_shift_min;
  if (field == "supply_bias_k") return &loops.supply_bias_k;
  if (field == "supply_lag_s") return &loops.supply_lag_s;
  if (field == "fcu_setpoint_degc") return &loops.fcu_setpoint_degc;
  return nullptr;
}

}  // namespace airside::sim::effect_text
