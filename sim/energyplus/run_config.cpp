#include "sim/energyplus/run_config.hpp"

#include <fstream>

#include "sim/json/json_file.hpp"

namespace airside::sim {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SwitchedFanCoil, fcu, from_s, to_s, on)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RoomLoopOptions, fcu_setpoint_degc, fcu_band_k, fcu_from_hour, fcu_to_hour, dampers,
                                   supply_lag_s, supply_bias_k, occupancy_scale, occupancy_shift_min, occupancy_noise,
                                   weekends, vav_off_per_day, sensor_noise_k, switched)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ModelNames, interior_zones, perimeter_zones, supply_setpoint_schedule,
                                   vav_on_schedule, vav_damper_schedule, fcu_on_schedule, interior_occupancy_schedule,
                                   perimeter_occupancy_schedule, supply_air_node, mau_outlet_node, powers)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(OwnNames, supply_setpoint_schedule, supply_air_node, mau_outlet_node, zones,
                                   terminals, fcu_zones, supply_fan, powers, occupancy)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(OwnParts, fcu_fans, people_schedules)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunConfig, engine_library, engine_folder, run_folder, model, weather, start_s, end_s,
                                   step_s, seed, setpoint_degc, rooms, names, own_control, own, own_parts)

void write_run_config(const RunConfig& config, const std::filesystem::path& file) {
  std::ofstream(file) << nlohmann::json(config).dump(1) << '\n';
}

RunConfig read_run_config(const std::filesystem::path& file) { return read_json(file).get<RunConfig>(); }

}  // namespace airside::sim
