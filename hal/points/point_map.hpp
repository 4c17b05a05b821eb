#pragma once
// The site's points.csv: which Modbus register holds which signal, how its bits become a physical number, and
// what may be written. Checked whole, once, at the door; after that every Point can be trusted.

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "airside/signals.hpp"
#include "airside/topology.hpp"
#include "hal/points/stand_ins.hpp"
#include "hal/text/input_error.hpp"

namespace airside::hal {

/// What the registers of a point hold; coil and discrete are one bit, the 32-bit types two registers.
enum class PointType : std::uint8_t { coil, discrete, int16, uint16, int32, uint32, float32 };

/// Order of bytes within a register, or of registers within a 32-bit value.
enum class Endian : std::uint8_t { big, little };

/// When a value is written: never, only when it differs from the stored value, or on every call.
enum class WritePolicy : std::uint8_t { none, on_change, refresh };

/// Who holds a point: registers of a Modbus device, or an object of a BACnet device behind `airside-bacnet`, which
/// shows it in registers that its place in the map decides.
enum class Protocol : std::uint8_t { modbus, bacnet };

constexpr int max_sentinels = 4;  ///< per point

/// One row of points.csv. physical = raw * scale + offset.
struct Point {
  std::string name;                    ///< `<signal>_<place>` of signals.hpp, or any further name
  std::string unit;                    ///< unit of physical, min and max
  int fc = 3;                          ///< read function: 1 coil, 2 discrete, 3 holding, 4 input register
  int addr = 0;                        ///< zero-based protocol address
  PointType type = PointType::uint16;  ///< width and meaning of the raw bits
  Endian byte_order = Endian::big;     ///< of the two bytes within a register
  Endian word_order = Endian::big;     ///< of the two registers of a 32-bit type
  double scale = 1.0;                  ///< never 0
  double offset = 0.0;                 ///< in the unit
  double min = 0.0;                    ///< a decoded value below is invalid
  double max = 1.0;                    ///< a decoded value above is invalid
  double max_rate_per_min = std::numeric_limits<double>::infinity();  ///< unit per minute
  double stale_s = std::numeric_limits<double>::infinity();           ///< age after which a value is stale
  std::array<std::uint32_t, max_sentinels> sentinel{};                ///< raw bit patterns that mean "no value"
  int sentinels = 0;                                                  ///< how many of them are used
  WritePolicy write_policy = WritePolicy::none;
  int fc_write = 0;  ///< 5, 6 or 16; 0 where nothing may be written
  /// What a served simulation shows at first; NaN where the site names none.
  double default_value = std::numeric_limits<double>::quiet_NaN();
  std::string readback;  ///< `self`, `none` or the name of the point that shows what was taken
  Protocol protocol = Protocol::modbus;
  std::string object;  ///< bacnet: `1201:analog-input:3:present-value`, or `gateway`
  int line = 0;        ///< of the file, for messages

  constexpr bool is_bit() const { return type == PointType::coil || type == PointType::discrete; }
  constexpr int width() const { return type >= PointType::int32 ? 2 : 1; }  ///< registers, or bits
  constexpr bool writable() const { return fc_write != 0; }
  /// A writable point whose readback is `none` is never read: some devices refuse it until it was written.
  bool readable() const { return !(writable() && readback == "none"); }
};

/// Point name of a signal: `room_temp_1`, `rain`.
std::string point_name(SignalId id);

class PointMap {
 public:
  /// Reads and checks a file.
  /// Errors: InputError with file:line, column, what was found, what was expected, what to do.
  static PointMap load(const std::string& path);
  /// The same for text already in memory; `file` stands in messages.
  static PointMap parse(std::string_view text, std::string file);
  /// Both again, with what is wrong with rows in `complaints`, all of it, the rows in their order, then what rows are
  /// to each other. After a complaint the map is fit for topology_complaints() alone: it knows the names of all rows.
  /// Errors: InputError for what hides the rows: no file, another kind of file, a wrong header, none of them.
  static PointMap load(const std::string& path, std::vector<InputError>& complaints);
  static PointMap parse(std::string_view text, std::string file, std::vector<InputError>& complaints);

  const std::vector<Point>& points() const { return points_; }
  /// nullptr where the map has no such point.
  const Point* find(std::string_view name) const;
  /// Errors: InputError naming the file and the missing point.
  const Point& at(std::string_view name) const;
  /// Position in points(), -1 where there is none.
  int index_of(std::string_view name) const;
  /// Of all its points alike; a map never mixes.
  Protocol protocol() const { return points_.empty() ? Protocol::modbus : points_.front().protocol; }
  /// Names that no topology, clock or heartbeat uses; they are served and read, nothing more.
  std::vector<std::string> extras() const;
  /// Hash of every column of every point, whatever the order of rows and columns.
  std::uint64_t fingerprint() const;
  /// What a device of this map shows in the point `map_fingerprint`: the point's default where the site names one (any
  /// constant of the device, such as its serial number), else the low 32 bits of fingerprint().
  double told_fingerprint() const;
  const std::string& file() const { return file_; }

  /// The sensors of a zone that has several, `room_temp_3a` on; none where it has one under the name alone.
  std::vector<const Point*> sensors(int place) const;
  /// Whether a signal is sensed: it has a row, or a zone its sensors.
  bool has(SignalId id) const;
  /// Refuses a map that lacks a signal of the topology for which there is no stand-in either, or has one that the
  /// topology does not or that has a stand-in.
  /// Errors: InputError naming the point.
  void check_topology(int vavs, int fcus, int powers, const StandIns& stand_ins = {}) const;
  /// All that check_topology() refuses, at once.
  std::vector<InputError> topology_complaints(int vavs, int fcus, int powers, const StandIns& stand_ins = {}) const;

 private:
  std::string file_;
  std::vector<Point> points_;
};

/// A complete points.csv for a room of this shape: 0.01 K temperatures, 0/1 status, float powers in one block
/// of input registers; setpoint, heartbeat and the simulator's clock request in holding registers. A signal that has a
/// stand-in has no row.
/// `boxes_modulate`: dampers, zone setpoints, people, supply flow and the fan's status too, as the objective band
/// takes.
std::string default_point_map(int vavs, int fcus, int powers, const StandIns& stand_ins = {},
                              bool boxes_modulate = false);

}  // namespace airside::hal
