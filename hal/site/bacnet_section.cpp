#include "hal/site/bacnet_section.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "hal/points/point_map.hpp"
#include "hal/site/site_file.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/toml_section.hpp"

namespace airside::hal {
namespace {

std::optional<int> whole(std::string_view text, int most) {
  int value = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 0 || value > most) return std::nullopt;
  return value;
}

bool is_ipv4(const std::string& text) {
  in_addr parsed{};
  return ::inet_pton(AF_INET, text.c_str(), &parsed) == 1;
}

/// `192.168.1.30/24`.
bool is_card_address(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos || !is_ipv4(text.substr(0, slash))) return false;
  const auto prefix = whole(std::string_view(text).substr(slash + 1), 32);
  return prefix && *prefix >= 8;
}

/// `192.168.1.50`, with `:47809` where the port is another, or `2001:5`: station 5 of network 2001 behind a router.
bool is_device_address(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return is_ipv4(text);
  const std::string_view after = std::string_view(text).substr(colon + 1);
  if (text.find('.') != std::string::npos) return is_ipv4(text.substr(0, colon)) && whole(after, 65535).value_or(0) > 0;
  return whole(std::string_view(text).substr(0, colon), 65534).value_or(0) > 0 && whole(after, 255).has_value();
}

void check_devices(const TomlSection& root, const std::vector<std::string>& devices) {
  std::vector<std::string_view> seen;
  for (const std::string& device : devices) {
    const std::size_t at = device.find('@');
    const std::string_view instance = std::string_view(device).substr(0, std::min(at, device.size()));
    if (at == std::string::npos || !whole(instance, 4194302) || !is_device_address(device.substr(at + 1))) {
      throw InputError(
          root.place("devices"), "\"" + device.substr(0, 60) + "\"",
          "INSTANCE@ADDRESS, such as \"1201@192.168.1.50\", \"1201@192.168.1.50:47809\", or \"1305@2001:5\" "
          "for station 5 of network 2001 behind a router",
          "correct it, or take it out where the device answers Who-Is");
    }
    if (std::ranges::find(seen, instance) != seen.end()) {
      throw InputError(root.place("devices"), fmt::format("device {} twice", instance), "each device once",
                       "remove one of the two");
    }
    seen.push_back(instance);
  }
}

}  // namespace

std::optional<BacnetSection> read_bacnet_section(TomlSection root) {
  if (!root.present()) return std::nullopt;
  BacnetSection b;
  b.address = root.required_text("address", "192.168.1.30/24");
  if (!is_card_address(b.address)) {
    throw InputError(
        root.place("address"), root.found("address"),
        "this machine's IPv4 address in the network of the devices, with the length of its prefix, 8 to 32",
        "write it as in \"192.168.1.30/24\"; `ip -4 address` shows it");
  }
  b.port = static_cast<int>(root.whole("port", b.port, 1, 65535));
  b.instance = static_cast<int>(root.whole("instance", b.instance, 0, 4194302));
  b.priority = static_cast<int>(root.whole("priority", b.priority, 8, 16));
  b.poll_s = root.number("poll_s", b.poll_s, 1, 300, "s");
  b.stale_s = root.number("stale_s", b.stale_s, 3, 1200, "s");
  b.timeout_s = root.number("timeout_s", b.timeout_s, 0.2, 8, "s");
  b.heartbeat_timeout_s = root.number("heartbeat_timeout_s", b.heartbeat_timeout_s, 15, 1200, "s");
  b.devices = root.text_list("devices");
  if (b.stale_s < 2 * b.poll_s) {
    const char* key = root.has("stale_s") ? "stale_s" : "poll_s";
    throw InputError(root.place(key), root.found(key),
                     fmt::format("stale_s of at least two times poll_s; they are {} and {} s", b.stale_s, b.poll_s),
                     "read more often, or believe values for longer");
  }
  check_devices(root, b.devices);
  root.refuse_unknown_keys();
  return b;
}

void refuse_bacnet_contradiction(const SiteFile& site, const PointMap& points) {
  if (points.protocol() != Protocol::bacnet) {
    if (!site.bacnet) return;
    throw InputError(site.path + ": [bacnet]", fmt::format("the table, and no row of BACnet in {}", points.file()),
                     "both or neither", "take the table out, or write bacnet into the map's column protocol");
  }
  if (!site.bacnet) {
    throw InputError(site.path + ": [bacnet]", fmt::format("nothing, and rows of BACnet in {}", points.file()),
                     "a table that says how airside-bacnet reaches the devices",
                     "add [bacnet] with address = \"192.168.1.30/24\", this machine's in their network");
  }
  const ModbusSection& m = *site.modbus;
  in_addr host{};
  const bool here =
      m.host == "localhost" || (::inet_pton(AF_INET, m.host.c_str(), &host) == 1 && ntohl(host.s_addr) >> 24 == 127);
  if (m.transport != ModbusTransport::tcp || !here) {
    throw InputError(site.path + ": [modbus] host",
                     m.transport == ModbusTransport::tcp ? "\"" + m.host + "\"" : "transport = \"rtu\"",
                     "\"127.0.0.1\" by tcp: the rows of BACnet are served by airside-bacnet on this machine alone",
                     "set transport = \"tcp\" and host = \"127.0.0.1\"");
  }
  if (site.bacnet->timeout_s >= m.deadline_s) {
    throw InputError(site.path + ": [bacnet] timeout_s", fmt::format("{} s", site.bacnet->timeout_s),
                     fmt::format("less than deadline_s of [modbus], {} s", m.deadline_s),
                     "lower timeout_s or raise deadline_s");
  }
  if (site.bacnet->heartbeat_timeout_s < 3 * m.heartbeat_s) {
    throw InputError(site.path + ": [bacnet] heartbeat_timeout_s",
                     fmt::format("{} s", site.bacnet->heartbeat_timeout_s),
                     fmt::format("at least three times heartbeat_s of [modbus], {} s", m.heartbeat_s),
                     "raise heartbeat_timeout_s or lower heartbeat_s");
  }
}

}  // namespace airside::hal
