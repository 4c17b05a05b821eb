#include "gap/twinhouse.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numeric>
#include <set>
#include <sstream>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools::gap {

namespace {

constexpr std::int64_t sample_s = 600;
constexpr double air_heat_j_m3k = 1.2 * 1006;
constexpr double usual_flow_m3_s = 120.0 / 3600;
constexpr double usual_neighbour_degc = 20, usual_supply_degc = 18;  // only their changes count
const sim::Location holzkirchen{"Holzkirchen", 47.874, 11.728, 1, 680};

/// Rooms of a zone with their floor areas, for a mean temperature.
struct RoomShare {
  const char* column;
  double m2;
};
const std::vector<std::vector<RoomShare>> zone_rooms{
    {{"living", 33.6}, {"corridor", 5.5}, {"bath", 6.9}, {"child", 11.2}},
    {{"kitchen", 7.4}, {"doorway", 5.8}, {"bedroom", 11.2}}};
const std::vector<std::vector<const char*>> zone_heaters{{"P_living", "P_bath", "P_child"},
                                                         {"P_kitchen", "P_kitchen_duct", "P_doorway", "P_bedroom"}};

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::stringstream text(line);
  for (std::string field; std::getline(text, field, ',');) fields.push_back(field);
  return fields;
}

std::shared_ptr<const sim::Weather> station_of(const HouseLog& log) {
  std::vector<sim::WeatherRecord> records;
  for (std::size_t i = 0; i < log.rows; ++i) {
    const CivilTime t{log.from.seconds + static_cast<std::int64_t>(i) * sample_s};
    sim::WeatherRecord r;
    r.outdoor_temp_degc = log.column.at("Tamb")[i];
    r.relative_humidity_pct = log.column.at("RH")[i];
    r.wind_speed_m_s = log.column.at("wind_ms")[i];
    r.global_horizontal_w_m2 = std::max(0.0, log.column.at("GHI")[i]);
    r.diffuse_horizontal_w_m2 = std::clamp(log.column.at("DHI")[i], 0.0, r.global_horizontal_w_m2);
    // Below 4 degrees the beam is a small difference over a small number.
    const double up = sim::sun_at(holzkirchen, {t.seconds + sample_s / 2}).up;
    if (up > 0.07) {
      r.direct_normal_w_m2 = std::min(1000.0, (r.global_horizontal_w_m2 - r.diffuse_horizontal_w_m2) / up);
    }
    records.push_back(r);
  }
  // A clock that runs behind asks for some hours after the end: those of the day before.
  for (std::int64_t i = 0; i < 6 * 3600 / sample_s; ++i) {
    records.push_back(records[records.size() - static_cast<std::size_t>(86400 / sample_s)]);
  }
  const auto first = sim::second_of_year(log.from) / sample_s;
  return std::make_shared<const sim::Weather>(holzkirchen, "Holzkirchen, house " + log.name, sample_s,
                                              static_cast<int>(first), std::move(records));
}

double zone_temp(const HouseLog& log, std::size_t zone, CivilTime t) {
  double sum = 0, area = 0;
  for (const RoomShare& room : zone_rooms[zone]) {
    sum += room.m2 * log.at(room.column, t);
    area += room.m2;
  }
  return sum / area;
}

/// Nodes of one zone. degC.
struct ZoneState {
  double air, mass, wall;
};

/// What a zone is made of, from the room's fields.
struct ZoneNumbers {
  double air_j_k, mass_j_k, wall_j_k, mass_w_k, wall_w_k, window_w_k, neighbour_w_k, leak_w_k_ach;
  std::array<double, sim::facades> glass_m2, facing;
  double area_m2;
};

ZoneNumbers numbers_of(const sim::RcRoom& room, std::size_t z) {
  ZoneNumbers n{};
  const double air = room.volume_m3[z] * air_heat_j_m3k;
  n.air_j_k = air * room.air_capacity_factor[z] * room.capacity_factor;
  n.mass_j_k = 1000 * room.mass_kj_k[z] * room.capacity_factor;
  n.wall_j_k = 1000 * room.wall_kj_k[z] * room.capacity_factor;
  n.mass_w_k = room.mass_ua_w_k[z];
  n.wall_w_k = 2 * room.wall_ua_w_k[z] * room.envelope_factor;
  n.glass_m2 = {room.window_north_m2[z], room.window_east_m2[z], room.window_south_m2[z], room.window_west_m2[z]};
  const double glass = std::accumulate(n.glass_m2.begin(), n.glass_m2.end(), 0.0);
  for (std::size_t f = 0; f < sim::facades; ++f) n.facing[f] = n.glass_m2[f] / glass;
  n.window_w_k = room.window_u_w_m2k * room.envelope_factor * glass;
  n.neighbour_w_k = room.neighbour_ua_w_k[z];
  n.leak_w_k_ach = air / 3600 * room.infiltration_share[z];
  n.area_m2 = room.floor_area_m2[z];
  return n;
}

