#include "firmware/mqtt/messages.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "airside/topology.hpp"
#include "hal/system/version.hpp"

namespace airside::mqtt {

namespace {

using nlohmann::json;

constexpr int most_rooms = 32;

/// The part of topics and identities that is the site's own: two sites of one name need a topic_prefix each.
std::string node_of(const hal::MqttSection& mqtt) { return hal::topic_name(mqtt.topic_prefix); }

/// One entity of the device.
struct Entity {
  const char* component;  ///< sensor, binary_sensor
  std::string object;
  json document;
};

/// In degC; `member` is the path below value_json.
/// Without any reading the status has no rooms: Home Assistant takes "None" as unknown, and nothing as no news.
Entity temperature(std::string object, std::string name, const std::string& member) {
  return {"sensor", std::move(object),
          json{{"name", std::move(name)},
               {"value_template", "{{ value_json." + member + " | default(none) }}"},
               {"device_class", "temperature"},
               {"state_class", "measurement"},
               {"unit_of_measurement", "°C"},
               {"suggested_display_precision", 2}}};
}

/// A number of its own unit, for which Home Assistant has no class: of a temperature's it would convert K to °C.
Entity quantity(std::string object, std::string name, const std::string& value, const char* unit, int digits) {
  return {"sensor", std::move(object),
          json{{"name", std::move(name)},
               {"value_template", "{{ " + value + " }}"},
               {"state_class", "measurement"},
               {"unit_of_measurement", unit},
               {"suggested_display_precision", digits}}};
}

/// What `mean` holds and forecasts.
std::vector<Entity> entities_of_mean() {
  return {temperature("target", "Room target", "target_degc"),
          temperature("held", "Held room temperature", "held_degc"),
          temperature("forecast", "Forecast room temperature", "expected_held_degc"),
          {"sensor", "confidence",
           json{{"name", "Confidence"},
                {"value_template", "{{ value_json.confidence }}"},
                {"state_class", "measurement"},
                {"suggested_display_precision", 2},
                {"entity_category", "diagnostic"}}}};
}

/// What `band` looks at: it holds no room temperature and forecasts none.
std::vector<Entity> entities_of_band() {
  const std::string damper = "value_json.most_open_damper";
  return {
      quantity("warmest_zone", "Warmest zone above its setpoint", "value_json.warmest_zone_above_setpoint_k", "K", 2),
      quantity("most_open_damper", "Most open damper",
               "(" + damper + " * 100) | round(0) if " + damper + " is number else none", "%", 0)};
}

std::vector<Entity> entities_of(Objective objective) {
  return objective == Objective::band ? entities_of_band() : entities_of_mean();
}

std::vector<Entity> entities(int rooms, Objective objective, const std::string& status) {
  std::vector<Entity> out;
  for (int i = 0; i < rooms; ++i) {
    out.push_back(temperature(fmt::format("room_{}_temperature", i + 1), fmt::format("Room {} temperature", i + 1),
                              fmt::format("room_temp_degc[{}]", i)));
  }
  out.push_back(temperature("setpoint", "Supply air setpoint", "setpoint_degc"));
  for (Entity& entity : entities_of(objective)) out.push_back(std::move(entity));
  out.push_back({"sensor", "mode",
                 json{{"name", "Control mode"},
                      {"value_template", "{{ value_json.state }}"},
                      {"device_class", "enum"},
                      {"options", {"learn", "run", "expert", "release"}}}});
  out.push_back(
      {"sensor", "reason",
       json{{"name", "Reason"},
            {"value_template", "{{ value_json.reason }}"},
            {"json_attributes_topic", status},
            {"json_attributes_template", "{{ {'why': value_json.why, 'way_out': value_json.way_out} | tojson }}"}}});
  out.push_back({"binary_sensor", "alarm",
                 json{{"name", "Alarm"},
                      {"value_template", "{{ 'ON' if value_json.alarms else 'OFF' }}"},
                      {"payload_on", "ON"},
                      {"payload_off", "OFF"},
                      {"device_class", "problem"},
                      {"json_attributes_topic", status},
                      {"json_attributes_template", "{{ {'alarms': value_json.alarms} | tojson }}"}}});
  return out;
}

std::string config_topic(const hal::MqttSection& mqtt, const Entity& entity) {
  return fmt::format("{}/{}/{}/{}/config", mqtt.discovery_prefix, entity.component, node_of(mqtt), entity.object);
}

}  // namespace

std::string status_topic(const hal::MqttSection& mqtt) { return mqtt.topic_prefix + "/status"; }
std::string availability_topic(const hal::MqttSection& mqtt) { return mqtt.topic_prefix + "/availability"; }

std::vector<Message> discovery(const hal::SiteFile& site) {
  const hal::MqttSection& mqtt = *site.mqtt;
  if (mqtt.discovery_prefix.empty()) return {};
  const std::string node = node_of(mqtt);
  const json device{{"identifiers", {node}},
                    {"name", site.name},
                    {"manufacturer", "airside"},
                    {"model", site.topology},
                    {"sw_version", hal::version()}};
  std::vector<Message> out;
  for (Entity& entity : entities(parse_shape(site.topology.c_str()).vavs, site.objective, status_topic(mqtt))) {
    json& document = entity.document;
    document["unique_id"] = node + '_' + entity.object;
    document["state_topic"] = status_topic(mqtt);
    document["availability_topic"] = availability_topic(mqtt);
    document["device"] = device;
    document["origin"] = {{"name", "airside-mqtt"}, {"sw_version", hal::version()}};
    out.push_back({config_topic(mqtt, entity), document.dump()});
  }
  return out;
}

std::vector<Message> outdated(const hal::SiteFile& site) {
  const hal::MqttSection& mqtt = *site.mqtt;
  std::vector<Message> out;
  if (mqtt.discovery_prefix.empty()) return out;
  const Objective other = site.objective == Objective::band ? Objective::mean : Objective::band;
  for (const Entity& entity : entities_of(other)) out.push_back({config_topic(mqtt, entity), ""});
  return out;
}

std::vector<Message> withdrawal(const hal::SiteFile& site) {
  const hal::MqttSection& mqtt = *site.mqtt;
  std::vector<Message> out = outdated(site);
  if (!mqtt.discovery_prefix.empty()) {
    for (const Entity& entity : entities(most_rooms, site.objective, ""))
      out.push_back({config_topic(mqtt, entity), ""});
  }
  out.push_back({status_topic(mqtt), ""});
  out.push_back({availability_topic(mqtt), ""});
  return out;
}

}  // namespace airside::mqtt
