#include "hal/modbus/plant_clock.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>

#include "hal/points/register_codec.hpp"

namespace airside::hal {
namespace {

constexpr std::int64_t slice_ns = 100'000'000;

std::int64_t utc_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
}

/// Of standard time, also while daylight saving is in force: the smallest that holds for three months of this year. The
/// zone's own word for it will not do, since Ireland's standard time is that of summer. A clock that is not set asks
/// for the rules of 2024.
int machine_utc_offset_s() {
  constexpr int least_months = 3, least_year = 2024;
  const std::time_t now = ::time(nullptr);
  std::tm today{};
  gmtime_r(&now, &today);
  std::array<int, 12> offsets{};
  for (std::size_t month = 0; month < offsets.size(); ++month) {
    std::tm day{};
    day.tm_year = std::max(today.tm_year, least_year - 1900);
    day.tm_mon = static_cast<int>(month);
    day.tm_mday = 15;
    const std::time_t at = timegm(&day);
    localtime_r(&at, &day);
    offsets[month] = static_cast<int>(day.tm_gmtoff);
  }
  std::sort(offsets.begin(), offsets.end());
  for (const int offset : offsets) {
    if (std::count(offsets.begin(), offsets.end(), offset) >= least_months) return offset;
  }
  return offsets.back();
}

}  // namespace

bool sleep_until_ns(std::int64_t deadline_ns, const StopFlag& stop) {
  while (!stop.raised()) {
    const std::int64_t left = deadline_ns - monotonic_ns();
    if (left <= 0) return true;
    const timespec slice = {0, static_cast<long>(std::min(left, slice_ns))};
    nanosleep(&slice, nullptr);
  }
  return false;
}

SystemClock::SystemClock(StopFlag stop, std::optional<int> utc_offset_s, double speed)
    : stop_(stop),
      utc_offset_s_(utc_offset_s ? *utc_offset_s : machine_utc_offset_s()),
      speed_(speed),
      began_wall_ns_(utc_ns()),
      began_ns_(monotonic_ns()) {}

void SystemClock::go_on_from(CivilTime t) {
  if (speed_ == 1.0 || now() >= t) return;
  began_wall_ns_ = (t.seconds - utc_offset_s_) * 1'000'000'000;
  began_ns_ = monotonic_ns();
}

std::int64_t SystemClock::site_ns() const {
  const std::int64_t offset_ns = std::int64_t{utc_offset_s_} * 1'000'000'000;
  if (speed_ == 1.0) return utc_ns() + offset_ns;
  return began_wall_ns_ + offset_ns + std::llround(static_cast<double>(monotonic_ns() - began_ns_) * speed_);
}

CivilTime SystemClock::now() const { return CivilTime{site_ns() / 1'000'000'000}; }

ModbusPlantClock::ModbusPlantClock(const PointMap& map, ModbusLink& link, StopFlag stop, double stall_s)
    : clock_(map.at("clock_s")), advance_(map.at("clock_advance_s")), link_(&link), stop_(stop), stall_s_(stall_s) {}

bool ModbusPlantClock::take(CivilTime reading) {
  const auto is_near = [reading](CivilTime least, CivilTime most) {
    return reading.seconds >= least.seconds - leap_s && reading.seconds <= most.seconds + leap_s;
  };
  if (known_ && is_near(last_, std::max(last_, wanted_))) {
    if (confirming_ > 0) {
      ++jumps_.doubted;
      jumps_.from = last_;
      jumps_.to = jump_;
    }
    confirming_ = strange_ = 0;
    last_ = reading;
    return true;
  }
  const std::int64_t now_ns = monotonic_ns();
  if (strange_++ == 0) strange_since_ns_ = now_ns;
  const bool never_steady = strange_ > confirmations && now_ns - strange_since_ns_ >= to_ns(give_in_s);
  if (never_steady) {
    confirming_ = confirmations + 1;
  } else if (confirming_ == 0 || reading < jump_ || reading.seconds > jump_.seconds + leap_s) {
    confirming_ = 1;  // the first of its kind
  } else if (now_ns - jump_ns_ >= to_ns(known_ ? confirm_every_s : 0.01)) {
    ++confirming_;
  } else {
    return false;
  }
  jump_ = reading;
  jump_ns_ = now_ns;
  if (confirming_ <= confirmations) return false;
  if (known_) {
    ++jumps_.taken;
    jumps_.from = last_;
    jumps_.to = reading;
  }
  known_ = true;
  confirming_ = strange_ = 0;
  last_ = wanted_ = reading;
  return true;
}

bool ModbusPlantClock::read_clock() {
  std::array<std::uint16_t, 2> words{};
  if (!link_->read(clock_.fc, clock_.addr, words)) return false;
  const Expected<double> seconds = decode(clock_, words);
  if (!seconds) return false;
  return take(CivilTime{clock_epoch.seconds + std::llround(*seconds)});
}

bool ModbusPlantClock::request(CivilTime t) {
  const auto registers = encode(advance_, static_cast<double>(t.seconds - clock_epoch.seconds));
  wanted_ = t;
  return registers && link_->write(advance_.fc_write, advance_.addr, registers->used()).has_value();
}

CivilTime ModbusPlantClock::now() {
  read_clock();
  // A clock that never reads the same twice is believed at its last word: there is nothing better.
  for (int more = 0; !known_ && confirming_ > 0 && more < 5 * confirmations; ++more) {
    if (!sleep_until_ns(monotonic_ns() + 11'000'000, stop_)) break;
    read_clock();
  }
  if (!known_ && confirming_ > 0) {
    known_ = true;
    last_ = wanted_ = jump_;
    confirming_ = strange_ = 0;
  }
  return last_;
}

bool ModbusPlantClock::sleep_until(CivilTime t) {
  stalled_ = set_back_ = false;
  if (!known_) now();
  CivilTime seen = last_;
  std::int64_t give_up_ns = monotonic_ns() + to_ns(stall_s_);
  std::int64_t pause_ns = 500'000;
  bool requested = false;
  std::uint64_t generation = link_->generation();
  while (!stop_.raised()) {
    set_back_ = known_ && t.seconds - last_.seconds > longest_wait_s;
    if (set_back_) return false;
    if (!requested || generation != link_->generation()) {
      requested = request(t);  // again after a reconnect: the server may be a new one
      generation = link_->generation();
    }
    if (read_clock() && last_ >= t) return true;
    if (last_ != seen) {
      seen = last_;
      give_up_ns = monotonic_ns() + to_ns(stall_s_);
    }
    if (monotonic_ns() >= give_up_ns) {
      stalled_ = true;
      return false;
    }
    if (!sleep_until_ns(monotonic_ns() + pause_ns, stop_)) return false;
    pause_ns = std::min(2 * pause_ns, slice_ns);
  }
  return false;
}

}  // namespace airside::hal
