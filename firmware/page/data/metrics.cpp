#include "firmware/page/data/metrics.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "airside/supervision/mode_table.hpp"
#include "hal/system/version.hpp"

namespace airside::page {
namespace {

using nlohmann::json;

/// The daemon writes every 6 min.
constexpr double old_after_s = 900;

struct Plain {
  const char* key;   ///< of status.json
  const char* name;  ///< behind `airside_`
  const char* help;
};
constexpr auto gauges = std::to_array<Plain>({
    {"target_degc", "room_target_celsius", "Room temperature that is held."},
    {"held_degc", "held_temperature_celsius", "The value of the rooms that is held at the target."},
    {"room_mean_degc", "room_mean_temperature_celsius", "Mean of the room temperatures."},
    {"setpoint_degc", "supply_setpoint_celsius", "Supply air temperature setpoint that the AHU has."},
    {"network_setpoint_degc", "network_setpoint_celsius", "Setpoint that the network proposes."},
    {"head_setpoint_degc", "head_setpoint_celsius", "Setpoint that the room head proposes."},
    {"expert_setpoint_degc", "schedule_setpoint_celsius", "Setpoint that the schedule would have."},
    {"g36_setpoint_degc", "guideline36_setpoint_celsius", "Setpoint that Guideline 36 would have."},
    {"expected_held_degc", "expected_held_temperature_celsius", "The held value as forecast for the end of the cycle."},
    {"confidence", "forecast_confidence_ratio", "Confidence in the own forecast, 0 to 1."},
    {"mean_error_k", "working_day_distance_kelvin", "Mean distance from the target, last working day."},
    {"schedule_mean_error_k", "schedule_working_day_distance_kelvin",
     "The same as it would have been under the schedule."},
    {"warmest_zone_above_setpoint_k", "warmest_zone_above_setpoint_kelvin",
     "Most that a zone is above its own setpoint; of the objective band."},
    {"most_open_damper", "most_open_damper_ratio", "Position of the most open damper, 0 to 1; of the objective band."},
    {"replay_transitions", "replay_transitions", "Transitions that are remembered."},
});
constexpr auto counters = std::to_array<Plain>({
    {"cycles", "decisions_total", "Decisions since the state's beginning."},
    {"rejected_updates", "rejected_updates_total", "Updates of the weights that the acceptance gate refused."},
    {"generation", "state_generations_total", "Generations of the saved state."},
    {"link_timeouts", "link_timeouts_total", "Exchanges with the AHU without an answer, since the daemon's start."},
    {"link_bad_frames", "link_bad_frames_total", "Damaged answers of the AHU."},
    {"link_wrong_ids", "link_foreign_answers_total", "Answers to another question."},
    {"link_exceptions", "link_exceptions_total", "Requests that the AHU refused."},
    {"setpoint_writes", "setpoint_writes_total", "Setpoints written since the daemon's start."},
});

void head(std::string& out, const char* name, const char* type, const char* help) {
  out += fmt::format("# HELP airside_{} {}\n# TYPE airside_{} {}\n", name, help, name, type);
}

std::string escaped(const std::string& label) {
  std::string out;
  for (const char c : label) {
    if (c == '\\' || c == '"') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

void plain(std::string& out, const json& status, const Plain& metric, const char* type) {
  const double value = number_of(status, metric.key);
  if (!std::isfinite(value)) return;
  head(out, metric.name, type, metric.help);
  out += fmt::format("airside_{} {}\n", metric.name, value);
}

void modes(std::string& out, const json& status) {
  const std::string mode = text_in(status, "state");
  head(out, "mode", "gauge", "Control mode: 1 for the one that holds.");
  for (int m = 0; m < 4; ++m) {
    const char* name = text_of(static_cast<ControlMode>(m));
    out += fmt::format("airside_mode{{mode=\"{}\"}} {}\n", name, mode == name ? 1 : 0);
  }
  const std::string reason = text_in(status, "reason");
  head(out, "reason", "gauge", "Why this mode: 1 for the reason that holds.");
  for (const ModeRequest& row : mode_table) {
    out += fmt::format("airside_reason{{reason=\"{}\"}} {}\n", row.name, reason == row.name ? 1 : 0);
  }
  head(out, "alarm", "gauge", "Whether an alarm of this reason is active.");
  const json alarms = status.value("alarms", json::array());
  for (const ModeRequest& row : mode_table) {
    if (row.reason == Reason::none) continue;
    bool active = false;
    for (const json& alarm : alarms) active = active || text_in(alarm, "reason") == row.name;
    out += fmt::format("airside_alarm{{reason=\"{}\"}} {}\n", row.name, active ? 1 : 0);
  }
}

void rooms(std::string& out, const json& status) {
  const auto list = status.find("room_temp_degc");
  if (list == status.end() || !list->is_array() || list->empty()) return;
  head(out, "room_temperature_celsius", "gauge", "Temperature of a room.");
  int number = 0;
  for (const json& value : *list) {
    ++number;
    if (value.is_number()) {
      out += fmt::format("airside_room_temperature_celsius{{room=\"{}\"}} {}\n", number, value.get<double>());
    }
  }
}

}  // namespace

std::string metrics_text(const StatusReader& reader) {
  const json& status = reader.object();
  std::string out;
  const double age_s = reader.age_s();
  const bool stopped = status.is_object() && status.value("stopped", json(false)) == json(true);
  const bool up = status.is_object() && !stopped && std::abs(age_s) <= old_after_s;
  head(out, "up", "gauge", "Whether airsided runs: its status is not older than 15 min and it has not stopped.");
  out += fmt::format("airside_up {}\n", up ? 1 : 0);
  head(out, "page_info", "gauge", "This airside-page.");
  out += fmt::format("airside_page_info{{version=\"{}\"}} 1\n", hal::version());
  if (!status.is_object()) return out;
  head(out, "status_age_seconds", "gauge", "Since the status was written.");
  out += fmt::format("airside_status_age_seconds {:.3f}\n", age_s);
  head(out, "site_info", "gauge", "The site of this box.");
  out += fmt::format("airside_site_info{{site=\"{}\",topology=\"{}\",objective=\"{}\"}} 1\n",
                     escaped(text_in(status, "site")), escaped(text_in(status, "topology")),
                     escaped(text_in(status, "objective")));
  modes(out, status);
  rooms(out, status);
  for (const Plain& metric : gauges) plain(out, status, metric, "gauge");
  for (const Plain& metric : counters) plain(out, status, metric, "counter");
  const auto weights = status.find("has_weights");
  if (weights != status.end() && weights->is_boolean()) {
    head(out, "has_weights", "gauge", "Whether there are weights.");
    out += fmt::format("airside_has_weights {}\n", weights->get<bool>() ? 1 : 0);
  }
  head(out, "storage_ok", "gauge", "Whether state and log can be written.");
  out += fmt::format("airside_storage_ok {}\n", text_in(status, "storage") == "ok" ? 1 : 0);
  const double late_ms = number_of(status, "row_late_ms");
  if (std::isfinite(late_ms)) {
    head(out, "row_lateness_seconds", "gauge", "From a row's instant to its begin.");
    out += fmt::format("airside_row_lateness_seconds {}\n", late_ms / 1000);
  }
  return out;
}

}  // namespace airside::page
