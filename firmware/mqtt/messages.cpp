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
Entity temperature(std::string object, std::string name, const std::string& member) {
  return {"sensor", std::move(object),
          json{{"name", std::move(name)},
               {"value_template", "{{ value_json." + member + " }}"},
               {"device_class", "temperature"},
               {"state_class", "measurement"},
               {"unit_of_measurement", "°C"},
               {"suggested_display_precision", 2}}};
}

std::vector<Entity> entities(int rooms, const std::string& status) {
  std::vector<Entity> out;
  for (int i = 0; i < rooms; ++i) {
    out.push_back(temperature(fmt::format("room_{}_temperature", i + 1), fmt::format("Room {} temperature", i + 1),
                              fmt::format("room_temp_degc[{}]", i)));
  }
  out.push_back(temperature("setpoint", "Supply air setpoint", "setpoint_degc"));
  out.push_back(temperature("target", "Room target", "target_degc"));
  out.push_back(temperature("held", "Held room temperature", "held_degc"));
  out.push_back(temperature("forecast", "Forecast room temperature", "expected_held_degc"));
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
  out.push_back({"sensor", "confidence",
                 json{{"name", "Confidence"},
                      {"value_template", "{{ value_json.confidence }}"},
                      {"state_class", "measurement"},
                      {"suggested_display_precision", 2},
                      {"entity_category", "diagnostic"}}});
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
  for (Entity& entity : entities(parse_shape(site.topology.c_str()).vavs, status_topic(mqtt))) {
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

std::vector<Message> withdrawal(const hal::SiteFile& site) {
  const hal::MqttSection& mqtt = *site.mqtt;
  std::vector<Message> out;
  if (!mqtt.discovery_prefix.empty()) {
    for (const Entity& entity : entities(most_rooms, "")) out.push_back({config_topic(mqtt, entity), ""});
  }
  out.push_back({status_topic(mqtt), ""});
  out.push_back({availability_topic(mqtt), ""});
  return out;
}

}  // namespace airside::mqtt
