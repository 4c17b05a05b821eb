#include "tools/gap/blind/blind.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/rc/rc_plant.hpp"
#include "sim/stateless_draw.hpp"
#include "tools/gap/blind/test_commands.hpp"

namespace airside::tools::gap {

namespace {

enum RoomDraw : std::uint64_t { draw_schedule = 711, draw_missing };

double& entry_at(std::vector<double>& list, int place) { return list.at(static_cast<std::size_t>(place)); }

double two_decimals(double x) { return std::round(100 * x) / 100; }

/// Sensors, clocks and commands have fields of their own in a room; the rest goes through the effect's file.
bool hide_directly(sim::RcRoom& room, const Hidden& h) {
  const double m = h.magnitude;
  if (h.effect == "fcu_runs_unrecorded")
    entry_at(room.fcu_forced, h.place) = m >= 0.5 ? 1 : 0;
  else if (h.effect == "fcu_rests_unrecorded")
    entry_at(room.fcu_forced, h.place) = m < 0.5 ? -1 : 0;
  else if (h.effect == "vav_stuck")
    entry_at(room.vav_stuck_damper, h.place) = m * entry_at(room.vav_damper, h.place);
  else if (h.effect == "room_sensor_bias")
    entry_at(room.room_sensor_bias_k, h.place) += m;
  else if (h.effect == "room_sensor_drift") {
    entry_at(room.room_sensor_drift_k_per_day, h.place) += m;
    entry_at(room.room_sensor_bias_k, h.place) -= measured_lead_days * m;  // it begins with the log
  } else if (h.effect == "room_sensor_jet")
    entry_at(room.room_sensor_jet_share, h.place) += m;
  else if (h.effect == "room_sensor_lag")
    return true;  // at the logger
  else if (h.effect == "fcu_sensor_bias")
    entry_at(room.fcu_sensor_bias_k, h.place) += m;
  else if (h.effect == "swapped_sensors") {
    const auto [a, b] = sim::vav_pair(h.place, room.vavs);
    std::swap(entry_at(room.room_sensor_zone, a), entry_at(room.room_sensor_zone, b));
  } else if (h.effect == "clock_shift")
    room.clock_shift_s += 3600 * m;
  else if (h.effect == "sun_differs")
    room.site_solar_factor *= m;
  else if (h.effect == "outdoor_sensor_bias")
    room.outdoor_sensor_bias_k += m;
  else
    return false;
  return true;
}

/// What the workflow must say that it does not know.
bool hide_outside(sim::RcRoom& room, const Hidden& h) {
  const double m = h.magnitude;
  if (h.effect == "fcu_dial")
    entry_at(room.fcu_setpoint_offset_k, h.place) += m;
  else if (h.effect == "odd_heater")
    entry_at(room.heater_w, h.place) = m;
  else if (h.effect == "escape_door")
    entry_at(room.door_ach, h.place) = m;
  else if (h.effect == "ahu_time_switch") {
    room.ahu_stop_from_h = 1.5;
    room.ahu_stop_to_h = 1.5 + m;
  } else if (h.effect == "hot_gas_bypass")
    room.chiller_min_load_kw = m * room.chiller_full_load_kw;
  else
    return false;
  return true;
}

/// The sensors that an operation of this kind reads and writes; nullptr: none.
std::vector<double>* shown_list(sim::Sensors& s, const std::string& field) {
  if (field == "room_temp") return &s.room_temp_degc;
  if (field == "fcu_temp") return &s.fcu_temp_degc;
  if (field == "power") return &s.power_kw;
  return nullptr;
}

double* shown_value(sim::Sensors& s, const std::string& field) {
  if (field == "mau_temp") return &s.mau_temp_degc;
  if (field == "supply_temp") return &s.supply_temp_degc;
  return nullptr;
}

}  // namespace

const std::vector<std::string>& outside_kinds() {
  static const std::vector<std::string> kinds{"fcu_dial", "odd_heater", "escape_door", "ahu_time_switch",
                                              "hot_gas_bypass"};
  return kinds;
}

double MeasuredOperator::setpoint_degc(CivilTime t, const std::vector<double>& shown_room_temp_degc) {
  double mean = 0;
  for (const double temp : shown_room_temp_degc) mean += temp / static_cast<double>(shown_room_temp_degc.size());
  integral_degc_ = std::clamp(integral_degc_ + 5.0 * 0.3 * (25.25 - mean), 20.0, 26.0);
  if (run_.feedback) return two_decimals(integral_degc_);
  const auto quarter = t.seconds / (6 * 3600);  // the schedule steps four times a day
  return two_decimals(20.5 + 4.0 * sim::draw_uniform(run_.commands(), draw_schedule, 0, quarter));
}

WrongSensors::WrongSensors(std::vector<sim::EffectChange> changes, CivilTime log_start)
    : changes_(std::move(changes)),
      log_start_(log_start),
      lagging_(changes_.size(), std::numeric_limits<double>::quiet_NaN()) {}

void WrongSensors::apply(sim::Sensors& sensors, CivilTime t) {
  const sim::Sensors right = sensors;
  const double days = static_cast<double>(t.seconds - log_start_.seconds) / static_cast<double>(seconds_per_day);
  for (std::size_t c = 0; c < changes_.size(); ++c) {
    const sim::EffectChange& change = changes_[c];
    for (const sim::EffectOp& op : change.at.effect->common) {
      if (op.on != sim::EffectOp::On::sensor) continue;
      const double m = op.offset + op.factor * change.magnitude;
      const bool placed = change.at.effect->place != sim::PlaceKind::floor;
      if (op.by == sim::By::exchange) {
        const auto [a, b] = sim::vav_pair(change.at.place, static_cast<int>(right.room_temp_degc.size()));
        const double of_a = right.room_temp_degc.at(static_cast<std::size_t>(a));
        const double of_b = right.room_temp_degc.at(static_cast<std::size_t>(b));
        entry_at(sensors.room_temp_degc, a) = two_decimals((1 - m) * of_a + m * of_b);
        entry_at(sensors.room_temp_degc, b) = two_decimals((1 - m) * of_b + m * of_a);
        continue;
      }
      std::vector<double*> shown;
      if (std::vector<double>* list = shown_list(sensors, op.field)) {
        for (int i = 0; i < std::ssize(*list); ++i) {
          if (!placed || change.at.place == i) shown.push_back(&entry_at(*list, i));
        }
      } else if (double* one = shown_value(sensors, op.field)) {
        shown.push_back(one);
      }
      for (double* x : shown) {
        switch (op.by) {
          case sim::By::add: *x += m; break;
          case sim::By::multiply: *x *= m; break;
          case sim::By::set: *x = m; break;
          case sim::By::drift: *x += m * days; break;
          case sim::By::jet: *x += m * (right.supply_temp_degc - *x); break;
          case sim::By::lag:
            if (!std::isfinite(lagging_[c])) lagging_[c] = *x;
            lagging_[c] += (m > 0 ? 1 - std::exp(-row_s / m) : 1) * (*x - lagging_[c]);
            *x = lagging_[c];
            break;
          default: break;
        }
        *x = two_decimals(*x);
      }
    }
  }
}

hal::LogRow measured_row(const sim::Sensors& shown, CivilTime t, double setpoint_degc, const MeasuredRun& run) {
  const auto count = [](const std::vector<double>& list) { return static_cast<int>(list.size()); };
  hal::LogRow row = hal::make_log_row({"", count(shown.vav_on), count(shown.fcu_on), count(shown.power_kw)});
  row.time = t;
  auto out = row.value.begin();
  for (const auto* list :
       {&shown.room_temp_degc, &shown.fcu_temp_degc, &shown.vav_on, &shown.fcu_on, &shown.power_kw}) {
    out = std::copy(list->begin(), list->end(), out);
  }
  for (const double x : {shown.mau_temp_degc, shown.outdoor_temp_degc, shown.rain}) *out++ = x;
  row.setpoint_degc = setpoint_degc;
  row.supply_temp_degc = shown.supply_temp_degc;
  for (std::size_t i = 0; i < row.value.size() && run.missing_share > 0; ++i) {
    if (sim::draw_uniform(run.commands(), draw_missing, i, t.seconds) < run.missing_share) {
      row.value[i] = std::numeric_limits<double>::quiet_NaN();
    }
  }
  return row;
}

const sim::Effect* find_effect(const std::vector<sim::Effect>& effects, const std::string& name) {
  const auto found = std::find_if(effects.begin(), effects.end(), [&name](const auto& e) { return e.name == name; });
  return found == effects.end() ? nullptr : &*found;
}

std::string id_of(const Hidden& hidden, const std::vector<sim::Effect>& effects) {
  if (const sim::Effect* effect = find_effect(effects, hidden.effect)) return sim::EffectAt{effect, hidden.place}.id();
  return hidden.place < 0 ? hidden.effect : hidden.effect + "@" + std::to_string(hidden.place + 1);
}

sim::RcRoom hide(sim::RcRoom room, const std::vector<Hidden>& hidden, const std::vector<sim::Effect>& effects) {
  for (const Hidden& h : hidden) {
    if (hide_directly(room, h) || hide_outside(room, h)) continue;
    const sim::Effect* effect = find_effect(effects, h.effect);
    if (effect == nullptr || effect->rc.empty()) throw std::invalid_argument("cannot hide " + h.effect);
    const sim::EffectChange change{{effect, h.place}, h.magnitude};
    room = sim::changed_room(std::move(room), std::span(&change, 1));
  }
  return room;
}

bool rc_can_hide(const sim::Effect& effect) {
  if (!effect.candidate || !effect.on_rc) return false;
  sim::RcRoom any = sim::make_room();
  return !effect.rc.empty() || hide_directly(any, {effect.name, 0, effect.probe[0]});
}

std::vector<hal::LogRow> measure(const sim::RcRoom& room, std::shared_ptr<const sim::Weather> weather,
                                 const MeasuredRun& run, const std::vector<Hidden>& hidden) {
  // All sensors of the room are its own fields but the lag of one, which it has for all of them only.
  static const sim::Effect sensor_lag = [] {
    sim::Effect lag;
    lag.place = sim::PlaceKind::vav;
    sim::EffectOp op;
    op.on = sim::EffectOp::On::sensor;
    op.field = "room_temp";
    op.by = sim::By::lag;
    lag.common = {op};
    return lag;
  }();
  std::vector<sim::EffectChange> lags;
  for (const Hidden& h : hidden) {
    if (h.effect == "room_sensor_lag") lags.push_back({{&sensor_lag, h.place}, h.magnitude});
  }
  const CivilTime begin{run.start.seconds - measured_lead_days * seconds_per_day};
  const CivilTime end{run.start.seconds + run.days * seconds_per_day};
  sim::RcPlant plant(room, std::move(weather), begin, run.seed);
  MeasuredOperator operated(run);
  WrongSensors wrong(std::move(lags), run.start);
  std::vector<hal::LogRow> rows;
  double setpoint = 23;
  while (plant.time() < end) {
    const CivilTime t = plant.time();
    sim::Sensors shown = plant.sensors();
    wrong.apply(shown, t);
    if (default_cycle.starts(t)) {
      const double usual = operated.setpoint_degc(t, shown.room_temp_degc);
      setpoint = run.tests ? run.tests->setpoint_degc(t, usual, setpoint) : usual;
      plant.set_setpoint(setpoint);
    }
    if (run.tests) {
      const sim::RecordedRow commands = run.tests->commands(t, room.vavs, room.fcus);
      plant.command(commands.vav_on, commands.fcu_on);
      shown.vav_on = plant.sensors().vav_on;  // a row shows what holds from its time on
      shown.fcu_on = plant.sensors().fcu_on;
    }
    if (!(t < run.start)) rows.push_back(measured_row(shown, t, setpoint, run));
    plant.advance_to({t.seconds + row_s});
  }
  return rows;
}

}  // namespace airside::tools::gap
