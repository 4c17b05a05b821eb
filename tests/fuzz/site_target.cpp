// Site files, point maps and the codec of registers: what is taken keeps every documented limit, and a value that goes
// to registers and back is the same value.

#include <algorithm>
#include <cmath>
#include <set>

#include "fuzz/target.hpp"
#include "hal/points/point_row.hpp"
#include "hal/points/register_codec.hpp"
#include "hal/site/site_file.hpp"
#include "hal/site/site_settings.hpp"

namespace airside::fuzz {
namespace {

bool within(double value, double min, double max) { return value >= min && value <= max; }

bool read_site(View input) {
  static const hal::SiteRules rules = hal::site_rules();
  return taken([&] {
    const hal::SiteFile site = hal::parse_site_text(text_of(input), "dir/site.toml", rules);
    FUZZ_CLAIM(!site.name.empty() && site.name.size() <= 64 && site.name.find('<') == std::string::npos);
    FUZZ_CLAIM(parse_shape(site.topology.c_str()).valid());
    FUZZ_CLAIM(within(site.room_temp_degc, 10, 40));
    FUZZ_CLAIM(site.work_start_s >= 0 && site.work_start_s < site.work_end_s && site.work_end_s <= 86400);
    FUZZ_CLAIM(site.setpoint_min_degc >= 5 && site.setpoint_min_degc < site.setpoint_max_degc);
    FUZZ_CLAIM(site.setpoint_max_degc <= 40 && site.setpoint_max_change_k > 0 && site.setpoint_round_k > 0);
    FUZZ_CLAIM(within(site.utc_offset_h, -12, 14) && within(site.daylight_saving, 0, 2));
    FUZZ_CLAIM(within(site.log_max_files, 2, 4000) && within(site.log_max_file_mb, 0.1, 1000));
    if (site.modbus) {
      const hal::ModbusSection& m = *site.modbus;
      FUZZ_CLAIM(within(m.port, 1, 65535) && within(m.unit_id, 0, 255) && m.deadline_s > 0 && m.deadline_s <= 10);
      FUZZ_CLAIM(m.transport == hal::ModbusTransport::tcp ? !m.host.empty() : !m.device.empty() && m.unit_id > 0);
    }
    for (const auto& [name, value] : site.overrides) {
      const auto rule = std::ranges::find(rules.settings, name, &hal::SettingRule::name);
      FUZZ_CLAIM(rule != rules.settings.end() && within(value, rule->min, rule->max));
    }
    taken([&] {
      const ControllerSettings s = hal::controller_settings(site);
      FUZZ_CLAIM(s.limit_min_degc < s.limit_max_degc && s.limit_change_k > 0);
    });
  });
}

std::vector<Bytes> site_seeds() {
  return {
      bytes_of(hal::example_site_text("5vav-5fcu-2power")),
      bytes_of("[site]\nname = \"A\"\ntopology = \"3vav-0fcu-1power\"\n"),
      bytes_of("[site]\nname=\"A\"\ntopology=\"5vav-5fcu-2power\"\n[target]\nwork_start=\"07:00\"\nwork_end=19:00:00\n"
               "[controller]\npreset='paper'\nseed=3\n[controller.override]\nbatch = 32\n"),
      bytes_of("[site]\nname=\"A\"\ntopology=\"5vav-5fcu-2power\"\n[modbus]\ntransport=\"rtu\"\ndevice=\"/dev/ttyS0\"\n"
               "baud=9600\nparity=\"N\"\npoints=\"p.csv\"\n[twin]\nmodel=\"rc\"\npatches=[\"a\",\"b\"]\n")};
}

std::vector<std::string> site_words() {
  return {"[site]",   "[target]",  "[setpoint]", "[expert]",   "[controller]", "[controller.override]",
          "[modbus]", "[clock]",   "[state]",    "[log]",      "[history]",    "[weights]",
          "[inbox]",  "[twin]",    "name",       "topology",   "scope",        "seed",
          "preset",   "transport", "points",     "= ",         "\"\"\"",       "true",
          "inf",      "nan",       "1e308",      "0x7FFFFFFF", "07:00",        "[[",
          "{a=",      "24:00",     "\\u0000",    "unit_id",    "deadline_s",   "model",
          "patches",  "min_degc",  "max_degc",   "round_k",    "max_change_k", "9223372036854775807"};
}

// ---- point maps

/// Values of a point that its registers hold come back as they are, others as the nearest that do.
void check_point(const hal::Point& p) {
  FUZZ_CLAIM(!p.name.empty() && p.fc >= 1 && p.fc <= 4 && p.addr >= 0 && p.addr + p.width() <= 65536);
  FUZZ_CLAIM(std::isfinite(p.scale) && p.scale != 0 && std::isfinite(p.offset));
  FUZZ_CLAIM(std::isfinite(p.min) && std::isfinite(p.max) && p.min <= p.max);
  FUZZ_CLAIM(p.max_rate_per_min > 0 && p.stale_s > 0 && p.sentinels <= hal::max_sentinels);
  FUZZ_CLAIM(!p.writable() || p.fc == 1 || p.fc == 3);
  FUZZ_CLAIM(p.writable() == (p.write_policy != hal::WritePolicy::none));
  if (!std::isnan(p.default_value)) {
    FUZZ_CLAIM(within(p.default_value, p.min, p.max) && hal::encode(p, p.default_value));
  }
  FUZZ_CLAIM(!hal::decode(p, hal::invalid_registers(p).used()) || p.sentinels == 0);
}

bool read_points(View input) {
  return taken([&] {
    const hal::PointMap map = hal::PointMap::parse(text_of(input), "points.csv");
    FUZZ_CLAIM(!map.points().empty());
    std::set<std::string> names;
    std::set<std::pair<int, int>> registers;
    for (const hal::Point& p : map.points()) {
      FUZZ_CLAIM(names.insert(p.name).second);
      for (int i = 0; i < p.width(); ++i) FUZZ_CLAIM(registers.emplace(p.fc, p.addr + i).second);
      check_point(p);
    }
    FUZZ_CLAIM(std::isfinite(map.told_fingerprint()));
    taken([&] {
      map.check_topology(1, 0, 1);
      FUZZ_CLAIM(map.find("setpoint") != nullptr && map.at("setpoint").writable());
    });
  });
}

std::vector<Bytes> point_seeds() {
  const std::string header =
      "name,unit,fc,addr,type,byte_order,word_order,scale,offset,min,max,max_rate,stale_s,sentinel,write_policy,"
      "fc_write,default,readback\n";
  return {bytes_of(hal::default_point_map(1, 0, 1)), bytes_of(hal::default_point_map(1, 1, 1)),
          bytes_of(header + "setpoint,degc,3,0,int16,,,0.1,0,5,40,,,0x8000 -1,on-change,6,20,self\n"),
          bytes_of(header + "rain,,2,7,discrete,,,,,,,,,,,,,\nx,\"a,b\",4,65534,float32,little,little,1,0,-1,1,2,60,"
                            "1.5;2,,,,\n")};
}

std::vector<std::string> point_words() {
  return {
      "name,unit,fc,addr,type,byte_order,word_order,scale,offset,min,max,max_rate,stale_s,sentinel,write_policy,"
      "fc_write,default,readback",
      "room_temp_1",
      "setpoint",
      "map_fingerprint",
      "clock_s",
      "clock_advance_s",
      "heartbeat",
      "rain",
      "degc",
      "coil",
      "discrete",
      "int16",
      "uint16",
      "int32",
      "uint32",
      "float32",
      "big",
      "little",
      "on-change",
      "refresh",
      "self",
      "none",
      "0x8000",
      "0xFFFF",
      "-32768",
      "65535",
      "1e308",
      "4294967295",
      "0.01",
      ",,,",
      "#"};
}

// ---- registers

/// A point as a map may hold one, and two registers.
bool code_registers(View input) {
  Cursor in(input);
  hal::Point p;
  p.type = static_cast<hal::PointType>(in.byte() % 7);
  const unsigned orders = in.byte();
  p.byte_order = (orders & 1) != 0 ? hal::Endian::little : hal::Endian::big;
  p.word_order = (orders & 2) != 0 ? hal::Endian::little : hal::Endian::big;
  static constexpr double scales[] = {1, 0.1, 0.01, 0.5, -1, 10, 100, 0.001};
  p.scale = p.is_bit() ? 1 : scales[in.byte() % 8];
  p.offset = p.is_bit() ? 0 : static_cast<double>(in.byte()) - 128;
  p.sentinels = static_cast<int>(in.byte() % (hal::max_sentinels + 1));
  for (int i = 0; i < p.sentinels; ++i) {
    const unsigned bits = in.word() << 16 | in.word();
    p.sentinel[static_cast<std::size_t>(i)] = p.width() == 2 ? bits : bits & 0xFFFF;
  }
  p.min = -1e6, p.max = (orders & 4) != 0 ? 1e6 : 1e12;
  const std::uint16_t words[2] = {static_cast<std::uint16_t>(in.word()), static_cast<std::uint16_t>(in.word())};
  const auto count = static_cast<std::size_t>(p.width());
  FUZZ_CLAIM(!hal::decode(p, std::span(words).first(count - 1)));
  const Expected<double> value = hal::decode(p, std::span(words).first(count));
  if (!value) return false;
  const double slack = p.type == hal::PointType::float32 ? 0.0 : 0.5 * std::abs(p.scale);
  FUZZ_CLAIM(std::isfinite(*value) && within(*value, p.min - slack, p.max + slack));
  const auto again = hal::encode(p, *value);
  FUZZ_CLAIM(again.has_value() || p.sentinels > 0 || p.type == hal::PointType::float32);
  if (!again) return true;
  if (p.is_bit()) {
    FUZZ_CLAIM(again->word[0] == (words[0] != 0 ? 1 : 0));
  } else if (p.type != hal::PointType::float32) {
    for (std::size_t i = 0; i < count; ++i) FUZZ_CLAIM(again->word[i] == words[i]);
  } else {
    const double rounded = hal::rounded(p, *value);
    FUZZ_CLAIM(std::isnan(rounded) || std::abs(rounded - *value) <= 1e-4 * std::max(1.0, std::abs(*value)));
  }
  return true;
}

std::vector<Bytes> register_seeds() {
  std::vector<Bytes> all;
  for (std::uint8_t type = 0; type < 7; ++type) all.push_back({type, 0, 2, 128, 1, 0, 0, 0x80, 0, 0x41, 0x20, 0, 1});
  return all;
}

}  // namespace

const Target site_file{"site_file", 8192, read_site, nullptr, site_seeds, site_words};
const Target point_map{"point_map", 2048, read_points, nullptr, point_seeds, point_words};
const Target register_codec{"register_codec", 32, code_registers, nullptr, register_seeds, nullptr};

}  // namespace airside::fuzz
