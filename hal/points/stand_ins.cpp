#include "hal/points/stand_ins.hpp"

#include <algorithm>
#include <array>

#include "hal/points/point_map.hpp"

namespace airside::hal {
namespace {

constexpr std::array<SignalKind, 7> optional_kinds = {
    SignalKind::fcu_temp, SignalKind::vav_on,       SignalKind::fcu_on, SignalKind::power,
    SignalKind::mau_temp, SignalKind::outdoor_temp, SignalKind::rain};

}  // namespace

int SignalCounts::of(SignalKind kind) const {
  switch (kind) {
    case SignalKind::room_temp:
    case SignalKind::vav_on: return vavs;
    case SignalKind::fcu_temp:
    case SignalKind::fcu_on: return fcus;
    case SignalKind::power: return powers;
    default: return 1;
  }
}

std::span<const SignalKind> StandIns::kinds() { return optional_kinds; }

StandIns::Plausible StandIns::plausible(SignalKind kind) {
  switch (kind) {
    case SignalKind::fcu_temp: return {5, 45, 25};
    case SignalKind::vav_on: return {0, 1, 1};
    case SignalKind::fcu_on: return {0, 1, 0};
    case SignalKind::power: return {0, 10000, 4};
    case SignalKind::mau_temp: return {-20, 60, 18};
    case SignalKind::outdoor_temp: return {-40, 60, 28};
    default: return {0, 1, 0};
  }
}

std::vector<std::string> StandIns::names(const SignalCounts& counts) {
  std::vector<std::string> names;
  for (const SignalKind kind : optional_kinds) {
    if (counts.of(kind) == 0) continue;
    names.push_back(point_name({kind, 0}));
    if (has_places(kind)) {
      for (int place = 1; place <= counts.of(kind); ++place) names.push_back(point_name({kind, place}));
    }
  }
  return names;
}

std::optional<SignalKind> StandIns::kind_of(std::string_view name, const SignalCounts& counts) {
  for (const SignalKind kind : optional_kinds) {
    if (counts.of(kind) == 0) continue;
    if (name == text_of(kind).name) return kind;
    for (int place = 1; has_places(kind) && place <= counts.of(kind); ++place) {
      if (name == point_name({kind, place})) return kind;
    }
  }
  return std::nullopt;
}

std::optional<double> StandIns::of(SignalId id) const {
  const auto found = by_name_.find(name_for(id));
  if (found == by_name_.end() || std::ranges::find(optional_kinds, id.kind) == optional_kinds.end()) {
    return std::nullopt;
  }
  return found->second;
}

std::string StandIns::name_for(SignalId id) const {
  std::string own = point_name(id);
  return by_name_.contains(own) ? own : std::string(text_of(id.kind).name);
}

}  // namespace airside::hal
