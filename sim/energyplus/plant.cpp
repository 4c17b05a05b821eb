#include "sim/energyplus/plant.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/process.hpp"
#include "sim/energyplus/weather.hpp"

namespace airside::sim {
namespace {

/// Throws the first name that the model lacks, with the number of the others.
void refuse_missing_names(const nlohmann::json& model, const OwnNames& names, const std::string& place) {
  const std::vector<hal::InputError> missing = missing_own_names(model, names, place);
  if (missing.empty()) return;
  const hal::InputError& first = missing.front();
  const std::string others =
      missing.size() > 1 ? "; " + std::to_string(missing.size() - 1) + " more names are missing" : "";
  throw hal::InputError(first.place(), first.found(), first.expected(), first.remedy() + others);
}

}  // namespace

EnergyPlusPlant::EnergyPlusPlant(const EnergyPlusOptions& options)
    : options_(options),
      time_(start_of_day_2021(options.start_month, options.start_day)),
      end_{time_.seconds + options.days * 86400LL},
      setpoint_degc_(options.initial_setpoint_degc) {
  const EnergyPlusInstall install = find_energyplus();
  if (options_.model.empty()) options_.model = find_models() / "twin.epJSON";
  if (options_.weather.empty()) options_.weather = default_weather(install);
  const EpwFile weather =
      read_epw_file(options_.weather, {.whole_year = false, .from = CivilTime{time_.seconds - lead_s}, .to = end_});
  const nlohmann::json model = compose_model(options_, install.schema);

  folder_ = std::make_unique<RunFolder>();
  RunConfig config;
  config.engine_library = install.library.string();
  config.engine_folder = install.folder.string();
  config.run_folder = folder_->path().string();
  config.model = (folder_->path() / "in.epJSON").string();
  config.weather = options_.weather.string();
  config.start_s = time_.seconds;
  config.end_s = end_.seconds;
  config.step_s = step_s();
  config.seed = options_.seed;
  config.setpoint_degc = setpoint_degc_;
  config.rooms = options_.rooms;
  config.names = options_.names;
  if (options_.own) {
    refuse_missing_names(model, *options_.own, options_.model.string());
    config.own_control = true;
    config.own = *options_.own;
    config.own_parts = own_parts(model, config.own);
  }
  std::ofstream(config.model) << model.dump(1) << '\n';
  if (options_.weather_change.any()) {
    config.weather = (folder_->path() / "changed.epw").string();
    write_epw(changed_epw(weather, options_.weather_change, options_.seed), config.weather);
  }
  process_ = std::make_unique<EnergyPlusProcess>(config, options_.name);
  take(process_->receive());
}

EnergyPlusPlant::~EnergyPlusPlant() = default;

void EnergyPlusPlant::check_time(CivilTime t) const {
  const std::int64_t ahead_s = t.seconds - time_.seconds;
  if (ahead_s >= 0 && ahead_s % step_s() == 0 && t <= end_) return;
  throw hal::InputError("EnergyPlus run of " + options_.name,
                        "a request for " + std::to_string(ahead_s) + " s from now, " +
                            std::to_string(end_.seconds - time_.seconds) + " s before the run's end",
                        "a multiple of " + std::to_string(step_s()) + " s within the run",
                        t > end_ ? "give the run more days" : "advance in whole time steps");
}

void EnergyPlusPlant::advance_to(CivilTime t) {
  check_time(t);
  if (t == time_) return;
  WorkerRequest request;
  request.until_s = t.seconds;
  request.setpoint_degc = setpoint_degc_;
  take(process_->exchange(request));
}

void EnergyPlusPlant::set_setpoint(double setpoint_degc) {
  if (!std::isfinite(setpoint_degc) || setpoint_degc < 5 || setpoint_degc > 40) {
    throw hal::InputError("EnergyPlus run of " + options_.name, "the setpoint " + std::to_string(setpoint_degc),
                          "a supply-air temperature of 5 to 40 degC", "check the controller");
  }
  setpoint_degc_ = setpoint_degc;
  sensors_.setpoint_degc = setpoint_degc;
}

void EnergyPlusPlant::take(const WorkerReply& reply) {
  const auto rooms = static_cast<std::size_t>(reply.vavs), fcus = static_cast<std::size_t>(reply.fcus);
  const auto copy = [](const auto& from, std::size_t n, std::vector<double>& to) {
    to.assign(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(n));
  };
  time_.seconds = reply.time_s;
  copy(reply.room_temp_degc, rooms, sensors_.room_temp_degc);
  copy(reply.true_room_temp_degc, rooms, true_room_temps_degc_);
  copy(reply.vav_on, rooms, sensors_.vav_on);
  copy(reply.fcu_temp_degc, fcus, sensors_.fcu_temp_degc);
  copy(reply.fcu_on, fcus, sensors_.fcu_on);
  copy(reply.power_kw, static_cast<std::size_t>(reply.powers), sensors_.power_kw);
  copy(reply.damper, static_cast<std::size_t>(reply.dampers), sensors_.damper);
  copy(reply.zone_setpoint_degc, static_cast<std::size_t>(reply.zone_setpoints), sensors_.zone_setpoint_degc);
  copy(reply.heating_setpoint_degc, static_cast<std::size_t>(reply.zone_setpoints), sensors_.heating_setpoint_degc);
  sensors_.occupied = reply.occupied;
  sensors_.supply_flow_m3s = reply.supply_flow_m3s;
  sensors_.ahu_on = reply.ahu_on;
  sensors_.mau_temp_degc = reply.mau_temp_degc;
  sensors_.outdoor_temp_degc = reply.outdoor_temp_degc;
  sensors_.rain = reply.rain;
  sensors_.supply_temp_degc = reply.supply_temp_degc;
  sensors_.setpoint_degc = reply.setpoint_degc;
}

double EnergyPlusPlant::true_mean_room_temp_degc() const {
  return std::accumulate(true_room_temps_degc_.begin(), true_room_temps_degc_.end(), 0.0) /
         static_cast<double>(true_room_temps_degc_.size());
}

double EnergyPlusPlant::branch_mean_room_temp_degc(double setpoint_degc, CivilTime until) {
  check_time(until);
  if (until == time_) return true_mean_room_temp_degc();
  WorkerRequest request;
  request.kind = RequestKind::branch;
  request.until_s = until.seconds;
  request.setpoint_degc = setpoint_degc;
  return process_->exchange(request).branch_mean_degc;
}

std::string EnergyPlusPlant::description() const {
  std::string text = "EnergyPlus 25.2, " + options_.name + " (" + options_.model.filename().string();
  for (const auto& patch : options_.patches) text += " + " + patch.name;
  text += options_.own ? "), its own controls, weather " : "), weather ";
  text += options_.weather.filename().string();
  if (options_.weather_change.any()) text += " (changed)";
  return text + ", " + std::to_string(options_.step_min) + "-min steps, seed " + std::to_string(options_.seed);
}

int EnergyPlusPlant::worker_pid() const { return process_->pid(); }

double full_forecast_setpoint(EnergyPlusPlant& plant, double target_degc, double low_degc, double high_degc,
                              int ahead_s) {
  const CivilTime until{std::min(plant.time().seconds + ahead_s, plant.end().seconds)};
  const auto error = [&](double setpoint) { return plant.branch_mean_room_temp_degc(setpoint, until) - target_degc; };
  // Secant from the present setpoint: the rooms answer it almost linearly, with jumps where a fan coil switches.
  double gain = 0.5;
  double setpoint = std::clamp(plant.sensors().setpoint_degc, low_degc, high_degc);
  double last_setpoint = setpoint, last_error = 0, best = setpoint, best_error = 1e9;
  for (int branches = 0; branches < 7; ++branches) {
    const double e = error(setpoint);
    if (std::abs(e) < best_error) {
      best_error = std::abs(e);
      best = setpoint;
    }
    if (best_error < 0.001) break;
    if (setpoint != last_setpoint) gain = std::clamp((e - last_error) / (setpoint - last_setpoint), 0.2, 1.5);
    last_setpoint = setpoint;
    last_error = e;
    setpoint = std::clamp(setpoint - e / gain, low_degc, high_degc);
    if (setpoint == last_setpoint) break;  // at a limit
  }
  return best;
}

}  // namespace airside::sim
