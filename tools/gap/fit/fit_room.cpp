#include "tools/gap/fit/fit_room.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "hal/text/input_error.hpp"
#include "sim/rc/rc_replay.hpp"
#include "tools/gap/inference/reference_fit.hpp"
#include "tools/gap/model/engine.hpp"

namespace airside::tools::gap {

namespace {

const sim::RoomField& room_field(const std::string& name) { return *sim::find_room_field(name); }

std::vector<double> knob_entries(const sim::RcRoom& room, const RoomKnob& knob) {
  const sim::RoomField& field = room_field(knob.field);
  if (const auto* scalar = std::get_if<sim::ScalarField>(&field.member)) return {room.*(*scalar)};
  const auto& list = room.*std::get<sim::ListField>(field.member);
  return {list.begin() + knob.first, list.begin() + knob.first + knob.count};
}

double mean_entry(const std::vector<double>& list) {
  double sum = 0;
  for (const double x : list) sum += x / static_cast<double>(list.size());
  return sum;
}

/// "kj_k" of "mass_kj_k" is for people "kJ/K"; what has no unit is a factor.
std::string unit_in(const std::string& name) {
  static const std::pair<const char*, const char*> units[] = {
      {"_kj_k", "kJ/K"},   {"_ua_w_k", "W/K"}, {"_w_m2", "W/m2"},  {"_m3_s", "m3/s"}, {"_ach_s_m", "s/h/m"},
      {"_ach_k", "1/h/K"}, {"_ach", "1/h"},    {"_degc", "degC"},  {"_kw", "kW"},     {"_w_per_gkg_m3s", "W s/l"},
      {"_per_k", "1/K"},   {"_drop_k", "K"},   {"_offset_k", "K"}, {"_gain_k", "K"},  {"_bias_k", "K"},
      {"_lag_s", "s"},     {"_h", "h"}};
  for (const auto& [ending, unit] : units) {
    if (name.ends_with(ending)) return unit;
  }
  return "1";
}

class KnobList {
 public:
  explicit KnobList(const sim::RcRoom& room) : room_(room) {}

  void scale(const char* field, const char* text, double sd) { add({field, text, 0, 1, true, sd}); }
  void shift(const char* field, const char* text, double sd) { add({field, text, 0, 1, false, sd}); }
  /// One knob for the core's zones, one for the perimeter's.
  void scale_classes(const char* field, const std::string& text, double sd) {
    add({field, text + (room_.fcus > 0 ? ", core" : ""), 0, room_.vavs, true, sd});
    if (room_.fcus > 0) add({field, text + ", perimeter", room_.vavs, room_.fcus, true, sd});
  }
  void each(const char* field, const std::string& text, int count, bool scaled, double sd) {
    for (int i = 0; i < count; ++i) add({field, fmt::format("{} {}", text, i + 1), i, 1, scaled, sd});
  }
  std::vector<RoomKnob> knobs;