/// Heat of equipment that an effect may add; an empty house has none.
double gain_w(const sim::RcRoom& room, std::size_t z, CivilTime t) {
  const double hour = t.second_of_day() / 3600.0;
  double w_m2 = room.gain_base_w_m2;
  if (hour >= 19 && hour < 22) w_m2 += room.gain_after_hours_w_m2;
  if (hour >= 12 && hour < 13) w_m2 += room.gain_lunch_w_m2;
  if (t.weekday() >= 5 && hour >= room.occupancy_start_h && hour < room.occupancy_end_h) w_m2 += room.gain_weekend_w_m2;
  return w_m2 * room.floor_area_m2[z] * room.gain_factor[z];
}

/// What acts on the house in one row.
struct Surroundings {
  std::array<double, sim::facades> sun_w_m2{};
  double outdoor_degc = 0, wind_m_s = 0, neighbour_degc = 0, supply_degc = 0, supply_w_k = 0;
};

}  // namespace

double HouseLog::at(const std::string& series, CivilTime t) const {
  const auto i =
      std::clamp<std::int64_t>((t.seconds - from.seconds) / sample_s, 0, static_cast<std::int64_t>(rows) - 1);
  return column.at(series)[static_cast<std::size_t>(i)];
}

std::filesystem::path find_twin_house() {
  namespace fs = std::filesystem;
  const char* named = std::getenv("AIRSIDE_TWINHOUSE");
  const fs::path folder =
      named != nullptr ? fs::path(named) : fs::path(AIRSIDE_SOURCE_DIR) / "../shared/data/twinhouse";
  return fs::exists(folder / "twinhouse_exp1_O5.csv") && fs::exists(folder / "twinhouse_exp1_N2.csv") ? folder
                                                                                                      : fs::path();
}

HouseLog read_house(const std::filesystem::path& folder, const std::string& name) {
  const std::filesystem::path path = folder / ("twinhouse_exp1_" + name + ".csv");
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) {
    throw hal::InputError(path.string(), "no readable file", "the measurements of house " + name,
                          "see the README there");
  }
  const std::vector<std::string> names = split(line);
  HouseLog log;
  log.name = name;
  std::vector<std::vector<double>*> columns;
  for (const std::string& column : names) columns.push_back(&log.column[column]);
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = split(line);
    const auto refuse = [&](const std::string& found) {
      throw hal::InputError(path.string() + ":" + std::to_string(log.rows + 2), found,
                            std::to_string(names.size()) + " fields, every 10 min", "see the README there");
    };
    if (fields.size() != names.size()) refuse(std::to_string(fields.size()) + " fields");
    const auto number = [&](std::size_t at, std::size_t count) { return std::stoi(fields[0].substr(at, count)); };
    const CivilTime midnight = sim::civil_midnight(number(0, 4), number(5, 2), number(8, 2));
    const CivilTime t{midnight.seconds + number(11, 2) * 3600 + number(14, 2) * 60};
    if (log.rows == 0) log.from = t;
    if (t.seconds != log.from.seconds + static_cast<std::int64_t>(log.rows) * sample_s) refuse(fields[0]);
    for (std::size_t i = 1; i < fields.size(); ++i) columns[i]->push_back(std::stod(fields[i]));
    ++log.rows;
  }
  return log;
}

