#pragma once
// The newest month of the daemon's log in memory of fixed size, read little by little: no request waits for a disk full
// of files, and a flood of requests reads nothing.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "airside/settings.hpp"
#include "hal/log/log_csv.hpp"
#include "hal/site/site_file.hpp"

namespace airside::page {

/// What a row of the log says, as far as the page shows it. NaN: not known. Units in the names.
struct TrendRow {
  static constexpr float none = std::numeric_limits<float>::quiet_NaN();
  CivilTime time;
  float held_degc = none, low_degc = none, high_degc = none;
  float setpoint_degc = none, supply_degc = none, outdoor_degc = none;
  float schedule_degc = none, g36_degc = none, confidence = none, power_kw = none;
  float expected_degc = none;  ///< held value, forecast for the end of the cycle that begins here
  /// Sums over zones of what each is beyond its own setpoints and the comfort slack; while people are in and air is on,
  /// as far as the row says, and of zones whose setpoints the site shows.
  float too_warm_k = none, too_cold_k = none;
  std::int8_t mode = -1;       ///< number of ControlMode; -1: not known
  std::uint8_t reason = 0;     ///< number of Reason
  bool working_hours = false;  ///< of people's clocks
};

/// What zones are cooled and heated to by their own thermostats. Shape: one entry a room, or empty where the site does
/// not show it for each. Units: degC; NaN: not known.
struct ZoneSetpoints {
  CivilTime time;  ///< of the row
  std::vector<float> cooling_degc, heating_degc;
};

class TrendStore {
 public:
  static constexpr std::size_t capacity = 31 * rows_per_day;
  static constexpr std::size_t step_bytes = 131072;  ///< read at once

  /// Errors: none; a point map that cannot be read leaves the store empty and says so in trouble().
  explicit TrendStore(const hal::SiteFile& site);

  /// Reads at most step_bytes of what is new in the log folder. True: there may be more. Cost: some 5 ms.
  bool step();

  /// Rows ever stored; the newest is number count() - 1, the oldest that is still there number first().
  std::uint64_t count() const { return count_; }
  /// Changes where rows are counted anew, because the log is another one.
  std::uint64_t generation() const { return generation_; }
  std::uint64_t first() const { return count_ > capacity ? count_ - capacity : 0; }
  const TrendRow& row(std::uint64_t number) const { return rows_[static_cast<std::size_t>(number % capacity)]; }
  /// Of that row. Shape: vavs().
  const float* rooms_degc(std::uint64_t number) const {
    return rooms_.data() + static_cast<std::size_t>(number % capacity) * static_cast<std::size_t>(counts_.vavs);
  }
  /// Of the newest row.
  const ZoneSetpoints& zone_setpoints() const { return zones_; }
  /// First row that is not before t.
  std::uint64_t from(CivilTime t) const;
  int vavs() const { return counts_.vavs; }
  /// Of a control cycle.
  int cycle_rows() const { return control_cycle(settings_).rows; }
  bool has_meters() const { return has_meters_; }
  bool is_reading() const { return is_reading_; }
  const std::string& trouble() const { return trouble_; }
  double target_degc() const { return target_degc_; }

 private:
  std::optional<std::string> next_file() const;
  bool read_some();
  bool is_moved_away();
  void take(const hal::Log& log);
  void add(const hal::LogRow& row);
  void add_zones(const hal::LogRow& from, TrendRow& row);
  void begin_anew();

  hal::TopologyCounts counts_;
  ControllerSettings settings_{};
  HeldRooms held_;
  std::string dir_, file_, header_, trouble_;
  std::uint64_t offset_ = 0, folder_inode_ = 0, generation_ = 0;
  double target_degc_ = 0;
  bool has_meters_ = false, is_reading_ = true;
  std::vector<TrendRow> rows_;
  std::vector<float> rooms_;
  std::vector<std::size_t> cooling_, heating_;  ///< places in LogRow::side, by room
  ZoneSetpoints zones_;
  std::uint64_t count_ = 0;
};

}  // namespace airside::page
