#pragma once
// The site file: what a controls engineer says about a room, in TOML. Read whole and checked at the door;
// everything after it can trust it.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "airside/demand_settings.hpp"
#include "airside/held_rooms.hpp"
#include "hal/points/stand_ins.hpp"
#include "hal/site/bacnet_section.hpp"
#include "hal/site/controller_preset.hpp"  // IWYU pragma: export
#include "hal/site/mqtt_section.hpp"
#include "hal/site/twin_section.hpp"

namespace airside::hal {

/// A controller setting that [controller.override] may name.
struct SettingRule {
  std::string name;
  double min, max, default_value;
};

/// What a site file is checked against.
struct SiteRules {
  std::vector<std::string> topologies;              ///< examples, for messages
  std::function<bool(const std::string&)> holds{};  ///< whether a topology of this build holds a shape; empty: any does
  std::vector<SettingRule> settings;                ///< empty: override names are not checked
};

enum class ModbusTransport : std::uint8_t { tcp, rtu };
enum class ClockSource : std::uint8_t { system, plant };

struct ModbusSection {
  ModbusTransport transport = ModbusTransport::tcp;
  std::string host;                        ///< tcp
  std::string host_place = "modbus host";  ///< who named it, for messages: `site.toml:39:1: modbus.host`
  int port = 502;                          ///< tcp
  std::string device;                      ///< rtu, such as /dev/ttyUSB0
  int baud = 19200;                        ///< rtu
  char parity = 'E';                       ///< rtu: N, E or O
  int unit_id = 1;                         ///< 0..247, rtu: from 1
  double deadline_s = 5;                   ///< one exchange is over after so long
  double heartbeat_s = 20;                 ///< between two beats, where the map has a heartbeat
  std::string points;                      ///< path of the point map, resolved against the site file's folder
};

/// Where `airside-page` listens; without the table, its defaults.
struct PageSection {
  std::string listen = "127.0.0.1";  ///< a numeric address; any but a loopback one needs certificate and key
  int port = 8350;
  std::vector<std::string> names;  ///< host names that browsers and `airside push` may call it by, in small letters
  std::string tls_cert, tls_key;   ///< PEM files; both or none
  std::string dir;                 ///< of the page's own: passwords, alarms that somebody has seen
};

/// A checked site file. Paths are resolved against the folder of the file; "" where none is given.
struct SiteFile {
  std::string path;

  std::string name;                 ///< [site]
  std::string topology;             ///< one of SiteRules::topologies
  std::string scope;                ///< which weight blobs this room takes; the name unless given
  std::vector<std::string> meters;  ///< names of the power meters, in reports; or none

  double room_temp_degc = 25.25;  ///< [target]
  HeldRooms held;                 ///< hold, weights: which value of the rooms is held there
  int work_start_s = 7 * 3600;    ///< s since midnight
  int work_end_s = 19 * 3600;
  bool weekday_only = false;

  int fan_start_s = 0;  ///< [ahu]: when its fan runs, s since midnight; 0 to 24 h: always
  int fan_end_s = 24 * 3600;
  bool fan_weekday_only = false;

  double setpoint_min_degc = 20, setpoint_max_degc = 26;  ///< [setpoint]
  double setpoint_step_k = 0.1;
  double setpoint_max_change_k = 4.5;  ///< from one cycle to the next
  double setpoint_round_k = 0.01;
  bool setpoint_outside_jump = false;  ///< outside = "jump": found outside the limits, it is brought inside at once

  double expert_work_degc = 20.5, expert_off_degc = 25.0;  ///< [expert]

  ControllerPreset preset = ControllerPreset::product;  ///< [controller]
  Objective objective = Objective::mean;
  int cycle_min = 18;  ///< control cycle
  std::uint64_t seed = 1;
  std::map<std::string, double> overrides;  ///< [controller.override]

  StandIns stand_ins;  ///< [stand_in]: numbers in the place of signals that the site has no sensor for

  std::optional<ModbusSection> modbus;  ///< absent: a site that is only simulated
  std::optional<BacnetSection> bacnet;  ///< absent: the point map has registers of a Modbus device
  ClockSource clock = ClockSource::system;
  int daylight_saving = 0;  ///< [clock]: 0 none, 1 eu, 2 us; the schedule follows it, the log does not
  double utc_offset_h = 0;  ///< of local standard time, hours east
  std::string state_dir;    ///< [state] dir
  std::string log_dir;      ///< [log] dir
  int log_max_files = 40;
  double log_max_file_mb = 8;
  std::string history_log;   ///< [history] log
  std::string weights_blob;  ///< [weights] blob
  std::string keys_dir;      ///< [weights] keys: whose pushed weights are taken
  std::string inbox_dir;     ///< [inbox] dir
  PageSection page;
  std::optional<TwinSection> twin;
  std::optional<MqttSection> mqtt;  ///< absent: nothing is published
};

/// Reads and checks a site file.
/// Errors: InputError with file:line:column and key; unknown keys are errors too.
SiteFile read_site_file(const std::string& path, const SiteRules& rules);

/// As read_site_file, from text; `path` stands in messages and its folder resolves paths.
SiteFile parse_site_text(std::string_view text, const std::string& path, const SiteRules& rules);

/// A complete, commented site file with all defaults, which parse_site_text accepts; for the objective band with the
/// cold air that boxes that modulate work with.
std::string example_site_text(const std::string& topology, Objective objective = Objective::mean);

}  // namespace airside::hal
