#include "tools/study/missing_signals.hpp"

#include <fmt/format.h>

#include "hal/points/point_map.hpp"

namespace airside::tools {

namespace {

void leave_out(hal::StandIns& stand_ins, SignalKind kind) {
  stand_ins.set(hal::point_name({kind, 0}), hal::StandIns::plausible(kind).usual);
}

}  // namespace

std::vector<MissingSignals> missing_signal_cases(const hal::SignalCounts& counts) {
  std::vector<MissingSignals> cases{{"none", {}}};
  const auto add = [&](const std::string& name, std::initializer_list<SignalKind> kinds) {
    cases.push_back({name, {}});
    for (const SignalKind kind : kinds) leave_out(cases.back().stand_ins, kind);
  };
  add("rain", {SignalKind::rain});
  add("mau_temp", {SignalKind::mau_temp});
  add("outdoor_temp", {SignalKind::outdoor_temp});
  for (int place = 1; place <= counts.powers; ++place) {
    const std::string name = hal::point_name({SignalKind::power, place});
    cases.push_back({name, {}});
    cases.back().stand_ins.set(name, hal::StandIns::plausible(SignalKind::power).usual);
  }
  if (counts.powers > 1) add("power", {SignalKind::power});
  if (counts.fcus > 0) add("fcu", {SignalKind::fcu_temp, SignalKind::fcu_on});
  add("vav_on", {SignalKind::vav_on});
  add("all but outdoor_temp", {SignalKind::rain, SignalKind::mau_temp, SignalKind::power, SignalKind::vav_on,
                               SignalKind::fcu_temp, SignalKind::fcu_on});
  add("all", {SignalKind::rain, SignalKind::mau_temp, SignalKind::outdoor_temp, SignalKind::power, SignalKind::vav_on,
              SignalKind::fcu_temp, SignalKind::fcu_on});
  return cases;
}

double measured_cost_degc(SignalKind kind) { return kind == SignalKind::vav_on ? 0.005 : 0.000; }

}  // namespace airside::tools