Window house_window(const HouseLog& log, CivilTime from, CivilTime counted, CivilTime to) {
  Window window;
  window.recording.from = from;
  window.recording.station = station_of(log);
  for (CivilTime t = from; t < to; t.seconds += row_s) {
    const CivilTime middle{t.seconds + row_s / 2};
    sim::RecordedRow row;
    for (const auto& heaters : zone_heaters) {
      double w = 0;
      for (const char* heater : heaters) w += log.at(heater, middle);
      row.fcu_on.push_back(w / 1000);
    }
    row.fcu_on.push_back((log.at("attic_E", middle) + log.at("attic_W", middle)) / 2);
    row.fcu_on.push_back(log.at("cellar", middle));
    row.fcu_on.push_back(log.at("vSUAc_T", middle));
    row.vav_on = {log.at("vSUA_m3h", middle) / 120};
    row.outdoor_temp_degc = log.at("Tamb", middle);
    window.recording.rows.push_back(std::move(row));
  }
  const sim::Channels channels{house_zones, 0, 0};
  const Eigen::Index bins = std::ssize(window.recording.rows) / rows_per_bin;
  window.measured = Eigen::MatrixXd::Constant(bins, channels.count(), std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index b = 0; b < bins; ++b) {
    const CivilTime t{from.seconds + b * rows_per_bin * row_s};
    if (t < counted) continue;
    for (Eigen::Index z = 0; z < house_zones; ++z) {
      double sum = 0;
      for (std::int64_t part = 0; part < 3; ++part) {
        sum += zone_temp(log, static_cast<std::size_t>(z), {t.seconds + part * sample_s});
      }
      window.measured(b, z) = sum / 3;
    }
  }
  return window;
}

sim::ChannelTable TwinHouseEngine::simulate(const Changes& changes, const sim::Recording& recorded) const {
  const sim::RcRoom room = sim::changed_room(house_, changes);
  const sim::Recording recording = sim::changed_recording(recorded, changes);
  std::array<ZoneNumbers, house_zones> numbers{};
  for (std::size_t z = 0; z < house_zones; ++z) numbers[z] = numbers_of(room, z);
  const double mixing_w_k = room.mixing_interior_m3_s * air_heat_j_m3k;
  const double solar_factor[] = {room.solar_factor_north, room.solar_factor_east, room.solar_factor_south,
                                 room.solar_factor_west};
  std::array<ZoneState, house_zones> state{};
  // No zone's temperature is an input; where it starts is forgotten in the first days.
  state.fill({25, 25, 25});

  const auto surroundings_of = [&](std::size_t i) {
    const sim::RecordedRow& row = recording.rows[i];
    Surroundings s;
    const CivilTime middle{recording.time(i).seconds + row_s / 2};
    const sim::WeatherRecord weather = recording.station->at(middle);
    s.sun_w_m2 = sim::facade_irradiance_w_m2(weather, sim::sun_at(recording.station->location(), middle));
    for (std::size_t f = 0; f < sim::facades; ++f) s.sun_w_m2[f] *= solar_factor[f] * room.site_solar_factor;
    s.outdoor_degc = row.outdoor_temp_degc + room.site_temp_offset_k;
    s.wind_m_s = weather.wind_speed_m_s;
    const double* boundary = row.fcu_on.data() + house_zones;
    s.neighbour_degc =
        attic_share_ * boundary[0] + (1 - attic_share_) * boundary[1] + room.neighbour_temp_degc - usual_neighbour_degc;
    s.supply_degc = boundary[2] + room.duct_gain_k + room.mau_setpoint_degc - usual_supply_degc;
    s.supply_w_k = row.vav_on[0] * room.outdoor_air_m3_s * air_heat_j_m3k * (1 - room.duct_leak_share);
    return s;
  };
  const auto live = [&](std::size_t i, const Surroundings& s) {
    constexpr int steps = 4;
    constexpr double dt_s = static_cast<double>(row_s) / steps;
    const sim::RecordedRow& row = recording.rows[i];
    for (int step = 0; step < steps; ++step) {
      const double across = mixing_w_k * (state[1].air - state[0].air);
      for (std::size_t z = 0; z < house_zones; ++z) {
        const ZoneNumbers& n = numbers[z];
        ZoneState& at = state[z];
        const double ach = room.infiltration_ach + room.infiltration_wind_ach_s_m * s.wind_m_s +
                           room.infiltration_stack_ach_k * std::abs(s.outdoor_degc - at.air);
        double sun_w = 0, wall_sun = 0;
        for (std::size_t f = 0; f < sim::facades; ++f) {
          sun_w += n.glass_m2[f] * room.shgc * s.sun_w_m2[f];
          wall_sun += n.facing[f] * s.sun_w_m2[f];
        }
        const double mass_w = n.mass_w_k * (at.mass - at.air), wall_w = n.wall_w_k * (at.wall - at.air);
        const double skin_degc = s.outdoor_degc + room.wall_absorptance / room.wall_film_w_m2k * wall_sun;
        const double skin_w = n.wall_w_k * (skin_degc - at.wall);
        double air_w = mass_w + wall_w + (n.window_w_k + n.leak_w_k_ach * ach) * (s.outdoor_degc - at.air) +
                       n.neighbour_w_k * (s.neighbour_degc - at.air) + (z == 0 ? across : -across);
        if (z == 0) air_w += s.supply_w_k * (s.supply_degc - at.air);
        const double gain = gain_w(room, z, recording.time(i)) + 1000 * row.fcu_on[z];
        const double to_mass = room.solar_to_mass_share * sun_w + room.gain_radiant_share * gain;
        at.air += dt_s / n.air_j_k * (air_w + gain + sun_w - to_mass);
        at.mass += dt_s / n.mass_j_k * (to_mass - mass_w);
        at.wall += dt_s / n.wall_j_k * (skin_w - wall_w);
      }
    }
  };
  const auto day = static_cast<std::size_t>(rows_per_day);
  std::vector<Surroundings> around;
  around.reserve(recording.rows.size());
  for (std::size_t i = 0; i < recording.rows.size(); ++i) around.push_back(surroundings_of(i));
  constexpr int first_days = 10;  // lived through again and again: the slowest node takes some days
  for (int d = 0; d < first_days; ++d) {
    for (std::size_t i = 0; i < day; ++i) live(i, around[i]);
  }
  sim::ChannelTable table = sim::ChannelTable::Zero(std::ssize(recording.rows), channels().count());
  for (std::size_t i = 0; i < recording.rows.size(); ++i) {
    for (std::size_t z = 0; z < house_zones; ++z) {
      table(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(z)) = state[z].air;
    }
    live(i, around[i]);
  }
  return sim::changed_sensors(std::move(table), channels(), changes);
}

