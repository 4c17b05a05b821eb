#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "sim/energyplus/rooms.hpp"
#include "sim/energyplus/worker/model_driver.hpp"

namespace airside::sim {
namespace {

constexpr const char* node_flow_variable = "System Node Standard Density Volume Flow Rate";
constexpr const char* damper_variable = "Zone Air Terminal VAV Damper Position";
constexpr const char* cooling_setpoint_variable = "Zone Thermostat Cooling Setpoint Temperature";
constexpr const char* heating_setpoint_variable = "Zone Thermostat Heating Setpoint Temperature";
constexpr const char* fan_power_variable = "Fan Electricity Rate";
constexpr const char* schedule_variable = "Schedule Value";

constexpr double fan_runs_w = 1;            ///< a fan that takes more runs
constexpr double air_flows_m3s = 1e-4;      ///< a supply that moves more has a running fan
constexpr double damper_open = 1e-3;        ///< more lets air through
constexpr double people_are_there = 0.1;    ///< occupied: more of the people than at night, when somebody cleans
constexpr double no_thermostat_degc = 0.1;  ///< the engine shows 0 where a zone has no such setpoint

double flag(bool holds) { return holds ? 1.0 : 0.0; }

class OwnDriver final : public ModelDriver {
 public:
  explicit OwnDriver(const RunConfig& config)
      : config_(config),
        names_(config.own),
        sensors_(config.rooms, 0, 0, config.seed, config.setpoint_degc),
        lagged_setpoint_degc_(config.setpoint_degc),
        room_temps_(names_.zones.size(), 24.0),
        fcu_temps_(names_.fcu_zones.size(), 24.0) {}

  void request_variables(const EngineNames& engine) override;
  void find_handles(const EngineNames& engine) override;

  void warm_up(const EngineNames& engine, CivilTime, double setpoint_degc) override {
    engine.act(handles_.supply_setpoint, setpoint_degc);
  }

  void step(const EngineNames& engine, CivilTime, double setpoint_degc) override {
    const double lag_s = config_.rooms.supply_lag_s;
    const double keep = lag_s > 0 ? std::exp(-config_.step_s / lag_s) : 0.0;
    lagged_setpoint_degc_ = setpoint_degc + (lagged_setpoint_degc_ - setpoint_degc) * keep;
    engine.act(handles_.supply_setpoint, lagged_setpoint_degc_);
  }

  void read_truth(const EngineNames& engine) override {
    for (std::size_t i = 0; i < room_temps_.size(); ++i) room_temps_[i] = engine.value(handles_.zone_temps[i]);
    for (std::size_t i = 0; i < fcu_temps_.size(); ++i) fcu_temps_[i] = engine.value(handles_.fcu_temps[i]);
  }

  void sense(const EngineNames& engine, WorkerReply& shown) override;

  double mean_room_temp_degc() const override {
    return std::accumulate(room_temps_.begin(), room_temps_.end(), 0.0) / static_cast<double>(room_temps_.size());
  }

 private:
  struct Handles {
    std::vector<int> zone_temps, cooling_setpoints, heating_setpoints, dampers, fcu_temps, fcu_fans, people, powers;
    int supply_setpoint = no_handle, supply_temp = no_handle, supply_flow = no_handle, supply_fan = no_handle;
    int mau_temp = no_handle, outdoor_temp = no_handle;
  };

  static double setpoint_degc(const EngineNames& engine, int handle);
  double zone_setpoint_degc(const EngineNames& engine, std::size_t zone) const;

