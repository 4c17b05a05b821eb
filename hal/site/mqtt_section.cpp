#include "hal/site/mqtt_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "airside/crc32c.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/toml_section.hpp"

namespace airside::hal {
namespace {

bool is_letter_or_digit(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }

bool consists_of(std::string_view text, std::string_view others) {
  return std::ranges::all_of(text, [&](char c) { return is_letter_or_digit(c) || others.find(c) != others.npos; });
}

/// A topic that can be published to, with a name between any two slashes.
void check_topic(const TomlSection& root, const char* key, const std::string& topic) {
  const bool control =
      std::ranges::any_of(topic, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 127; });
  const bool wild = topic.find_first_of("+#") != topic.npos;
  const bool blank_level = topic.starts_with('/') || topic.ends_with('/') || topic.find("//") != topic.npos;
  constexpr std::size_t most = 128;
  if (!control && !wild && !blank_level && !topic.starts_with('$') && topic.size() <= most) return;
  throw InputError(root.place(key), topic.size() > most ? fmt::format("{} bytes", topic.size()) : root.found(key),
                   fmt::format("a topic of at most {} bytes such as airside/ahu_3, without + and #, no slash at either "
                               "end, no $ at its beginning",
                               most),
                   "correct it, or leave it out");
}

void check_host(const TomlSection& root, const std::string& host) {
  if (!host.empty() && host.size() <= 253 && consists_of(host, ".-_:%")) return;
  throw InputError(root.place("host"), root.found("host"), "a host name or a numeric address, such as 192.168.1.10",
                   "leave scheme and path out; the port has a key of its own");
}

}  // namespace

std::string topic_name(std::string_view name) {
  std::string out;
  bool lost = false;
  for (const char c : name) {
    if (is_letter_or_digit(c)) {
      out += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
      continue;
    }
    if (!out.empty() && out.back() != '_') out += '_';
    lost = lost || std::string_view(" -_./").find(c) == std::string_view::npos;
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  if (!lost && !out.empty()) return out;
  const std::string sum = fmt::format("{:08x}", crc32c(std::as_bytes(std::span(name))));
  return out.empty() ? sum : out + '_' + sum;
}

std::string warning_of(const MqttSection& mqtt) {
  const bool here = mqtt.host == "localhost" || mqtt.host == "::1" || mqtt.host.starts_with("127.");
  if (mqtt.password_file.empty() || !mqtt.tls_ca.empty() || here) return "";
  return fmt::format("mqtt.password_file without tls_ca: everybody on the way to {} can read the password; give tls_ca",
                     mqtt.host);
}

MqttSection read_mqtt_section(TomlSection root, std::string_view name) {
  MqttSection out;
  out.host = root.required_text("host", "192.168.1.10");
  check_host(root, out.host);
  out.tls_ca = root.text("tls_ca", "");
  out.port = static_cast<int>(root.whole("port", out.tls_ca.empty() ? 1883 : 8883, 1, 65535));
  out.username = root.text("username", "");
  out.password_file = root.text("password_file", "");
  if (!out.password_file.empty() && out.username.empty()) {
    throw InputError(root.place("username"), "nothing beside password_file", "the user whose password that is",
                     "add username, or take password_file out");
  }
  out.topic_prefix = root.text("topic_prefix", "");
  if (out.topic_prefix.empty()) out.topic_prefix = "airside/" + topic_name(name);
  check_topic(root, "topic_prefix", out.topic_prefix);
  out.client_id = root.text("client_id", "");
  if (out.client_id.empty()) out.client_id = "airside-" + topic_name(name);
  if (out.client_id.size() > 96 || !consists_of(out.client_id, "-_.")) {
    throw InputError(root.place("client_id"), root.found("client_id"), "1 to 96 of the letters a-z, A-Z, 0-9, - _ .",
                     "choose one that no other client of this broker has, or leave it out");
  }
  out.discovery_prefix = root.text("discovery_prefix", "homeassistant");
  check_topic(root, "discovery_prefix", out.discovery_prefix);
  root.refuse_unknown_keys();
  return out;
}

}  // namespace airside::hal
