#include <numeric>
#include <string>
#include <vector>

#include "sim/energyplus/rooms.hpp"
#include "sim/energyplus/worker/model_driver.hpp"

namespace airside::sim {
namespace {

std::string placed(std::string pattern, int place) {
  const auto mark = pattern.find('#');
  if (mark != std::string::npos) pattern.replace(mark, 1, std::to_string(place));
  return pattern;
}

class ExternalDriver final : public ModelDriver {
 public:
  explicit ExternalDriver(const RunConfig& config)
      : config_(config),
        vavs_(static_cast<int>(config.names.interior_zones.size())),
        fcus_(static_cast<int>(config.names.perimeter_zones.size())),
        loops_(config.rooms, vavs_, fcus_, config.seed, config.setpoint_degc),
        room_temps_(static_cast<std::size_t>(vavs_), 24.0),
        fcu_temps_(static_cast<std::size_t>(fcus_), 25.0) {}

  void request_variables(const EngineNames& engine) override {
    const ModelNames& names = config_.names;
    for (const auto& zone : names.interior_zones) engine.request(zone_temp_variable, zone);
    for (const auto& zone : names.perimeter_zones) engine.request(zone_temp_variable, zone);
    for (const auto& node : {names.supply_air_node, names.mau_outlet_node}) engine.request(node_temp_variable, node);
    engine.request(outdoor_temp_variable, "Environment");
  }

  void find_handles(const EngineNames& engine) override;

  void warm_up(const EngineNames& engine, CivilTime t, double setpoint_degc) override {
    act(engine, loops_.warm_up(t, setpoint_degc, fcu_temps_));
  }

  void step(const EngineNames& engine, CivilTime t, double setpoint_degc) override {
    act(engine, loops_.step(t, config_.step_s, setpoint_degc, fcu_temps_));
  }

  void read_truth(const EngineNames& engine) override {
    const auto temp = [&](std::size_t i) { return engine.value(handles_.zone_temps[i]); };
    for (std::size_t i = 0; i < room_temps_.size(); ++i) room_temps_[i] = temp(i);
    for (std::size_t i = 0; i < fcu_temps_.size(); ++i) fcu_temps_[i] = temp(room_temps_.size() + i);
  }

  void sense(const EngineNames& engine, WorkerReply& shown) override;

  double mean_room_temp_degc() const override {
    return std::accumulate(room_temps_.begin(), room_temps_.end(), 0.0) / vavs_;
  }

 private:
  struct Handles {
    std::vector<int> zone_temps, vav_on, dampers, fcu_on, occupancy, powers;
    int supply_setpoint = no_handle, supply_temp = no_handle, mau_temp = no_handle, outdoor_temp = no_handle;
  };

  void act(const EngineNames& engine, const RoomCommands& commands) {
    engine.act(handles_.supply_setpoint, commands.supply_setpoint_degc);
    const auto each = [&engine](const std::vector<int>& handles, const std::vector<double>& values) {
      for (std::size_t i = 0; i < handles.size(); ++i) engine.act(handles[i], values[i]);
    };
    each(handles_.vav_on, commands.vav_on);
    each(handles_.fcu_on, commands.fcu_on);
    each(handles_.dampers, config_.rooms.dampers);
    each(handles_.occupancy, commands.occupancy);
  }

  const RunConfig& config_;
  int vavs_, fcus_;
  RoomLoops loops_;
  Handles handles_;
  std::vector<double> room_temps_, fcu_temps_;
};

void ExternalDriver::find_handles(const EngineNames& engine) {
  const ModelNames& names = config_.names;
  for (const auto& zone : names.interior_zones)
    handles_.zone_temps.push_back(engine.variable(zone_temp_variable, zone));
  for (const auto& zone : names.perimeter_zones)
    handles_.zone_temps.push_back(engine.variable(zone_temp_variable, zone));
  handles_.supply_temp = engine.variable(node_temp_variable, names.supply_air_node);
  handles_.mau_temp = engine.variable(node_temp_variable, names.mau_outlet_node);
  handles_.outdoor_temp = engine.variable(outdoor_temp_variable, "Environment");
  for (const auto& meter : names.powers) handles_.powers.push_back(engine.meter(meter));
  handles_.supply_setpoint = engine.schedule(names.supply_setpoint_schedule);
  for (int i = 1; i <= vavs_; ++i) {
    handles_.vav_on.push_back(engine.schedule(placed(names.vav_on_schedule, i)));
    handles_.dampers.push_back(engine.schedule(placed(names.vav_damper_schedule, i)));
    handles_.occupancy.push_back(engine.schedule(placed(names.interior_occupancy_schedule, i)));
  }
  for (int i = 1; i <= fcus_; ++i) {
    handles_.fcu_on.push_back(engine.schedule(placed(names.fcu_on_schedule, i)));
    handles_.occupancy.push_back(engine.schedule(placed(names.perimeter_occupancy_schedule, i)));
  }
}

void ExternalDriver::sense(const EngineNames& engine, WorkerReply& shown) {
  const auto temp = [&](int handle) { return loops_.sensed_degc(engine.value(handle)); };
  shown.vavs = vavs_;
  shown.fcus = fcus_;
  for (std::size_t i = 0; i < room_temps_.size(); ++i) {
    shown.true_room_temp_degc[i] = room_temps_[i];
    shown.room_temp_degc[i] = loops_.sensed_degc(room_temps_[i]);
    shown.vav_on[i] = loops_.commands().vav_on[i];
  }
  for (std::size_t i = 0; i < fcu_temps_.size(); ++i) {
    shown.fcu_temp_degc[i] = loops_.sensed_degc(fcu_temps_[i]);
    shown.fcu_on[i] = loops_.commands().fcu_on[i];
  }
  shown.powers = static_cast<int>(handles_.powers.size());
  for (std::size_t i = 0; i < handles_.powers.size(); ++i)
    shown.power_kw[i] = engine.meter_j(handles_.powers[i]) / config_.step_s / 1000.0;
  shown.mau_temp_degc = temp(handles_.mau_temp);
  shown.outdoor_temp_degc = temp(handles_.outdoor_temp);
  shown.supply_temp_degc = loops_.sensed_degc(engine.value(handles_.supply_temp) - config_.rooms.supply_bias_k);
}

}  // namespace

std::unique_ptr<ModelDriver> external_driver(const RunConfig& config) {
  return std::make_unique<ExternalDriver>(config);
}

}  // namespace airside::sim