  const RunConfig& config_;
  const OwnNames& names_;
  RoomLoops sensors_;  ///< for their noise alone
  double lagged_setpoint_degc_;
  Handles handles_;
  std::vector<double> room_temps_, fcu_temps_;
};

void OwnDriver::request_variables(const EngineNames& engine) {
  const auto each = [&engine](const char* variable, const std::vector<std::string>& keys) {
    for (const auto& key : keys) {
      if (!key.empty()) engine.request(variable, key);
    }
  };
  for (const char* variable : {zone_temp_variable, cooling_setpoint_variable, heating_setpoint_variable})
    each(variable, names_.zones);
  each(zone_temp_variable, names_.fcu_zones);
  each(damper_variable, names_.terminals);
  each(fan_power_variable, config_.own_parts.fcu_fans);
  each(fan_power_variable, {names_.supply_fan});
  each(schedule_variable, config_.own_parts.people_schedules);
  each(node_temp_variable, {names_.supply_air_node, names_.mau_outlet_node});
  each(node_flow_variable, {names_.supply_air_node});
  each(outdoor_temp_variable, {"Environment"});
}

void OwnDriver::find_handles(const EngineNames& engine) {
  const auto each = [&engine](const char* variable, const std::vector<std::string>& keys) {
    std::vector<int> handles;
    for (const auto& key : keys) handles.push_back(key.empty() ? no_handle : engine.variable(variable, key));
    return handles;
  };
  handles_.zone_temps = each(zone_temp_variable, names_.zones);
  for (const auto& zone : names_.zones) {
    handles_.cooling_setpoints.push_back(engine.variable_if_any(cooling_setpoint_variable, zone));
    handles_.heating_setpoints.push_back(engine.variable_if_any(heating_setpoint_variable, zone));
  }
  handles_.dampers = each(damper_variable, names_.terminals);
  handles_.fcu_temps = each(zone_temp_variable, names_.fcu_zones);
  handles_.fcu_fans = each(fan_power_variable, config_.own_parts.fcu_fans);
  handles_.people = each(schedule_variable, config_.own_parts.people_schedules);
  handles_.supply_fan = each(fan_power_variable, {names_.supply_fan}).front();
  handles_.supply_temp = engine.variable(node_temp_variable, names_.supply_air_node);
  handles_.supply_flow = engine.variable(node_flow_variable, names_.supply_air_node);
  handles_.mau_temp = each(node_temp_variable, {names_.mau_outlet_node}).front();
  handles_.outdoor_temp = engine.variable(outdoor_temp_variable, "Environment");
  for (const auto& meter : names_.powers) handles_.powers.push_back(meter.empty() ? no_handle : engine.meter(meter));
  handles_.supply_setpoint = engine.schedule(names_.supply_setpoint_schedule);
}

double OwnDriver::setpoint_degc(const EngineNames& engine, int handle) {
  const double degc = handle == no_handle ? 0 : engine.value(handle);
  return degc > no_thermostat_degc ? std::round(degc * 100.0) / 100.0 : not_offered;
}

double OwnDriver::zone_setpoint_degc(const EngineNames& engine, std::size_t zone) const {
  const double cooling = setpoint_degc(engine, handles_.cooling_setpoints[zone]);
  return std::isfinite(cooling) ? cooling : setpoint_degc(engine, handles_.heating_setpoints[zone]);
}

void OwnDriver::sense(const EngineNames& engine, WorkerReply& shown) {
  const auto temp = [&](int handle) {
    return handle == no_handle ? not_offered : sensors_.sensed_degc(engine.value(handle));
  };
  shown.vavs = static_cast<int>(room_temps_.size());
  shown.fcus = static_cast<int>(fcu_temps_.size());
  shown.zone_setpoints = shown.vavs;
  shown.dampers = static_cast<int>(handles_.dampers.size());
  shown.supply_flow_m3s = engine.value(handles_.supply_flow);
  const bool flows = shown.supply_flow_m3s > air_flows_m3s;
  const bool fan_known = handles_.supply_fan != no_handle;
  const bool runs = fan_known ? engine.value(handles_.supply_fan) > fan_runs_w : flows;
  shown.ahu_on = fan_known ? flag(runs) : not_offered;
  for (std::size_t i = 0; i < room_temps_.size(); ++i) {
    shown.true_room_temp_degc[i] = room_temps_[i];
    shown.room_temp_degc[i] = sensors_.sensed_degc(room_temps_[i]);
    shown.zone_setpoint_degc[i] = zone_setpoint_degc(engine, i);
    shown.heating_setpoint_degc[i] = setpoint_degc(engine, handles_.heating_setpoints[i]);
    shown.vav_on[i] = flag(runs);
  }
  for (std::size_t i = 0; i < handles_.dampers.size(); ++i) {
    const int handle = handles_.dampers[i];
    shown.damper[i] = handle == no_handle ? not_offered : std::clamp(engine.value(handle), 0.0, 1.0);
    if (handle != no_handle) shown.vav_on[i] = flag(runs && shown.damper[i] > damper_open);
  }
  for (std::size_t i = 0; i < fcu_temps_.size(); ++i) {
    shown.fcu_temp_degc[i] = sensors_.sensed_degc(fcu_temps_[i]);
    shown.fcu_on[i] = flag(engine.value(handles_.fcu_fans[i]) > fan_runs_w);
  }
  shown.powers = static_cast<int>(handles_.powers.size());
  for (std::size_t i = 0; i < handles_.powers.size(); ++i) {
    const int meter = handles_.powers[i];
    shown.power_kw[i] = meter == no_handle ? not_offered : engine.meter_j(meter) / config_.step_s / 1000.0;
  }
  if (!handles_.people.empty()) {
    const bool any =
        std::ranges::any_of(handles_.people, [&](int schedule) { return engine.value(schedule) > people_are_there; });
    shown.occupied = flag(any);
  }
  shown.mau_temp_degc = temp(handles_.mau_temp);
  shown.outdoor_temp_degc = temp(handles_.outdoor_temp);
  shown.supply_temp_degc = temp(handles_.supply_temp);
}

}  // namespace

std::unique_ptr<ModelDriver> own_driver(const RunConfig& config) { return std::make_unique<OwnDriver>(config); }

}  // namespace airside::sim
