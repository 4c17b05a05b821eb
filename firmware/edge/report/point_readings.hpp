#pragma once
// Every point of the map as the device shows it now, for whoever checks the points of a site: read when a wish lies in
// the inbox, by the one who has the bus. Another wish has the setpoint written once, and put back.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "airside/fault.hpp"
#include "hal/modbus/link.hpp"
#include "hal/modbus/setpoint.hpp"
#include "hal/points/point_map.hpp"

namespace airside::edge {

/// Reads nothing until it is asked, and changes nothing that control reads. Writes nothing itself.
class PointReadings {
 public:
  static constexpr const char* wish_name = "read-points";
  static constexpr const char* write_wish_name = "check-write";
  static constexpr const char* file_name = "points.json";

  /// Empty folders: nothing is ever wanted.
  PointReadings(const hal::PointMap& map, std::string inbox_dir, std::string state_dir);

  /// Whether the wish lies in the inbox. Cost: a few system calls.
  bool wanted() const;
  /// Whether the wish for a write does. Cost: as wanted().
  bool write_wanted() const;
  /// What became of that write: stands in points.json from the next read() on, with the time `now` of the site.
  void note(const hal::WriteCheck& check, CivilTime now);
  /// Reads every readable point in a request of its own, writes points.json with the time `now` of the site, and takes
  /// the wishes away, also where the file could not be written: who waits sees the old one. After an exchange that
  /// failed without an answer the points behind it are without a reading; with `answers` false all are.
  /// Errors: none here; a file that cannot be written is said once.  Cost: one exchange a point; no heap.
  void read(hal::ModbusLink& link, CivilTime now, bool answers);

 private:
  struct Reading {
    std::array<std::uint16_t, 2> raw{};
    Fault fault = Fault::no_reading;
    std::uint8_t exception = 0;  ///< of the device
    bool has_raw = false;
  };
  bool lies_in_inbox(const char* name) const;
  bool read_one(hal::ModbusLink& link, std::size_t i);
  std::size_t format(CivilTime now);
  bool write(std::size_t bytes) const;

  std::string inbox_dir_, state_dir_;
  std::vector<hal::Point> points_;
  std::vector<Reading> readings_;
  std::vector<char> text_;
  std::optional<hal::WriteCheck> check_;
  CivilTime checked_;
  bool said_ = false;
};

}  // namespace airside::edge
