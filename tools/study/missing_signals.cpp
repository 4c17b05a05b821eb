#include "tools/study/missing_signals.hpp"

#include <fmt/format.h>

#include <cmath>

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

MeasuredFigure measured_cost_degc(SignalKind kind) {
  switch (kind) {
    case SignalKind::rain: return {0.0001, 0.0003};
    case SignalKind::mau_temp: return {0.0000, 0.0004};
    case SignalKind::outdoor_temp: return {0.0000, 0.0003};
    case SignalKind::power: return {-0.0002, 0.0009};
    case SignalKind::fcu_temp:
    case SignalKind::fcu_on: return {0.0010, 0.0014};
    case SignalKind::vav_on: return {0.0013, 0.0015};
    default: return {0, 0};  // room temperatures and setpoint have no stand-in
  }
}

std::string cost_text(const MeasuredFigure& cost) {
  const std::string figure = fmt::format("{:+.3f} ± {:.3f} °C of DAE", cost.mean, cost.sd);
  return std::abs(cost.mean) <= cost.sd ? "nothing measurable (" + figure + ")" : figure;
}

}  // namespace airside::tools
