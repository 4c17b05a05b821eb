#pragma once
// What one EnergyPlus run is made of: model and patches, weather, dates, and the room loops that live outside the
// engine. The defaults are the twin in July.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "hal/text/input_error.hpp"
#include "sim/energyplus/adopted/own_model.hpp"

namespace airside::sim {

/// The names by which a model offers its zones and actuated schedules; those of twin.epJSON by default.
/// `#` in a schedule's name stands for the 1-based place of the VAV, FCU or zone.
struct ModelNames {
  std::vector<std::string> interior_zones = {"Interior 1", "Interior 2", "Interior 3", "Interior 4", "Interior 5"};
  std::vector<std::string> perimeter_zones = {"Perimeter 1", "Perimeter 2", "Perimeter 3", "Perimeter 4",
                                              "Perimeter 5"};
  std::string supply_setpoint_schedule = "Supply Air Setpoint";
  std::string vav_on_schedule = "VAV # On";
  std::string vav_damper_schedule = "VAV # Damper";
  std::string fcu_on_schedule = "FCU # On";
  std::string interior_occupancy_schedule = "Interior # Occupancy";
  std::string perimeter_occupancy_schedule = "Perimeter # Occupancy";
  std::string supply_air_node = "AHU Supply Fan Outlet";
  std::string mau_outlet_node = "AHU Outside Air Inlet";
  std::vector<std::string> powers = {"Electricity:HVAC", "Electricity:Plant"};  ///< meters, one a power sensor
};

/// A fan coil that somebody switches, whatever its thermostat wants.
struct SwitchedFanCoil {
  int fcu = 0;  ///< 0-based
  std::int64_t from_s = 0, to_s = 0;
  bool on = false;
};

/// The control loops and disturbances of the rooms, stepped beside the engine.
struct RoomLoopOptions {
  double fcu_setpoint_degc = 26.0;  ///< fan coils start above setpoint + band, stop below setpoint - band
  double fcu_band_k = 0.5;
  int fcu_from_hour = 7, fcu_to_hour = 20;
  std::vector<double> dampers = {0.52, 0.58, 0.55, 0.60, 0.54};  ///< fraction of each VAV's maximum flow
  double supply_lag_s = 90;                                      ///< first-order lag of the AHU behind its setpoint
  double supply_bias_k = 0;        ///< how much warmer the supply is than its own sensor tells the AHU
  double occupancy_scale = 1.0;    ///< on the whole profile
  double occupancy_shift_min = 0;  ///< later (+) or earlier (-), every day
  double occupancy_noise = 1.0;    ///< day-to-day and minute-to-minute variation; 0 repeats one day
  bool weekends = false;           ///< Saturday and Sunday nearly empty
  double vav_off_per_day = 0.1;    ///< chance that a VAV is off for 36-90 min on a day
  double sensor_noise_k = 0.02;    ///< standard deviation; readings are then rounded to 0.01
  std::vector<SwitchedFanCoil> switched;
};

/// Changes to the weather file, written into a copy for the run.
struct WeatherChange {
  double dry_bulb_offset_k = 0;  ///< dew point moves along
  double solar_factor = 1;
  double storms_per_week = 0;  ///< afternoon storms: rain, a third of the sun, 3 K cooler
  bool any() const { return dry_bulb_offset_k != 0 || solar_factor != 1 || storms_per_week > 0; }
};

/// A merge patch on the model, with the name that complaints give it.
struct ModelPatch {
  std::string name;
  nlohmann::json content;
};

struct EnergyPlusOptions {
  std::string name = "twin";        ///< for descriptions
  std::filesystem::path model;      ///< empty: twin.epJSON of find_models()
  std::vector<ModelPatch> patches;  ///< applied in order
  std::filesystem::path weather;    ///< empty: default_weather()
  WeatherChange weather_change;
  int start_month = 7, start_day = 1;  ///< of civil year 2021
  int days = 31;                       ///< 1 .. 364
  int step_min = 3;                    ///< zone time step: 3 or 6
  std::uint64_t seed = 1;
  double initial_setpoint_degc = 25.0;  ///< in warm-up and until set_setpoint()
  bool lint = true;                     ///< check the model against the engine's schema before the run
  RoomLoopOptions rooms;
  ModelNames names;
  /// The model's own thermostats and terminals run, and of `rooms` only the supply's lag and the sensors' noise count;
  /// without it the loops of `rooms` command the schedules of `names`.
  std::optional<OwnNames> own;
};

/// Midnight at the start of a day of 2021.
/// Errors: hal::InputError for a date that 2021 has not.
CivilTime start_of_day_2021(int month, int day);

/// Reads a model file.
/// Errors: hal::InputError as read_json(); for an IDF, how to convert it.
nlohmann::json read_model(const std::filesystem::path& file);

/// Every zone, schedule and node of `names` that a model lacks: the run would end over it, after its start. What other
/// objects make of the model at run time is not seen. `place` names the model in complaints.
std::vector<hal::InputError> missing_names(const nlohmann::json& model, const ModelNames& names,
                                           const std::string& place);

/// The composed model text's parts: model, patches, time step and run period of the options.
/// Errors: hal::InputError for options out of range, unreadable files, misspelt fields.
nlohmann::json compose_model(const EnergyPlusOptions& options, const std::filesystem::path& schema);

/// Options of one of the method's rooms: "twin", "301", "401", "402", "701", "702", or one of them with "_real"
/// for the counterpart that stands for the built room (perturbed envelope, mass, gains, flows, weather, habits); or
/// "tuning_0" .. "tuning_199", rooms that are drawn by their number and never appear in a table.
/// Errors: hal::InputError listing the names.
EnergyPlusOptions energyplus_room(const std::string& name);

/// Every name that energyplus_room() takes, but those of drawn rooms.
std::vector<std::string> energyplus_room_names();

}  // namespace airside::sim
