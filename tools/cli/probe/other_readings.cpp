#include "tools/cli/probe/other_readings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "hal/points/point_names.hpp"
#include "hal/points/point_type_names.hpp"
#include "hal/points/register_codec.hpp"

namespace airside::tools {

namespace {

using hal::Endian;
using hal::Point;
using hal::PointType;

struct UsualValues {
  std::string_view stem;
  double least, most;
};
/// Narrower than the limits beyond which a value is refused: what an occupied building shows nearly always.
constexpr std::array<UsualValues, 8> usual_values = {{{"room_temp", 12, 35},
                                                      {"fcu_temp", 8, 40},
                                                      {"mau_temp", -5, 45},
                                                      {"outdoor_temp", -35, 48},
                                                      {"supply_temp", 5, 45},
                                                      {"setpoint", 8, 32},
                                                      {"zone_setpoint", 12, 35},
                                                      {"zone_heating_setpoint", 8, 30}}};
constexpr std::array<std::string_view, 10> not_judged = {
    "vav_on",  "fcu_on",          "rain",      "ahu_on",           "occupied",
    "clock_s", "clock_advance_s", "heartbeat", "device_heartbeat", "map_fingerprint"};

std::string cell_number(double value) { return fmt::format("{:.10g}", value); }
/// As points.csv will hold it, so that file and sheet agree to the bit.
double written(double value) { return std::strtod(cell_number(value).c_str(), nullptr); }

const hal::PointMap& every_point() {
  static const hal::PointMap map = hal::PointMap::parse(hal::default_point_map(1, 1, 1, {}, true), "built-in map");
  return map;
}

bool is_zero(const std::vector<std::uint16_t>& raw) {
  return std::ranges::all_of(raw, [](std::uint16_t word) { return word == 0; });
}

bool can_hold_limits(const Point& p) {
  Point raw = p;
  raw.sentinels = 0;
  return hal::encode(raw, p.min).has_value() && hal::encode(raw, p.max).has_value();
}

class Search {
 public:
  Search(const Point& stated, const ClaimedRegisters& claimed, ProbedDevice& device)
      : stated_(stated), claimed_(claimed), device_(device), usual_(usual_range(stated)) {}

  std::vector<OtherReading> run() {
    if (stated_.protocol == hal::Protocol::bacnet || stated_.is_bit()) {
      scales_and_units(stated_, 0);
    } else {
      places();
      types();
    }
    std::ranges::stable_sort(found_, {}, &OtherReading::changes);
    std::vector<OtherReading> once;
    for (const OtherReading& r : found_) {
      if (std::ranges::none_of(once, [&](const OtherReading& o) { return o.value == r.value; })) once.push_back(r);
    }
    return once;
  }

 private:
  void places() {
    for (const int step : {-1, 1}) {
      Point p = stated_;
      p.addr += step;
      if (p.addr >= 0 && p.addr + p.width() <= 65536) take(p, 1);
    }
    if (stated_.writable()) return;  // another function would not be written
    Point p = stated_;
    p.fc = p.fc == 3 ? 4 : 3;
    take(p, 1);
  }

  void types() {
    static constexpr std::array<PointType, 5> all = {PointType::int16, PointType::uint16, PointType::int32,
                                                     PointType::uint32, PointType::float32};
    for (const PointType type : all) {
      Point p = stated_;
      p.type = type;
      if (p.fc_write == 6 && p.width() == 2) p.fc_write = 16;
      const int changes = type == stated_.type ? 0 : 1;
      if (changes == 1) {
        if (type == PointType::float32) p.scale = 1, p.offset = 0;  // the stated ones were of whole numbers
        p.sentinels = 0;                                            // bits of another type
      }
      orders(p, changes);
    }
  }

  void orders(const Point& typed, int changes) {
    for (const Endian bytes : {Endian::big, Endian::little}) {
      for (const Endian words : {Endian::big, Endian::little}) {
        if (typed.width() == 1 && words != typed.word_order) continue;
        Point p = typed;
        p.byte_order = bytes;
        p.word_order = words;
        const bool changed = bytes != stated_.byte_order || words != stated_.word_order;
        // Half of all 16-bit numbers are a usual temperature in some scale: no second guess on exchanged bytes.
        if (changed && p.width() == 1) {
          if (changes == 0) take(p, 1);
          continue;
        }
        scales_and_units(p, changes + (changed ? 1 : 0));
      }
    }
  }

  void scales_and_units(const Point& p, int changes) {
    if (changes > 0) take(p, changes);
    for (const int power : {-3, -2, -1, 1, 2, 3}) {
      Point q = p;
      q.scale = written(p.scale * std::pow(10.0, power));
      take(q, changes + 1);
      units(q, changes + 1);
    }
    units(p, changes);
  }

  void units(const Point& p, int changes) {
    if (p.unit != "degc" || p.offset != 0.0) return;
    Point f = p;
    f.scale = written(p.scale * 5 / 9);
    f.offset = written(-32.0 * 5 / 9);
    take(f, changes + 1);
    Point k = p;
    k.offset = -273.15;
    take(k, changes + 1);
  }

