#include "firmware/page/data/trend_store.hpp"

#include <sys/stat.h>

#include <Eigen/Core>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <span>
#include <utility>

#include "airside/demand/zone_comfort.hpp"
#include "airside/supervision/mode_table.hpp"
#include "airside/supervision/schedule.hpp"
#include "firmware/page/data/state_folder.hpp"
#include "hal/log/side_places.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_log.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/storage/folder_names.hpp"
#include "hal/text/input_error.hpp"

namespace airside::page {
namespace {

constexpr std::uint64_t max_file_bytes = std::uint64_t{1} << 30;

/// `airside-2021-07-01.csv`, or `airside-2021-07-01_01.csv`; in the order of their names they follow one another.
bool is_log_name(std::string_view name) {
  return name.starts_with("airside-") && name.ends_with(".csv") && (name.size() == 22 || name.size() == 25);
}

std::int8_t mode_of(std::string_view name) {
  for (std::int8_t m = 0; m < 4; ++m) {
    if (name == text_of(static_cast<ControlMode>(m))) return m;
  }
  return -1;
}

std::uint8_t reason_of(std::string_view name) {
  for (const ModeRequest& row : mode_table) {
    if (name == row.name) return static_cast<std::uint8_t>(row.reason);
  }
  return 0;
}

}  // namespace

TrendStore::TrendStore(const hal::SiteFile& site)
    : counts_(hal::counts_of(parse_shape(site.topology.c_str()))),
      settings_(hal::controller_settings(site)),
      held_(site.held),
      dir_(site.log_dir),
      target_degc_(site.room_temp_degc) {
  if (site.modbus) {
    try {
      counts_ = hal::counts_of(counts_, hal::PointMap::load(site.modbus->points), site.stand_ins);
    } catch (const hal::InputError& unread) {  // the daemon's affair; what else the page shows needs no point map
      trouble_ = unread.what();
    }
  }
  cooling_ = hal::side_places(counts_, hal::SideSignal::zone_setpoint);
  heating_ = hal::side_places(counts_, hal::SideSignal::zone_heating_setpoint);
  zones_.cooling_degc.resize(cooling_.size());
  zones_.heating_degc.resize(heating_.size());
  const int first_power = 2 * counts_.vavs + 2 * counts_.fcus;
  for (int i = 0; i < counts_.powers; ++i) has_meters_ = has_meters_ || !counts_.stand_in(first_power + i);
}

std::uint64_t TrendStore::from(CivilTime t) const {
  std::uint64_t low = first(), high = count_;
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    if (row(middle).time < t) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

void TrendStore::begin_anew() {
  ++generation_;
  count_ = 0;
  file_.clear();
  header_.clear();
  offset_ = 0;
}

/// The file after the one that is being read; the first one is far enough before the newest for a month.
std::optional<std::string> TrendStore::next_file() const {
  constexpr std::size_t files_of_a_month = 40;
  const auto folder = hal::StorageFile::open_existing_dir(dir_.c_str());
  if (!folder) return {};
  std::vector<std::string> names;
  (void)hal::for_each_name(folder->descriptor(), [&](const char* name) {
    if (is_log_name(name) && name > file_) names.emplace_back(name);
    return names.size() < 10000;
  });
  std::ranges::sort(names);
  if (names.empty()) return {};
  return file_.empty() && names.size() > files_of_a_month ? names[names.size() - files_of_a_month] : names.front();
}

bool TrendStore::read_some() {
  std::uint64_t size = 0;
  const hal::StorageFile file = open_in(dir_, file_.c_str(), max_file_bytes, size);
  if (!file.is_open()) return false;
  if (size < offset_) {  // cut after a crash, or another one
    begin_anew();
    return true;
  }
  const std::uint64_t left = size - offset_;
  if (left == 0) return false;
  std::string text(static_cast<std::size_t>(std::min<std::uint64_t>(left, step_bytes)), '\0');
  const auto got = file.read_at(std::as_writable_bytes(std::span(text)), offset_, "read log");
  if (!got) return false;
  text.resize(*got);
  const std::size_t end = text.rfind('\n');
  if (end == std::string::npos) return false;  // a row that is still being written
  text.resize(end + 1);
  offset_ += text.size();
  if (header_.empty()) {
    const std::size_t line = text.find('\n') + 1;
    header_ = text.substr(0, line);
    text.erase(0, line);
  }
  if (text.empty()) return offset_ < size;
  try {
    take(hal::read_log_text(header_ + text, dir_ + "/" + file_, counts_, {.keep_missing = true}));
  } catch (const hal::InputError& unread) {  // left out; the log command says all of it
    trouble_ = unread.what();
  }
  return offset_ < size;
}

/// The file that is being read is gone, or the whole folder is another one: a log that was moved away, as one from the
/// future has to be. Its rows would keep those of the log that follows it out.
bool TrendStore::is_moved_away() {
  struct stat folder {
  }, file{};
  const bool is_there = ::stat(dir_.c_str(), &folder) == 0;
  const std::uint64_t inode = is_there ? static_cast<std::uint64_t>(folder.st_ino) : 0;
  const std::uint64_t before = std::exchange(folder_inode_, inode);
  if (file_.empty()) return false;
  return inode != before || (::lstat((dir_ + "/" + file_).c_str(), &file) != 0 && errno == ENOENT);
}

bool TrendStore::step() {
  if (rows_.empty()) {
    rows_.resize(capacity);
    rooms_.resize(capacity * static_cast<std::size_t>(counts_.vavs));
  }
  if (is_moved_away()) begin_anew();
  bool more = !file_.empty() && read_some();
  if (!more) {
    if (const auto next = next_file()) {
      file_ = *next;
      header_.clear();
      offset_ = 0;
      more = true;
    }
  }
  is_reading_ = more;
  return more;
}

void TrendStore::take(const hal::Log& log) {
  for (const hal::LogRow& row : log.rows) {
    if (count_ == 0 || row.time > this->row(count_ - 1).time) add(row);
  }
}

void TrendStore::add(const hal::LogRow& from) {
  const std::size_t at = static_cast<std::size_t>(count_ % capacity);
  const int n = counts_.vavs;
  TrendRow row;
  row.time = from.time;
  const Eigen::Map<const Eigen::VectorXd> rooms(from.value.data(), n), on(from.value.data() + n + counts_.fcus, n);
  float* kept = rooms_.data() + at * static_cast<std::size_t>(n);
  for (int i = 0; i < n; ++i) {
    kept[i] = static_cast<float>(rooms(i));
    row.low_degc = std::fmin(row.low_degc, kept[i]);
    row.high_degc = std::fmax(row.high_degc, kept[i]);
  }
  row.held_degc = static_cast<float>(held_of(held_, rooms, on));
  row.setpoint_degc = static_cast<float>(from.setpoint_degc);
  row.supply_degc = static_cast<float>(from.supply_temp_degc);
  const int first_power = 2 * n + 2 * counts_.fcus;
  if (has_meters_) row.power_kw = 0;
  for (int i = 0; i < counts_.powers; ++i) {
    if (counts_.stand_in(first_power + i)) continue;  // nobody measured it
    // Where one meter is lost the sum is: the others alone would pass for a saving.
    row.power_kw += static_cast<float>(from.value[static_cast<std::size_t>(first_power + i)]);
  }
  const int outdoor = first_power + counts_.powers + 1;
  if (!counts_.stand_in(outdoor)) {
    row.outdoor_degc = static_cast<float>(from.value[static_cast<std::size_t>(outdoor)]);
  }
  row.schedule_degc = static_cast<float>(from.controller.a_expert_degc);
  row.g36_degc = static_cast<float>(from.controller.a_g36_degc);
  row.confidence = static_cast<float>(from.controller.confidence);
  row.expected_degc = static_cast<float>(from.controller.expected_held_degc);
  row.mode = mode_of(from.controller.mode);
  row.reason = reason_of(from.controller.reason);
  row.working_hours = in_working_hours(settings_, from.time);
  add_zones(from, row);
  rows_[at] = row;
  ++count_;
}

void TrendStore::add_zones(const hal::LogRow& from, TrendRow& row) {
  zones_.time = from.time;
  const auto is_off = [&](hal::SideSignal signal) { return hal::side_of(counts_, from, signal) == 0; };
  const bool counts = !is_off(hal::SideSignal::occupied) && !is_off(hal::SideSignal::ahu_on);
  const auto sum_over = [&](const std::vector<std::size_t>& places, std::vector<float>& kept, auto beyond_k) {
    bool known = false;
    double sum_k = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double degc = from.side[places[i]];
      kept[i] = static_cast<float>(degc);
      known = known || std::isfinite(degc);
      sum_k += beyond_k(from.value[i], degc);
    }
    return counts && known ? static_cast<float>(sum_k) : TrendRow::none;
  };
  row.too_warm_k = sum_over(cooling_, zones_.cooling_degc, too_warm_k);
  row.too_cold_k = sum_over(heating_, zones_.heating_degc, too_cold_k);
}

}  // namespace airside::page
