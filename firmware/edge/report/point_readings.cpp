#include "firmware/edge/report/point_readings.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>
#include <string_view>
#include <utility>

#include "airside/fault.hpp"
#include "firmware/edge/report/fixed_text.hpp"
#include "firmware/edge/report/say.hpp"
#include "hal/points/register_codec.hpp"
#include "hal/storage/storage_file.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::edge {
namespace {

std::vector<hal::Point> readable(const hal::PointMap& map) {
  std::vector<hal::Point> points;
  for (const hal::Point& point : map.points()) {
    if (point.readable()) points.push_back(point);
  }
  return points;
}

constexpr std::size_t head_bytes = 320, bytes_a_point = 128;  ///< beside the name

std::size_t most_bytes(const std::vector<hal::Point>& points) {
  std::size_t bytes = head_bytes;
  for (const hal::Point& point : points) bytes += bytes_a_point + point.name.size();
  return bytes;
}

}  // namespace

PointReadings::PointReadings(const hal::PointMap& map, std::string inbox_dir, std::string state_dir)
    : inbox_dir_(std::move(inbox_dir)),
      state_dir_(std::move(state_dir)),
      points_(readable(map)),
      readings_(points_.size()),
      text_(most_bytes(points_)) {}

PointReadings::Wish PointReadings::look(const char* name) const {
  if (inbox_dir_.empty() || state_dir_.empty()) return {};
  const auto inbox = hal::StorageFile::open_existing_dir(inbox_dir_.c_str(), hal::FolderLink::refused);
  struct stat status {};
  if (!inbox || ::fstatat(inbox->descriptor(), name, &status, AT_SYMLINK_NOFOLLOW) != 0) return {};
  return S_ISREG(status.st_mode) ? Wish{status.st_ino, status.st_ctim} : Wish{};
}

/// A wish on a medium that has become read-only stays for ever; a setpoint must not be written for it at each
/// heartbeat.
bool PointReadings::waits(const char* name, const Wish& done) const {
  const Wish seen = look(name);
  return seen.inode != 0 && !(seen == done);
}

bool PointReadings::wanted() const { return waits(wish_name, read_wish_) || waits(write_wish_name, write_wish_); }

bool PointReadings::take_write_wish() {
  const bool waiting = waits(write_wish_name, write_wish_);
  if (waiting) write_wish_ = look(write_wish_name);
  return waiting;
}

void PointReadings::note(const hal::WriteCheck& check, CivilTime now) {
  check_ = check;
  checked_ = now;
}

/// False: the link gave no answer.
bool PointReadings::read_one(hal::ModbusLink& link, std::size_t i) {
  const hal::Point& point = points_[i];
  Reading& reading = readings_[i];
  const std::span<std::uint16_t> words(reading.raw.data(), static_cast<std::size_t>(point.width()));
  const hal::LinkResult<void> got = link.read(point.fc, point.addr, words);
  if (!got) {
    reading.exception = got.error().exception;
    return got.error().error == hal::LinkError::exception_answer;
  }
  const Expected<double> decoded = hal::decode(point, words);
  reading.fault = decoded ? Fault::none : decoded.error();
  reading.has_raw = true;
  return true;
}

std::size_t PointReadings::format(CivilTime now) {
  FixedText text(text_);
  std::array<char, hal::civil_text_size> time{};
  hal::write_civil_text(time.data(), now);
  text.add("{{\"time\":\"{}\",\"points\":[", std::string_view(time.data(), time.size()));
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Reading& reading = readings_[i];
    text.add("{}{{\"raw\":[", i == 0 ? "" : ",");
    if (reading.has_raw) text.add("{}", reading.raw[0]);
    if (reading.has_raw && points_[i].width() == 2) text.add(",{}", reading.raw[1]);
    text.add("]");
    text.string("name", points_[i].name);
    text.string("fault", text_of(reading.fault));
    text.count("exception", reading.exception);
    text.add("}}");
  }
  text.add("]");
  if (check_) {
    hal::write_civil_text(time.data(), checked_);
    text.add(",\"write\":{{\"time\":\"{}\"", std::string_view(time.data(), time.size()));
    text.string("fault", text_of(check_->fault));
    text.number("before", check_->before);
    text.number("sent", check_->sent);
    text.number("taken", check_->taken);
    text.number("restored", check_->restored);
    text.add("}}");
  }
  text.add("}}\n");
  return text.fits() ? text.size() : 0;
}

bool PointReadings::write(std::size_t bytes) const {
  constexpr const char* staged = "points.json.new";
  const auto folder = hal::StorageFile::open_existing_dir(state_dir_.c_str());
  if (bytes == 0 || !folder) return false;
  const int dir = folder->descriptor();
  const auto file = hal::StorageFile::open(dir, staged, true, "open points");
  if (!file) return false;
  if (!file->write_at(std::as_bytes(std::span(text_).first(bytes)), 0, "write points")) return false;
  if (!file->truncate(bytes, "cut points")) return false;
  return ::renameat(dir, staged, dir, file_name) == 0;
}

void PointReadings::read(hal::ModbusLink& link, CivilTime now, bool answers) {
  std::ranges::fill(readings_, Reading{});
  read_wish_ = look(wish_name);
  for (std::size_t i = 0; answers && i < points_.size(); ++i) answers = read_one(link, i);
  const bool written = write(format(now));
  if (!written && !said_) say("{} cannot be written in {}; look into that folder", file_name, state_dir_);
  said_ = !written;
  if (const auto inbox = hal::StorageFile::open_existing_dir(inbox_dir_.c_str(), hal::FolderLink::refused)) {
    if (look(wish_name) == read_wish_) (void)::unlinkat(inbox->descriptor(), wish_name, 0);
    if (look(write_wish_name) == write_wish_) (void)::unlinkat(inbox->descriptor(), write_wish_name, 0);
  }
}

}  // namespace airside::edge