 private:
  void add(RoomKnob knob) {
    const auto list = knob_entries(room_, knob);
    // What is not there cannot be scaled.
    if (knob.scaled && std::any_of(list.begin(), list.end(), [](double x) { return !(x > 0); })) return;
    knobs.push_back(std::move(knob));
  }
  const sim::RcRoom& room_;
};

double rms_of(const Eigen::MatrixXd& x, Eigen::Index first, Eigen::Index count, Eigen::Index column) {
  double sum = 0;
  int n = 0;
  for (Eigen::Index t = first; t < first + count; ++t) {
    if (!std::isfinite(x(t, column))) continue;
    sum += x(t, column) * x(t, column);
    ++n;
  }
  return n > 0 ? std::sqrt(sum / n) : std::numeric_limits<double>::quiet_NaN();
}

double sd_about_mean(const Eigen::MatrixXd& x, Eigen::Index first, Eigen::Index count, Eigen::Index column) {
  double sum = 0;
  int n = 0;
  for (Eigen::Index t = first; t < first + count; ++t) {
    if (!std::isfinite(x(t, column))) continue;
    sum += x(t, column);
    ++n;
  }
  if (n == 0) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::MatrixXd about = x.array() - sum / n;
  return rms_of(about, first, count, column);
}

/// Standard deviation of x_t - a x_{t-1} - b x_{t-2}, a and b fitted to the same stretch.
double one_step_error(const Eigen::MatrixXd& x, Eigen::Index first, Eigen::Index count, Eigen::Index column) {
  Eigen::Matrix2d a = 1e-9 * Eigen::Matrix2d::Identity();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  const auto each = [&](auto&& f) {
    for (Eigen::Index t = first + 2; t < first + count; ++t) {
      const Eigen::Vector2d past(x(t - 1, column), x(t - 2, column));
      if (past.allFinite() && std::isfinite(x(t, column))) f(past, x(t, column));
    }
  };
  each([&](const Eigen::Vector2d& past, double now) {
    a += past * past.transpose();
    b += past * now;
  });
  const Eigen::Vector2d phi = a.ldlt().solve(b);
  double sum = 0;
  int n = 0;
  each([&](const Eigen::Vector2d& past, double now) {
    sum += std::pow(now - phi.dot(past), 2);
    ++n;
  });
  return n > 0 ? std::sqrt(sum / n) : std::numeric_limits<double>::quiet_NaN();
}

/// Share of each fitted day in which each fan coil ran.  Shape: days x FCUs.
Eigen::MatrixXd daily_duty(const Eigen::MatrixXd& table, const sim::Channels& channels, Eigen::Index first_day,
                           Eigen::Index days) {
  Eigen::MatrixXd duty(days, channels.fcus);
  for (Eigen::Index d = 0; d < days; ++d) {
    for (Eigen::Index f = 0; f < channels.fcus; ++f) {
      const auto block = table.col(channels.fcu_duty() + f).segment((first_day + d) * bins_per_day, bins_per_day);
      const auto present = block.array().isFinite();
      duty(d, f) = present.count() * 2 < bins_per_day
                       ? std::numeric_limits<double>::quiet_NaN()
                       : present.select(block.array(), 0).sum() / static_cast<double>(present.count());
    }
  }
  return duty;
}

constexpr double dial_prior_sd_k = 1;

/// Each thermostat's dial from its days' duties.
///   o += (s e / v + (o_0 - o) / p^2) / (s^2 n / v + 1 / p^2), e sum of errors, s slope, v their variance, n days
std::vector<FittedParameter> fit_dials(sim::RcRoom& room, const Window& window, Eigen::Index first_day,
                                       Eigen::Index days, int& runs, int jobs) {
  const sim::Channels channels{room.vavs, room.fcus, room.powers};
  const Eigen::MatrixXd measured = daily_duty(window.measured, channels, first_day, days);
  const auto n = static_cast<std::size_t>(room.fcus);
  const std::vector<double> start = room.fcu_setpoint_offset_k;
  std::vector<double> sd(n, dial_prior_sd_k);
  constexpr double probe_k = 0.3;
  for (int iteration = 0; iteration < 5; ++iteration) {
    std::vector<Eigen::MatrixXd> duty(3);
    std::vector<sim::RcRoom> rooms(3, room);
    for (double& dial : rooms[1].fcu_setpoint_offset_k) dial += probe_k;
    for (double& dial : rooms[2].fcu_setpoint_offset_k) dial -= probe_k;
    std::vector<Task> tasks(3);
    for (Task& task : tasks) task.recording = &window.recording;
    for (std::size_t i = 0; i < 3; ++i) {
      const RcEngine engine(rooms[i]);
      duty[i] = daily_duty(binned(simulate_all(engine, {tasks[i]}, jobs).front(), channels), channels, first_day, days);
    }
    runs += 6;
    for (std::size_t f = 0; f < n; ++f) {
      const auto c = static_cast<Eigen::Index>(f);
      double slope = 0, error = 0, square = 0;
      int count = 0;
      for (Eigen::Index d = 0; d < days; ++d) {
        const double e = measured(d, c) - duty[0](d, c);
        if (!std::isfinite(e)) continue;
        slope += (duty[1](d, c) - duty[2](d, c)) / (2 * probe_k);
        error += e;
        square += e * e;
        ++count;
      }
      if (count < 3) continue;
      slope /= count;
      const double mean = error / count;
      const double variance = std::max(1e-4, square / count - mean * mean) + 1e-4;
      const double prior = 1 / (dial_prior_sd_k * dial_prior_sd_k);
      const double curvature = slope * slope * count / variance + prior;
      double& dial = room.fcu_setpoint_offset_k[f];
      const double step = (slope * error / variance + prior * (start[f] - dial)) / curvature;
      dial = std::clamp(dial + std::clamp(step, -1.0, 1.0), start[f] - 4, start[f] + 4);
      sd[f] = 1 / std::sqrt(curvature);
    }
  }
  std::vector<FittedParameter> fitted;
  for (std::size_t f = 0; f < n; ++f) {
    FittedParameter p;
    p.knob = {"fcu_setpoint_offset_k", fmt::format("dial of fan coil {}", f + 1), static_cast<int>(f), 1, false,
              dial_prior_sd_k};
    p.prior = {p.knob.text, "K", start[f], dial_prior_sd_k, false, start[f] - 4, start[f] + 4};
    p.estimate = room.fcu_setpoint_offset_k[f];
    p.sd = sd[f];
    p.learned = 1 - std::pow(sd[f] / dial_prior_sd_k, 2);
    fitted.push_back(p);
  }
  return fitted;
}

}  // namespace

std::vector<RoomKnob> room_knobs(const sim::RcRoom& start) {
  KnobList list(start);
  list.scale_classes("air_capacity_factor", "capacity of air and light things", 0.35);
  list.scale_classes("mass_kj_k", "mass of furniture and slab", 0.35);
  list.scale_classes("mass_ua_w_k", "air to mass", 0.35);
  if (start.fcus > 0) {
    list.knobs.push_back({"wall_kj_k", "outside wall, perimeter", start.vavs, start.fcus, true, 0.4});
  } else {
    list.scale_classes("wall_kj_k", "outside wall", 0.4);
  }
  list.scale("envelope_factor", "conductance of the envelope", 0.25);
  list.shift("neighbour_temp_degc", "space next door", 1.0);
  list.scale("infiltration_ach", "infiltration", 0.4);
  list.scale("infiltration_wind_ach_s_m", "infiltration by wind", 0.5);
  list.scale("infiltration_stack_ach_k", "infiltration by stack", 0.5);
  if (start.vavs > 1) list.scale("mixing_interior_m3_s", "mixing in the core", 0.3);
  if (start.fcus > 1) list.scale("mixing_perimeter_m3_s", "mixing in the perimeter", 0.3);
  if (start.fcus > 0) list.scale("mixing_across_m3_s", "mixing across", 0.3);
  const auto has = RcEngine(start).has_facade();
  constexpr const char* names[] = {"north", "east", "south", "west"};
  for (std::size_t f = 0; f < has.size(); ++f) {
    if (!has[f]) continue;
    list.scale(fmt::format("solar_factor_{}", names[f]).c_str(), fmt::format("sun, {} facade", names[f]).c_str(), 0.3);
  }
  list.shift("solar_to_mass_share", "sun that goes to the mass", 0.12);
  list.shift("wall_absorptance", "sun that the wall takes", 0.1);
  list.scale("rain_wall_drop_k", "rain on the wall", 0.4);
  list.scale("gain_base_w_m2", "base gain", 0.25);
  list.scale("gain_occupied_w_m2", "occupied gain", 0.25);
  list.shift("gain_radiant_share", "radiant share of gains", 0.1);
  list.shift("occupancy_shift_h", "people later by", 0.5);
  list.scale("occupancy_ramp_h", "time in which people come", 0.3);
  list.shift("occupancy_lunch_dip", "people away at lunch", 0.12);
  list.each("gain_factor", "gains of zone", start.zones(), true, 0.15);
  list.each("vav_flow_calibration", "flow of box", start.vavs, true, 0.25);
  list.scale("supply_lag_s", "lag of the supply air", 0.3);
  list.shift("supply_sensor_offset_k", "offset of the supply sensor", 0.5);
  list.scale("duct_gain_k", "heat gain of the duct", 0.5);
  list.scale("coil_capacity_kw", "AHU coil", 0.15);
  list.scale("coil_latent_w_per_gkg_m3s", "latent load of the AHU coil", 0.3);
  list.scale("outdoor_air_m3_s", "outdoor air", 0.2);
  list.shift("mau_room_share", "outdoor air straight to the rooms", 0.1);
  list.shift("mau_setpoint_degc", "make-up air temperature", 0.7);
  list.scale("mau_capacity_kw", "make-up air coil", 0.2);
  list.each("fcu_capacity_factor", "cooling of fan coil", start.fcus, true, 0.2);
  list.scale("ahu_fan_kw", "supply fan", 0.2);
  list.scale("mau_fan_kw", "make-up air fan", 0.3);
  if (start.fcus > 0) list.scale("fcu_fan_kw", "fan of a fan coil", 0.3);
  list.scale("pump_kw", "pump", 0.3);
  list.scale("chiller_cop", "COP of the chiller at 30 degC", 0.15);
  list.shift("chiller_cop_per_k", "COP per K outdoors", 0.02);
  list.scale("chiller_min_load_kw", "least load of the chiller", 0.3);
  list.scale("room_sensor_lag_s", "lag of the sensors", 0.5);
  list.each("room_sensor_bias_k", "sensor bias of room", start.vavs, false, 0.15);
  list.each("fcu_sensor_bias_k", "sensor bias of fan coil", start.fcus, false, 0.15);
  return std::move(list.knobs);
}

FitParameter parameter_of(const RoomKnob& knob, const sim::RcRoom& start) {
  const sim::RoomField& field = room_field(knob.field);
  const auto list = knob_entries(start, knob);
  const double mean = mean_entry(list);
  FitParameter p{knob.text, unit_in(knob.field), mean, knob.prior_sd, knob.scaled, field.lowest, field.highest};
  const auto [least, most] = std::minmax_element(list.begin(), list.end());
  // All entries must stay within the field's range.
  p.low = knob.scaled ? mean * field.lowest / *least : mean + field.lowest - *least;
  p.high = knob.scaled ? mean * field.highest / *most : mean + field.highest - *most;
  return p;
}

sim::RcRoom turned(sim::RcRoom room, const std::vector<RoomKnob>& knobs, const Eigen::VectorXd& values) {
  for (std::size_t i = 0; i < knobs.size(); ++i) {
    const RoomKnob& knob = knobs[i];
    const sim::RoomField& field = room_field(knob.field);
    const double mean = mean_entry(knob_entries(room, knob)), value = values(static_cast<Eigen::Index>(i));
    const auto set = [&](double& x) {
      x = std::clamp(knob.scaled ? x * value / mean : x + value - mean, field.lowest, field.highest);
    };
    if (const auto* scalar = std::get_if<sim::ScalarField>(&field.member)) {
      set(room.*(*scalar));
    } else {
      auto& list = room.*std::get<sim::ListField>(field.member);
      std::for_each(list.begin() + knob.first, list.begin() + knob.first + knob.count, set);
    }
  }
  return room;
}

double value_in(const sim::RcRoom& room, const RoomKnob& knob, const sim::RcRoom& start) {
  const auto was = knob_entries(start, knob), is = knob_entries(room, knob);
  double change = 0;
  for (std::size_t i = 0; i < was.size(); ++i) change += knob.scaled ? std::log(is[i] / was[i]) : is[i] - was[i];
  change /= static_cast<double>(was.size());
  return knob.scaled ? mean_entry(was) * std::exp(change) : mean_entry(was) + change;
}

std::pair<double, double> FittedParameter::interval(double k) const {
  if (!prior.logarithmic) return {estimate - k * sd, estimate + k * sd};
  const double factor = std::exp(k * sd / estimate);
  return {estimate / factor, estimate * factor};
}

RoomFit fit_room(const sim::RcRoom& start, const Window& window, const std::string& place,
                 const RoomFitSettings& settings) {
  const sim::Channels channels{start.vavs, start.fcus, start.powers};
  const Eigen::Index bins = window.measured.rows(), days = bins / bins_per_day;
  const Eigen::Index locked =
      settings.locked_days >= 0 ? settings.locked_days : std::lround(0.3 * static_cast<double>(days));
  const Eigen::Index fitted = days - locked;
  if (fitted < fewest_fit_days) {
    throw hal::InputError(
        place, fmt::format("{} whole days, of which {} are locked away to check the room", days, locked),
        fmt::format("at least {} days to fit", fewest_fit_days), "log for longer; two to four weeks tell most");
  }
  std::vector<bool> kept = counted_bins(bins);
  std::fill(kept.begin() + fitted * bins_per_day, kept.end(), false);
  // Duties have no useful derivative; they come second.
  Eigen::MatrixXd smooth = window.measured;
  smooth.rightCols(channels.fcus).setConstant(std::numeric_limits<double>::quiet_NaN());

  const std::vector<RoomKnob> knobs = room_knobs(start);
  std::vector<FitParameter> parameters;
  for (const RoomKnob& knob : knobs) parameters.push_back(parameter_of(knob, start));
  const FitModel model = [&](const Eigen::VectorXd& values) {
    return sim::replay_rc(turned(start, knobs, values), window.recording, false, false);
  };
  FitSettings fit_settings;
  fit_settings.rounds = 3;
  fit_settings.plain_rounds = 1;
  fit_settings.iterations = 4;
  fit_settings.jobs = settings.jobs;
  fit_settings.progress = [&](double share) {
    if (settings.progress) settings.progress(0.97 * share);
  };
  const ParameterFit fit = fit_parameters(parameters, model, smooth, kept, channels, fit_settings);

  RoomFit out;
  out.fitted_days = static_cast<int>(fitted);
  out.locked_days = static_cast<int>(locked);
  out.inflation = fit.inflation;
  out.runs = fit.runs;
  Eigen::VectorXd values(fit.z.size());
  for (std::size_t i = 0; i < knobs.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    values(k) = parameters[i].value(fit.z(k));
    out.parameters.push_back({knobs[i], parameters[i], values(k), fit.sd(parameters[i], k), fit.learned(k)});
  }
  out.room = turned(start, knobs, values);
  out.room.name = start.name + "-fitted";
  if (channels.fcus > 0) {
    const auto dials = fit_dials(out.room, window, 1, fitted - 1, out.runs, settings.jobs);
    out.parameters.insert(out.parameters.end(), dials.begin(), dials.end());
  }
  sim::check_room(out.room, "fitted room");
  if (settings.progress) settings.progress(1);

  const auto residual_of = [&](const sim::RcRoom& room) -> Eigen::MatrixXd {
    return window.measured - binned(sim::replay_rc(room, window.recording, channels.fcus > 0), channels);
  };
  const Eigen::MatrixXd before = residual_of(start), after = residual_of(out.room);
  const Eigen::Index first = bins_per_day, count = (fitted - 1) * bins_per_day, lock = fitted * bins_per_day;
  double square_before = 0, square_after = 0;
  for (int c = 0; c < channels.count(); ++c) {
    ChannelFit row;
    row.name = channels.name(c);
    row.unit = channels.unit(c);
    row.start_sd = sd_about_mean(before, first, count, c);
    row.fitted_sd = sd_about_mean(after, first, count, c);
    row.one_step_sd = one_step_error(after, first, count, c);
    row.locked_start = rms_of(before, lock, bins - lock, c);
    row.locked_rmse = rms_of(after, lock, bins - lock, c);
    if (c < channels.rooms) {
      square_before += row.locked_start * row.locked_start / channels.rooms;
      square_after += row.locked_rmse * row.locked_rmse / channels.rooms;
    }
    out.channels.push_back(row);
  }
  out.room_temp_start_k = std::sqrt(square_before);
  out.room_temp_k = std::sqrt(square_after);
  return out;
}

std::string room_file_text(const sim::RcRoom& room, const std::string& about) {
  const sim::RcRoom base = sim::make_room(room.vavs, room.fcus, room.powers);
  nlohmann::ordered_json j = {
      {"base", "rc"}, {"about", about}, {"vavs", room.vavs}, {"fcus", room.fcus}, {"powers", room.powers}};
  for (const sim::RoomField& field : sim::room_fields()) {
    const std::string name(field.name);
    if (const auto* scalar = std::get_if<sim::ScalarField>(&field.member)) {
      if (room.*(*scalar) != base.*(*scalar)) j[name] = room.*(*scalar);
    } else {
      const auto member = std::get<sim::ListField>(field.member);
      if (room.*member != base.*member) j[name] = room.*member;
    }
  }
  return j.dump(1) + "\n";
}

}  // namespace airside::tools::gap