bool TwinHouseEngine::can(const sim::Effect& effect) const {
  // No boxes, fan coils, coils, people or rain sensor in this house.
  static const std::set<std::string> here{
      "clock_shift",         "duct_heat_gain",   "duct_leak",         "envelope_u",      "gain_after_hours",
      "gain_base",           "gain_lunch",       "gain_weekend",      "infiltration",    "infiltration_stack",
      "infiltration_wind",   "mau_setpoint",     "mixing_interior",   "neighbour_heat",  "outdoor_air_flow",
      "outdoor_sensor_bias", "room_sensor_bias", "room_sensor_drift", "room_sensor_lag", "solar_gain",
      "sun_differs",         "swapped_sensors",  "thermal_mass"};
  return here.contains(effect.name) || effect.file == "twin house";
}

sim::RcRoom usual_house() {
  sim::RcRoom room = sim::make_room(house_zones, 0, 1);
  room.name = "twin house";
  room.floor_area_m2 = {57.2, 24.4};
  room.volume_m3 = {149, 63};
  room.air_capacity_factor = {4, 4};
  room.mass_kj_k = {12000, 5000};
  room.mass_ua_w_k = {600, 260};
  room.wall_kj_k = {9000, 4500};
  room.wall_ua_w_k = {20, 10};
  room.wall_area_m2 = {60, 30};
  room.window_north_m2 = {0.1, 1.5};
  room.window_east_m2 = {1.5, 1};
  room.window_south_m2 = {6, 0.05};
  room.window_west_m2 = {2, 1};
  room.window_u_w_m2k = 1.2;
  room.shgc = 0.5;
  room.infiltration_share = {1, 1};
  room.infiltration_ach = 0.05;
  room.infiltration_wind_ach_s_m = 0.01;
  room.infiltration_stack_ach_k = 0.001;
  room.neighbour_ua_w_k = {35, 15};
  room.neighbour_temp_degc = usual_neighbour_degc;
  room.mau_setpoint_degc = usual_supply_degc;
  room.mixing_interior_m3_s = 0.03;
  room.gain_base_w_m2 = room.gain_occupied_w_m2 = 0;
  room.gain_factor = {1, 1};
  room.gain_radiant_share = 0.3;
  room.duct_gain_k = 0;
  room.duct_leak_share = 0;
  room.outdoor_air_m3_s = usual_flow_m3_s;
  room.wall_absorptance = 0.3;
  return room;
}