  void take(const Point& p, int changes) {
    if (changes > 2 || !can_hold_limits(p)) return;
    const bool moved = p.fc != stated_.fc || p.addr != stated_.addr || p.width() > stated_.width();
    if (moved && claimed_.are_others_in(p, stated_)) return;
    if (device_.is_lost()) return;
    const auto raw = device_.read(p);
    if (!raw || is_zero(*raw)) return;
    Point narrow = p;
    narrow.min = usual_.least;
    narrow.max = usual_.most;
    if (!hal::makes_sense(narrow, *raw)) return;
    found_.push_back({p, *hal::decode(narrow, *raw), changes});
  }

  const Point& stated_;
  const ClaimedRegisters& claimed_;
  ProbedDevice& device_;
  PlausibleRange usual_;
  std::vector<OtherReading> found_;
};

}  // namespace

std::string stem_of_name(const std::string& name) {
  const auto placed = hal::placed_name(name);
  return placed ? std::string(placed->stem) : name;
}

PlausibleRange limits_of_name(const std::string& name) {
  const std::string stem = stem_of_name(name);
  const Point* p = every_point().find(stem);
  if (p == nullptr) p = every_point().find(stem + "_1");
  if (p == nullptr || hal::expected_unit(name) == nullptr) return {};
  return {p->min, p->max};
}

PlausibleRange usual_range(const Point& point) {
  PlausibleRange range = limits_of_name(point.name);
  const std::string stem = stem_of_name(point.name);
  for (const UsualValues& usual : usual_values) {
    if (usual.stem == stem) range = {usual.least, usual.most};
  }
  return {std::max(range.least, point.min), std::min(range.most, point.max)};
}

bool can_be_judged(const Point& point) {
  return hal::expected_unit(point.name) != nullptr &&
         std::ranges::find(not_judged, stem_of_name(point.name)) == not_judged.end();
}

ClaimedRegisters::ClaimedRegisters(const hal::PointMap& map) {
  for (const Point& p : map.points()) {
    for (int i = 0; i < p.width(); ++i) claimed_.insert({p.fc, p.addr + i});
  }
}

bool ClaimedRegisters::are_others_in(const Point& moved, const Point& stated) const {
  for (int addr = moved.addr; addr < moved.addr + moved.width(); ++addr) {
    const bool own = moved.fc == stated.fc && addr >= stated.addr && addr < stated.addr + stated.width();
    if (!own && claimed_.contains({moved.fc, addr})) return true;
  }
  return false;
}

std::vector<OtherReading> other_readings(const Point& stated, const ClaimedRegisters& claimed, ProbedDevice& device) {
  return Search(stated, claimed, device).run();
}

bool is_same_change(const OtherReading& a, const Point& stated_a, const OtherReading& b, const Point& stated_b) {
  const Point &p = a.point, &q = b.point;
  return p.type == q.type && p.byte_order == q.byte_order && p.word_order == q.word_order && p.scale == q.scale &&
         p.offset == q.offset && p.fc == q.fc && p.addr - stated_a.addr == q.addr - stated_b.addr;
}

std::vector<std::pair<std::string, std::string>> changed_cells(const Point& stated, const Point& other) {
  std::vector<std::pair<std::string, std::string>> cells;
  const auto order = [](Endian e) { return e == Endian::big ? "big" : "little"; };
  if (other.fc != stated.fc) cells.emplace_back("fc", std::to_string(other.fc));
  if (other.addr != stated.addr) cells.emplace_back("addr", std::to_string(other.addr));
  if (other.type != stated.type) {
    cells.emplace_back("type", hal::name_of(other.type));
    if (stated.sentinels > 0) cells.emplace_back("sentinel", "");
  }
  if (other.byte_order != stated.byte_order) cells.emplace_back("byte_order", order(other.byte_order));
  if (other.word_order != stated.word_order) cells.emplace_back("word_order", order(other.word_order));
  if (other.scale != stated.scale) cells.emplace_back("scale", cell_number(other.scale));
  if (other.offset != stated.offset) cells.emplace_back("offset", cell_number(other.offset));
  if (other.fc_write != stated.fc_write) cells.emplace_back("fc_write", std::to_string(other.fc_write));
  return cells;
}

std::string change_text(const Point& stated, const Point& other) {
  std::string text;
  for (const auto& [column, now] : changed_cells(stated, other)) {
    if (column == "sentinel" || column == "fc_write") continue;
    std::string before;
    for (const auto& [name, was] : changed_cells(other, stated)) {
      if (name == column) before = was;
    }
    text += fmt::format("{}{} {} -> {}", text.empty() ? "" : ", ", column, before, now);
  }
  if (other.offset != stated.offset) {
    text += other.offset == -273.15                     ? " (kelvin)"
            : stated.unit == "degc" && other.offset < 0 ? " (degrees Fahrenheit)"
                                                        : "";
  }
  return text;
}

}  // namespace airside::tools
