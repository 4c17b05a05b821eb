#pragma once
// What `airside probe` finds at each point of a map: raw registers, value, verdict.

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "hal/modbus/link.hpp"
#include "hal/points/point_map.hpp"
#include "hal/points/word_order.hpp"
#include "hal/site/site_file.hpp"

namespace airside::tools {

/// One row of the sheet.
struct ProbedPoint {
  const hal::Point* point = nullptr;
  std::vector<std::uint16_t> raw;  ///< empty: nothing was read
  double value = std::nan("");     ///< whatever the limits say; NaN: none
  std::string verdict;
  bool was_asked = false;  ///< the device answered, if only with an exception
  bool in_order = false;
  bool order_doubted = false;
  bool has_no_value = false;          ///< the device says so, by a sentinel or NaN
  bool is_unwritten = false;          ///< a writable point that shows no value yet
  std::vector<hal::OrderGuess> fits;  ///< other orders in which it makes sense
};

/// Registers of one device, each asked for once; nothing is ever written.
class ProbedDevice {
 public:
  explicit ProbedDevice(hal::ModbusLink& link) : link_(link) {}

  /// The registers of `point`, whatever its limits. Errors: LinkFault. Cost: at most one exchange.
  hal::LinkResult<std::vector<std::uint16_t>> read(const hal::Point& point);
  /// Further registers are not asked for after three exchanges in a row without an answer.
  bool is_lost() const { return lost_ >= 3; }

 private:
  hal::ModbusLink& link_;
  int lost_ = 0;
  std::map<std::tuple<int, int, int>, hal::LinkResult<std::vector<std::uint16_t>>> known_;
};

/// What the device of this map shows in the point map_fingerprint.
double expected_fingerprint(const hal::PointMap& map);

/// Reads and judges every point of the map. Where no connection comes about, `site` says why.
/// Errors: InputError where no connection can be made.
std::vector<ProbedPoint> probe_all(const hal::PointMap& map, ProbedDevice& device, const std::string& address,
                                   const hal::SiteFile& site);

}  // namespace airside::tools
