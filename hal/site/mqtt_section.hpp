#pragma once
// Table [mqtt] of a site file: the broker to which airside-mqtt publishes what the box is doing.

#include <string>
#include <string_view>

namespace airside::hal {

class TomlSection;

/// Checked; file paths are as written.
struct MqttSection {
  std::string host;              ///< name or numeric address of the broker
  int port = 1883;               ///< 8883 where tls_ca is given
  std::string tls_ca;            ///< PEM file of the authority that signed the broker's certificate; "": no TLS
  std::string username;          ///< "": none
  std::string password_file;     ///< its first line is the password; "": none
  std::string topic_prefix;      ///< of all topics but discovery's, without a slash at either end
  std::string client_id;         ///< each client of a broker needs its own
  std::string discovery_prefix;  ///< of Home Assistant's discovery; "": none is published
};

/// Reads and checks the table. `name` is the site's, from which topics and client get their default names.
/// Errors: InputError with place and key.
MqttSection read_mqtt_section(TomlSection root, std::string_view name);

/// What is seldom meant: a password that crosses the network as plain text. "" where there is nothing to say.
std::string warning_of(const MqttSection& mqtt);

/// A name in the letters that topics and Home Assistant take: a-z, 0-9 and _. Where a character other than a blank, -,
/// _ or a dot is lost, a checksum of the whole keeps names apart.
std::string topic_name(std::string_view name);

}  // namespace airside::hal
