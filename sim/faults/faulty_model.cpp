#include "sim/faults/faulty_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace airside::sim {
namespace {

constexpr int inputs_without_place = 3, side_without_place = 4;  // mau_temp to rain; supply_temp to ahu_on

}  // namespace

FaultyModel::FaultyModel(PlantModel& inner, FaultScript script)
    : inner_(inner), start_(inner.time()), standing_degc_(inner.sensors().setpoint_degc) {
  for (const ScriptedFault& fault : script) faults_.push_back({fault});
  hands();
  show();
}

void FaultyModel::advance_to(CivilTime t) {
  // Row by row, because a hand on the setpoint acts between two looks.
  while (inner_.time() < t) {
    inner_.advance_to({std::min(t.seconds, inner_.time().seconds + row_s)});
    hands();
  }
  show();
}

std::string FaultyModel::description() const {
  return inner_.description() + ", " + std::to_string(faults_.size()) + " scripted faults";
}

void FaultyModel::begin(FaultKind kind, double for_h, int signal, double magnitude) {
  faults_.push_back({{kind, hours(), for_h, signal, magnitude}});
  hands();
  show();
}

void FaultyModel::clear() {
  faults_.clear();
  pass_on(standing_degc_);
  show();
}

bool FaultyModel::acts(const ScriptedFault& fault) const {
  return hours() >= fault.begin_h && hours() < fault.begin_h + fault.for_h;
}

bool FaultyModel::disturbed(double after_h) const {
  return std::any_of(faults_.begin(), faults_.end(), [&](const Running& r) {
    return hours() >= r.fault.begin_h && hours() < r.fault.begin_h + r.fault.for_h + after_h;
  });
}

void FaultyModel::set_setpoint(double setpoint_degc) {
  for (const Running& r : faults_) {
    if (r.fault.kind == FaultKind::setpoint_clamped && acts(r.fault)) {
      setpoint_degc = std::min(setpoint_degc, r.fault.magnitude);
    }
  }
  standing_degc_ = setpoint_degc;
  pass_on(setpoint_degc);
  shown_.setpoint_degc = standing_degc_;
}

void FaultyModel::pass_on(double setpoint_degc) {
  const bool ignored = std::any_of(faults_.begin(), faults_.end(), [this](const Running& r) {
    return r.fault.kind == FaultKind::setpoint_ignored && acts(r.fault);
  });
  if (!ignored) inner_.set_setpoint(setpoint_degc);
}

/// What somebody, or a restart, does to the setpoint now.
void FaultyModel::hands() {
  for (Running& r : faults_) {
    const bool now = acts(r.fault);
    const bool once = r.fault.kind == FaultKind::setpoint_by_hand || r.fault.kind == FaultKind::restarted;
    const bool first = !r.has_begun && hours() >= r.fault.begin_h;
    r.has_begun = r.has_begun || (once ? first : now);
    const bool again = r.fault.kind == FaultKind::setpoint_fought && now && r.turns++ % 2 == 0;
    if ((once && first) || again) {
      standing_degc_ = r.fault.magnitude;
      pass_on(standing_degc_);
    }
    if (r.fault.kind == FaultKind::setpoint_ignored && r.has_begun && !now) {
      r.has_begun = false;
      pass_on(standing_degc_);
    }
  }
}

double& FaultyModel::signal(int index) {
  for (std::vector<double>* part :
       {&shown_.room_temp_degc, &shown_.fcu_temp_degc, &shown_.vav_on, &shown_.fcu_on, &shown_.power_kw}) {
    const auto size = static_cast<int>(part->size());
    if (index < size) return (*part)[static_cast<std::size_t>(index)];
    index -= size;
  }
  double* const single[] = {&shown_.mau_temp_degc, &shown_.outdoor_temp_degc, &shown_.rain,  &shown_.supply_temp_degc,
                            &shown_.occupied,      &shown_.supply_flow_m3s,   &shown_.ahu_on};
  if (index < inputs_without_place + side_without_place) return *single[index];
  index -= inputs_without_place + side_without_place;
  const auto vavs = static_cast<int>(shown_.room_temp_degc.size());
  std::vector<double>* const of_zones[] = {&shown_.damper, &shown_.zone_setpoint_degc, &shown_.heating_setpoint_degc};
  std::vector<double>& part = *of_zones[std::min(index / vavs, 2)];
  const auto place = static_cast<std::size_t>(index % vavs);
  return place < part.size() ? part[place] : not_offered_ = std::numeric_limits<double>::quiet_NaN();
}

/// What is no input of the network comes after those inputs.
bool FaultyModel::is_side(int index) const {
  const std::size_t at_places = 2 * shown_.room_temp_degc.size() + 2 * shown_.fcu_temp_degc.size();
  return index >
         static_cast<int>(at_places + shown_.power_kw.size()) + inputs_without_place;  // supply_temp is as inputs
}

bool FaultyModel::is_offered(int index) { return !is_side(index) || !std::isnan(signal(index)); }

/// Of a side signal NaN means that the plant does not offer it; a sensor without a value shows what no register holds.
void FaultyModel::lose(int index) {
  if (!is_offered(index)) return;
  signal(index) = is_side(index) ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
}

void FaultyModel::show() {
  const Sensors previous = std::exchange(shown_, inner_.sensors());
  shown_.setpoint_degc = standing_degc_;
  bool repeats = false;
  for (Running& r : faults_) {
    const ScriptedFault& f = r.fault;
    if (!acts(f)) {
      r.kept = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    switch (f.kind) {
      case FaultKind::not_a_number: lose(f.signal); break;
      case FaultKind::set_to:
        if (is_offered(f.signal)) signal(f.signal) = f.magnitude;
        break;
      case FaultKind::reversed: signal(f.signal) = 1 - signal(f.signal); break;
      case FaultKind::offset: signal(f.signal) += f.magnitude; break;
      case FaultKind::stuck:
        if (!std::isfinite(r.kept)) r.kept = signal(f.signal);
        signal(f.signal) = r.kept;
        break;
      case FaultKind::drift: signal(f.signal) += f.magnitude * (hours() - f.begin_h) / 24; break;
      case FaultKind::all_stuck: repeats = true; break;
      case FaultKind::all_offset:
        for (double& room : shown_.room_temp_degc) room += f.magnitude;
        break;
      default: break;
    }
  }
  // The device repeats what it showed last, its setpoint and supply air as well.
  if (repeats && !previous.room_temp_degc.empty()) shown_ = previous;
}

}  // namespace airside::sim
