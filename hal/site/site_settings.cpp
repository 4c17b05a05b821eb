#include "hal/site/site_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "airside/presets.hpp"
#include "airside/topologies.hpp"
#include "hal/points/bacnet_row.hpp"
#include "hal/site/objective.hpp"
#include "hal/text/input_error.hpp"

namespace airside::hal {

namespace {

/// Between two values that a point can hold; 0 for a float, which holds any.
double step_of(const Point& p) { return p.type == PointType::float32 ? 0.0 : std::abs(p.scale); }

}  // namespace

SiteRules site_rules() {
  SiteRules rules;
  rules.holds = [](const std::string& topology) { return with_topology(topology.c_str(), [](auto) {}); };
  for_each_topology([&rules]<class T>(T) {
    if (T::exact) rules.topologies.emplace_back(T::name);
  });
  const ControllerSettings defaults = product_settings();
  for (const SettingEntry& e : setting_table) {
    const double value = e.real != nullptr ? defaults.*e.real : static_cast<double>(defaults.*e.whole);
    rules.settings.push_back({e.name, e.min, e.max, value});
  }
  for (const DemandSettingEntry& e : demand_setting_table) {
    const double value = e.real != nullptr ? DemandSettings{}.*e.real : static_cast<double>(DemandSettings{}.*e.whole);
    rules.settings.push_back({e.name, e.min, e.max, value});
  }
  return rules;
}

ControllerSettings controller_settings(const SiteFile& site) {
  ControllerSettings s = settings_of(site.preset);
  s.objective = site.objective;
  s.cycle_min = site.cycle_min;
  s.shape = parse_shape(site.topology.c_str());
  s.target_degc = site.room_temp_degc;
  s.held = site.held;
  s.work_start_h = site.work_start_s / 3600.0;
  s.work_end_h = site.work_end_s / 3600.0;
  s.weekday_only = site.weekday_only ? 1 : 0;  // the room head's day types follow it, unless overridden
  s.fan_start_h = site.fan_start_s / 3600.0;
  s.fan_end_h = site.fan_end_s / 3600.0;
  s.fan_weekday_only = site.fan_weekday_only ? 1 : 0;
  s.daylight_saving = site.daylight_saving;
  s.utc_offset_h = site.utc_offset_h;
  s.action_min_degc = s.limit_min_degc = site.setpoint_min_degc;
  s.action_max_degc = s.limit_max_degc = site.setpoint_max_degc;
  s.action_step_k = site.setpoint_step_k;
  s.limit_change_k = site.setpoint_max_change_k;
  s.round_k = site.setpoint_round_k;
  s.outside_jump = site.setpoint_outside_jump ? 1 : 0;
  s.expert_work_degc = site.expert_work_degc;
  s.expert_off_degc = site.expert_off_degc;
  for (const auto& [name, value] : site.overrides) {
    for (const SettingEntry& e : setting_table) {
      if (name != e.name) continue;
      if (e.real != nullptr) {
        s.*e.real = value;
      } else {
        s.*e.whole = static_cast<int>(value);
      }
    }
  }
  for (const auto& [name, value] : site.overrides) {
    for (const DemandSettingEntry& e : demand_setting_table) {
      if (name != e.name) continue;
      if (e.real != nullptr) s.demand.*e.real = value;
      if (e.whole != nullptr) s.demand.*e.whole = static_cast<int>(value);
    }
  }
  if (!settings_valid(s)) {
    throw InputError(site.path + ": [setpoint], [controller.override]",
                     fmt::format("setpoints {} to {} degC in steps of {} K, working hours {} to {}", s.action_min_degc,
                                 s.action_max_degc, s.action_step_k, s.work_start_h, s.work_end_h),
                     fmt::format("at most {} candidate setpoints, work_start before work_end", max_candidates),
                     "widen step_k or narrow the range");
  }
  return s;
}

ControllerSettings controller_settings(const SiteFile& site, const PointMap& points) {
  ControllerSettings s = controller_settings(site);
  const Point* setpoint = points.find("setpoint");
  if (setpoint == nullptr) return s;
  s.register_step_k = step_of(*setpoint);
  s.register_offset_degc = setpoint->offset;
  const Point* shown = setpoint->readback == "self" ? setpoint : points.find(setpoint->readback);
  if (shown != nullptr) s.readback_step_k = step_of(*shown);
  return s;
}

namespace {

/// A register that holds too few setpoints to control by.
void refuse_coarse(const SiteFile& site, const PointMap& points, const Point& setpoint) {
  const ControllerSettings s = controller_settings(site, points);
  if (!(s.register_step_k > 0)) return;
  const double first = std::ceil((s.limit_min_degc - s.register_offset_degc) / s.register_step_k - 1e-9);
  const double last = std::floor((s.limit_max_degc - s.register_offset_degc) / s.register_step_k + 1e-9);
  if (last - first >= 1 && s.register_step_k <= s.limit_change_k + 1e-9) return;
  throw InputError(
      fmt::format("{}:{}: scale", points.file(), setpoint.line),
      fmt::format("a register of whole steps of {} K", s.register_step_k),
      fmt::format("at least two values from {} to {} degC, and steps of at most {} K a cycle, as {} has it",
                  s.limit_min_degc, s.limit_max_degc, s.limit_change_k, site.path),
      "correct scale and offset; where the AHU is really that coarse, widen [setpoint]");
}

/// A setpoint that the controller or the schedule may ask for and that its own row calls impossible: it would be
/// written, and read back as no reading.
void refuse_outside_row(const SiteFile& site, const Point& setpoint, const std::string& file) {
  const auto refuse = [&](const char* keys, double value) {
    if (value >= setpoint.min && value <= setpoint.max) return;
    throw InputError(fmt::format("{}: {}", site.path, keys), fmt::format("{} degC", value),
                     fmt::format("{} to {} degC, the limits of setpoint on line {} of {}", setpoint.min, setpoint.max,
                                 setpoint.line, file),
                     "correct it; or min and max of that row, where the AHU takes such a setpoint");
  };
  refuse("[setpoint] min_degc", site.setpoint_min_degc);
  refuse("[setpoint] max_degc", site.setpoint_max_degc);
  refuse("[expert] work_degc", site.expert_work_degc);
  refuse("[expert] off_degc", site.expert_off_degc);
}

/// A simulated AHU's clock that the map does not have.
void refuse_missing_clock(const SiteFile& site, const PointMap& points) {
  if (site.clock != ClockSource::plant) return;
  for (const char* name : {"clock_s", "clock_advance_s"}) {
    if (points.find(name) != nullptr) continue;
    throw InputError(site.path + ": [clock] source",
                     fmt::format("\"plant\", and no point {} in {}", name, points.file()),
                     "the points clock_s and clock_advance_s of airside serve, or source = \"system\"",
                     "beside a real AHU write source = \"system\"");
  }
}

}  // namespace

void refuse_contradiction(const SiteFile& site, const PointMap& points) {
  refuse_objective(site.objective, points, parse_shape(site.topology.c_str()).vavs,
                   site.path + ": [controller] objective");
  if (site.modbus) refuse_bacnet_contradiction(site, points);
  refuse_missing_clock(site, points);
  const Point* setpoint = points.find("setpoint");
  if (setpoint == nullptr) return;
  refuse_outside_row(site, *setpoint, points.file());
  refuse_coarse(site, points, *setpoint);
  if (setpoint->write_policy != WritePolicy::refresh) return;
  const auto budget = site.overrides.find("writes_per_day");
  if (budget == site.overrides.end() || budget->second <= 0) return;
  throw InputError(fmt::format("{}:{}: write_policy", points.file(), setpoint->line), "refresh",
                   fmt::format("on-change, since {} has writes_per_day = {}", site.path, budget->second),
                   "write on change, or set no budget: a register that must be refreshed is none that wears out");
}

std::string warning_of(const PointMap& points) {
  const Point* beat = points.find("heartbeat");
  if (beat == nullptr || !beat->writable()) {
    return "no writable heartbeat: where this box is gone the AHU keeps the last setpoint";
  }
  const auto device_of = [](const Point& p) { return p.object.substr(0, p.object.find(':')); };
  const Point* setpoint = points.find("setpoint");
  const bool is_own = beat->object == held_by_gateway;
  if (beat->object.empty() || setpoint == nullptr || (!is_own && device_of(*beat) == device_of(*setpoint))) return {};
  return fmt::format(
      "line {}: the heartbeat is {}: where this box loses power the AHU keeps the last setpoint; name a commandable "
      "object of the AHU whose program takes over when the value stands still (docs/bacnet.md, Priorities and "
      "hand-back)",
      beat->line,
      is_own ? "the gateway's own"
             : fmt::format("of device {}, the setpoint of device {}", device_of(*beat), device_of(*setpoint)));
}

LinkSettings link_settings(const ModbusSection& modbus, double backoff_first_s, double backoff_max_s) {
  LinkSettings settings;
  if (modbus.transport == ModbusTransport::tcp) {
    settings.address = TcpAddress{modbus.host, modbus.port, modbus.host_place};
  } else {
    settings.address = SerialAddress{modbus.device, modbus.baud, modbus.parity};
  }
  settings.unit = modbus.unit_id;
  settings.exchange_deadline_s = modbus.deadline_s;
  settings.backoff_first_s = backoff_first_s;
  settings.backoff_max_s = std::max(backoff_max_s, backoff_first_s);
  return settings;
}

}  // namespace airside::hal