HouseFit fit_house(const Window& window, int jobs) {
  struct Knob {
    const char* field;
    int zone;  // -1: the house
    double sd;
    bool logarithmic = true;
  };
  const std::vector<Knob> knobs{{"air_capacity_factor", 0, .4},
                                {"air_capacity_factor", 1, .4},
                                {"mass_kj_k", 0, .5},
                                {"mass_kj_k", 1, .5},
                                {"mass_ua_w_k", 0, .5},
                                {"mass_ua_w_k", 1, .5},
                                {"wall_kj_k", 0, .5},
                                {"wall_kj_k", 1, .5},
                                {"wall_ua_w_k", 0, .4},
                                {"wall_ua_w_k", 1, .4},
                                {"neighbour_ua_w_k", 0, .4},
                                {"neighbour_ua_w_k", 1, .4},
                                {"window_south_m2", 0, .6},
                                {"window_west_m2", 0, .6},
                                {"window_east_m2", 0, .6},
                                {"window_north_m2", 1, .6},
                                {"window_west_m2", 1, .6},
                                {"window_east_m2", 1, .6},
                                {"window_u_w_m2k", -1, .3},
                                {"infiltration_ach", -1, .7},
                                {"infiltration_wind_ach_s_m", -1, .7},
                                {"mixing_interior_m3_s", -1, .7},
                                {"solar_to_mass_share", -1, .15, false},
                                {"gain_radiant_share", -1, .1, false},
                                {"wall_absorptance", -1, .15, false}};
  const sim::RcRoom usual = usual_house();
  std::vector<FitParameter> parameters;
  for (const Knob& knob : knobs) {
    const sim::RoomField& field = *sim::find_room_field(knob.field);
    const auto* scalar = std::get_if<sim::ScalarField>(&field.member);
    const double start = scalar != nullptr
                             ? usual.*(*scalar)
                             : (usual.*std::get<sim::ListField>(field.member))[static_cast<std::size_t>(knob.zone)];
    const std::string name =
        knob.zone < 0 ? knob.field : knob.field + (knob.zone == 0 ? std::string(" south") : " north");
    parameters.push_back({name, "", start, knob.sd, knob.logarithmic, field.lowest, field.highest});
  }
  parameters.push_back({"attic share", "", 0.5, 0.15, false, 0, 1});
  const auto engine_of = [&](const Eigen::VectorXd& values) {
    sim::RcRoom room = usual;
    for (std::size_t i = 0; i < knobs.size(); ++i) {
      const sim::RoomField& field = *sim::find_room_field(knobs[i].field);
      const double value = values(static_cast<Eigen::Index>(i));
      if (const auto* scalar = std::get_if<sim::ScalarField>(&field.member)) {
        room.*(*scalar) = value;
      } else {
        (room.*std::get<sim::ListField>(field.member))[static_cast<std::size_t>(knobs[i].zone)] = value;
      }
    }
    return TwinHouseEngine(std::move(room), values(values.size() - 1));
  };
  FitSettings settings;
  settings.jobs = jobs;
  settings.iterations = 12;
  const FitModel model = [&](const Eigen::VectorXd& values) {
    return engine_of(values).simulate({}, window.recording);
  };
  const ParameterFit fit = fit_parameters(parameters, model, window.measured, counted_bins(window.measured.rows()),
                                          {house_zones, 0, 0}, settings);
  Eigen::VectorXd values(fit.z.size());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    values(static_cast<Eigen::Index>(i)) = parameters[i].value(fit.z(static_cast<Eigen::Index>(i)));
  }
  return {engine_of(values), fit, parameters};
}

std::vector<sim::Effect> house_effects() {
  const auto parameter = [](const char* name, const char* field, double sd) {
    sim::Effect e;
    e.name = name;
    e.title = std::string(field) + " of zone {n}";
    e.unit = "1";
    e.place = sim::PlaceKind::zone;
    e.null_value = 1;
    e.low = 0.2;
    e.high = 5;
    e.probe = {0.8, 1.2};
    e.prior_sd = sd;
    e.candidate = false;
    sim::EffectOp op;
    op.on = sim::EffectOp::On::room;
    op.field = field;
    op.by = sim::By::multiply;
    e.rc = {op};
    e.file = "twin house";
    return e;
  };
  return {parameter("zone_air", "air_capacity_factor", 0.15), parameter("zone_mass", "mass_kj_k", 0.15),
          parameter("zone_mass_ua", "mass_ua_w_k", 0.15),     parameter("zone_wall", "wall_kj_k", 0.15),
          parameter("zone_wall_ua", "wall_ua_w_k", 0.15),     parameter("zone_neighbour", "neighbour_ua_w_k", 0.15)};
}

}  // namespace airside::tools::gap
