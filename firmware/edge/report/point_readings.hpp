#pragma once
// Every point of the map as the device shows it now, for whoever checks the points of a site: read when a wish lies in
// the inbox, by the one who has the bus. Another wish has the setpoint written once, and put back.

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <ctime>
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

  /// Whether a wish lies in the inbox that nothing was done for yet. Cost: a few system calls.
  bool wanted() const;
  /// Whether the wish for a write does; it counts as done from now on, also where it cannot be taken away. Cost: as
  /// wanted().
  bool take_write_wish();
  /// What became of that write: stands in points.json from the next read() on, with the time `now` of the site.
  void note(const hal::WriteCheck& check, CivilTime now);
  /// Reads every readable point in a request of its own, writes points.json with the time `now` of the site, and takes
  /// away the wishes that it was done for, not those that came meanwhile; also where the file could not be written: who
  /// waits sees the old one. After an exchange that failed without an answer the points behind it are without a
  /// reading; with `answers` false all are. Errors: none here; a file that cannot be written is said once.  Cost: one
  /// exchange a point; no heap.
  void read(hal::ModbusLink& link, CivilTime now, bool answers);

 private:
  struct Reading {
    std::array<std::uint16_t, 2> raw{};
    Fault fault = Fault::no_reading;
    std::uint8_t exception = 0;  ///< of the device
    bool has_raw = false;
  };
  /// A file in the inbox: another one of the same name differs. Inode 0: none.
  struct Wish {
    ino_t inode = 0;
    timespec changed{};
    bool operator==(const Wish& other) const {
      return inode == other.inode && changed.tv_sec == other.changed.tv_sec && changed.tv_nsec == other.changed.tv_nsec;
    }
  };
  Wish look(const char* name) const;
  bool waits(const char* name, const Wish& done) const;
  bool read_one(hal::ModbusLink& link, std::size_t i);
  std::size_t format(CivilTime now);
  bool write(std::size_t bytes) const;

  std::string inbox_dir_, state_dir_;
  std::vector<hal::Point> points_;
  std::vector<Reading> readings_;
  std::vector<char> text_;
  std::optional<hal::WriteCheck> check_;
  CivilTime checked_;
  Wish read_wish_, write_wish_;  ///< the last ones that something was done for
  bool said_ = false;
};

}  // namespace airside::edge
