#pragma once
// What a site's points are to other people's software: each with its class, its tags and whose it is.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/run/site.hpp"

namespace airside::tools {

/// What a point belongs to.
enum class Owner : std::uint8_t { ahu, fan, mau, vav, zone, fcu, meter };

/// All points of one stem (`room_temp`), in the words of Brick 1.4 and of Project Haystack 4.
struct PointKind {
  std::string_view stem;
  Owner owner;
  const char* label;          ///< for people, behind the owner's
  const char* brick_class;    ///< without its prefix
  const char* qudt_unit;      ///< without its prefix; "" for a status
  const char* markers;        ///< of Haystack beside `point` and `cur`, apart by blanks
  const char* haystack_unit;  ///< "" for a status and for a fraction
  bool is_status;             ///< 0 or 1
};

/// One row of the point map that means something to others: clock, heartbeat and names of the site's own do not.
struct SitePoint {
  const hal::Point* row;
  const PointKind* kind;
  int place;           ///< from 1; 0 where there is only one
  std::string label;   ///< "zone 1 air temperature"
  std::string column;  ///< of the log; "" where the log has another value, such as the median of several sensors
};

/// In the order of the point map. `site` must outlive them.
std::vector<SitePoint> site_points(const Site& site);

/// `zone_1`, `ahu`; and the same for people.
std::string owner_id(Owner owner, int place);
std::string owner_label(Owner owner, int place);
/// Number of zones and boxes, fan coils, meters of the site; 1 of what every site has, 0 where nothing is there.
int owners(const Site& site, const std::vector<SitePoint>& points, Owner owner);

/// An object of a BACnet device, by instance numbers: 1201, `analog-input`, 3, `present-value`.
struct BacnetObject {
  std::string_view device, type, instance, property;
};

/// What the gateway reads for this row, which must outlive it; nothing for a Modbus register and for what the gateway
/// itself holds: its own registers are of no use to others.
std::optional<BacnetObject> bacnet_object(const hal::Point& row);

/// Where the daemon logs, as the site file says it.
const std::string& log_folder(const Site& site);

}  // namespace airside::tools
