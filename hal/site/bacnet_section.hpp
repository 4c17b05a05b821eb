#pragma once
// Table [bacnet] of a site file: how `airside-bacnet` reaches the devices whose objects the point map names, and when
// it gives the setpoint back. airsided only checks it; the gateway reads it by the same rules
// (firmware/bacnet/airside_bacnet/site_file.py).

#include <optional>
#include <string>
#include <vector>

namespace airside::hal {

class PointMap;
class TomlSection;
struct SiteFile;

struct BacnetSection {
  std::string address;               ///< of this machine's network card, with the length of its network's prefix
  int port = 47808;                  ///< UDP
  int instance = 4190000;            ///< of the gateway's own device object
  int priority = 10;                 ///< at which is commanded, 8 to 16
  double poll_s = 15;                ///< from one reading of all objects to the next
  double stale_s = 60;               ///< a value that was not read for so long is none
  double timeout_s = 3;              ///< one exchange with a device is over after so long, its repetition too
  double heartbeat_timeout_s = 60;   ///< the setpoint is given back when the heartbeat has not changed for so long
  std::vector<std::string> devices;  ///< `1201@192.168.1.50`: devices that are not found by Who-Is
};

/// Reads and checks the table; nothing where the site file has none.
/// Errors: InputError with place and key.
std::optional<BacnetSection> read_bacnet_section(TomlSection root);

/// Errors: InputError where [bacnet], [modbus] and the point map contradict one another: a map of BACnet is served by
/// the gateway on this machine, which must have answered before a Modbus exchange is over.
void refuse_bacnet_contradiction(const SiteFile& site, const PointMap& points);

}  // namespace airside::hal
