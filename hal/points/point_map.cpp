#include "hal/points/point_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include "hal/points/bacnet_row.hpp"
#include "hal/points/point_names.hpp"
#include "hal/points/point_row.hpp"
#include "hal/text/foreign_text.hpp"
#include "hal/text/toml_section.hpp"

namespace airside::hal {
namespace {

constexpr std::size_t max_file_bytes = std::size_t{1} << 20;
constexpr std::size_t max_points = 2000;

void check_unit(const PointRow& row, const Point& p) {
  const char* expected = expected_unit(p.name);
  if (expected == nullptr || p.unit == expected) return;
  constexpr std::array<std::string_view, 8> celsius = {"degC", "DEGC", "°C", "C", "c", "celsius", "Celsius", "deg C"};
  const bool other_spelling =
      expected == std::string_view("degc") && std::ranges::find(celsius, p.unit) != celsius.end();
  const std::string remedy =
      other_spelling ? "write degc" : "convert with scale and offset (0.5556 and -17.78 turn degF into degc)";
  row.complain("unit", p.unit.empty() ? "an empty cell" : "\"" + p.unit + "\"",
               expected[0] == '\0' ? "an empty cell, since " + p.name + " is a pure number"
                                   : fmt::format("\"{}\" for {}", expected, p.name),
               remedy);
}

void check_known_point(const PointRow& row, const Point& p) {
  if (p.name == "setpoint" && !p.writable()) {
    row.complain("fc_write", "an empty cell", "5, 6 or 16, since the setpoint is what gets written",
                 "give fc_write and write_policy");
  }
  if (p.name == "clock_advance_s" && !p.writable()) {
    row.complain("fc_write", "an empty cell", "16, since the clock request is written",
                 "give fc_write and write_policy");
  }
  if ((p.name == "clock_s" || p.name == "clock_advance_s") && p.type != PointType::int32) {
    row.complain("type", "\"" + row["type"] + "\"", "int32, seconds since 2000-01-01 00:00", "correct type");
  }
}

/// One complaint a row at most; of rows that are not in order the names alone are compared.
void check_duplicates(const PointMap& map, const std::vector<bool>& is_sound, std::vector<InputError>& complaints) {
  const std::vector<Point>& points = map.points();
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Point &p = points[i], &q = points[j];
      if (p.name == q.name && !p.name.empty()) {
        complaints.emplace_back(fmt::format("{}:{}, column name", map.file(), p.line),
                                fmt::format("\"{}\" again, first on line {}", p.name, q.line), "each name once",
                                "rename or remove one of the two rows");
        break;
      }
      if (is_sound[i] && is_sound[j] && p.fc == q.fc && p.addr < q.addr + q.width() && q.addr < p.addr + p.width()) {
        complaints.emplace_back(fmt::format("{}:{}, column addr", map.file(), p.line),
                                fmt::format("fc {} addr {}..{}, which overlaps {} at {}..{} (line {})", p.fc, p.addr,
                                            p.addr + p.width() - 1, q.name, q.addr, q.addr + q.width() - 1, q.line),
                                "each register in one point", "correct one of the two addresses or types");
        break;
      }
    }
  }
}

void check_readbacks(const PointMap& map, const std::vector<bool>& is_sound, std::vector<InputError>& complaints) {
  std::vector<std::string> names;
  for (const Point& p : map.points()) names.push_back(p.name);
  for (std::size_t i = 0; i < is_sound.size(); ++i) {
    const Point& p = map.points()[i];
    if (!is_sound[i] || p.readback == "self" || p.readback == "none") continue;
    const int at = map.index_of(p.readback);
    const Point* target = map.find(p.readback);
    if (target != nullptr && target != &p && target->readable() && target->unit == p.unit) continue;
    if (at >= 0 && !is_sound[static_cast<std::size_t>(at)]) continue;
    const std::string near = target == nullptr ? nearest_name(p.readback, names) : "";
    complaints.emplace_back(
        fmt::format("{}:{}, column readback", map.file(), p.line), "\"" + p.readback + "\"",
        "self, none, or another point of the map that can be read and has the same unit",
        near.empty() ? "name the point that shows what the device took" : "did you mean \"" + near + "\"?");
  }
}

/// Position in the file of each of point_columns.
std::array<std::size_t, point_columns.size()> read_header(const std::vector<std::string>& cells, std::string_view file,
                                                          int line) {
  std::array<std::size_t, point_columns.size()> position{};
  position.fill(cells.size());
  const std::string place = fmt::format("{}:{}, header", file, line);
  if (cells.size() == 1) refuse_other_separator(cells.front(), place);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto known = std::ranges::find_if(point_columns, [&](const char* name) { return cells[i] == name; });
    if (known == point_columns.end()) {
      throw InputError(place, "column \"" + cells[i].substr(0, 60) + "\"",
                       fmt::format("only {}", fmt::join(point_columns, ", ")), "correct or remove the column");
    }
    std::size_t& at = position[static_cast<std::size_t>(known - point_columns.begin())];
    if (at != cells.size())
      throw InputError(place, "column \"" + cells[i] + "\" twice", "each column once", "remove one");
    at = i;
  }
  const bool may_lack = position[modbus_columns] != cells.size();  // rows that lack something needed say so themselves
  for (std::size_t i = 0; i < modbus_columns; ++i) {
    if (position[i] == cells.size() && !may_lack) {
      throw InputError(place, fmt::format("no column \"{}\"", point_columns[i]),
                       fmt::format("all of {}", modbus_header()),
                       "add the column; its cells may be empty where nothing applies");
    }
  }
  return position;
}

std::uint64_t fnv1a(std::uint64_t hash, std::string_view text) {
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ULL;
  return hash;
}

}  // namespace

std::string point_name(SignalId id) {
  const char* stem = text_of(id.kind).name;
  return id.place == 0 ? std::string(stem) : fmt::format("{}_{}", stem, id.place);
}

namespace {

/// At most 1 MiB and a byte of a file.
std::string text_of_map(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    throw InputError(path, std::string("no readable file (") + std::strerror(errno) + ")", "a point map in CSV",
                     "check the path, or start from the one that `airside init` writes");
  }
  // In pieces: malloc, once it has given back a buffer of the largest size, keeps smaller ones for good.
  std::string text;
  std::array<char, 4096> piece{};
  while (text.size() <= max_file_bytes && in) {
    in.read(piece.data(), static_cast<std::streamsize>(std::min(piece.size(), max_file_bytes + 1 - text.size())));
    text.append(piece.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad() || (in.fail() && !in.eof())) {
    throw InputError(path, "a read error", "a regular file", "check the path and the disk");
  }
  return text;
}

/// The columns of a map, once its header was read.
struct Columns {
  std::array<std::size_t, point_columns.size()> position{};
  std::size_t count = 0;  ///< 0: no header yet
};

void refuse_nul(std::string_view content, const std::string& file, int line) {
  if (content.find('\0') == std::string_view::npos) return;
  throw InputError(fmt::format("{}:{}", file, line), "a NUL byte", "plain text", "save the file as UTF-8 CSV");
}

/// One row; where it cannot even be cut into cells, a Point of what looks like its name.
Point read_row(std::string_view content, const std::string& file, int line, const Columns& columns, std::size_t index,
               std::vector<InputError>& complaints) {
  Point p;
  p.line = line;
  PointRow row{file, line, {}};
  const bool is_cut = keeps_complaint(complaints, [&] {
    if (columns.position[0] == 0) p.name = content.substr(0, content.find(','));
    refuse_nul(content, file, line);
    const std::vector<std::string> cells = split_csv_line(content, file, line);
    if (columns.position[0] < cells.size()) p.name = cells[columns.position[0]];
    if (cells.size() != columns.count) {
      throw InputError(fmt::format("{}:{}", file, line), fmt::format("{} cells", cells.size()),
                       fmt::format("{} as in the header", columns.count),
                       cells.size() > columns.count ? "write decimal marks as points, quote cells that hold a comma"
                                                    : "add the missing commas");
    }
    for (std::size_t i = 0; i < row.cell.size(); ++i) {
      if (columns.position[i] < cells.size()) row.cell[i] = cells[columns.position[i]];
    }
  });
  if (!is_cut) return p;
  const std::size_t before = complaints.size();
  p = parse_point(row, index, complaints);
  if (!p.name.empty()) keeps_complaint(complaints, [&] { check_unit(row, p); });
  if (complaints.size() == before) keeps_complaint(complaints, [&] { check_known_point(row, p); });
  return p;
}

}  // namespace

PointMap PointMap::load(const std::string& path) { return parse(text_of_map(path), path); }

PointMap PointMap::load(const std::string& path, std::vector<InputError>& complaints) {
  return parse(text_of_map(path), path, complaints);
}

PointMap PointMap::parse(std::string_view text, std::string file) {
  std::vector<InputError> complaints;
  PointMap map = parse(text, std::move(file), complaints);
  if (!complaints.empty()) throw InputError(complaints.front());
  return map;
}

PointMap PointMap::parse(std::string_view text, std::string file, std::vector<InputError>& complaints) {
  if (text.size() > max_file_bytes) {
    throw InputError(file, fmt::format("more than {} bytes", max_file_bytes), "a point map of at most 1 MiB",
                     "check that this is the right file");
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  refuse_foreign_text(text, file + ":1", "a point map in CSV");
  PointMap map;
  map.file_ = std::move(file);
  Columns columns;
  std::vector<bool> is_sound;
  for (int line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view content = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    while (!content.empty() && (content.back() == '\r' || content.back() == ' ')) content.remove_suffix(1);
    if (content.empty() || content.front() == '#') continue;
    if (columns.count == 0) {
      refuse_nul(content, map.file_, line);
      const std::vector<std::string> cells = split_csv_line(content, map.file_, line);
      columns = {read_header(cells, map.file_, line), cells.size()};
      continue;
    }
    if (map.points_.size() == max_points) {
      complaints.emplace_back(fmt::format("{}:{}", map.file_, line), fmt::format("more than {} points", max_points),
                              "a map of one AHU", "leave out what the controller does not use");
      break;
    }
    const std::size_t before = complaints.size();
    map.points_.push_back(read_row(content, map.file_, line, columns, map.points_.size(), complaints));
    is_sound.push_back(complaints.size() == before);
  }
  if (map.points_.empty()) {
    throw InputError(map.file_, columns.count == 0 ? "no header row" : "no points",
                     "a header row and at least one point", "start from the one that `airside init` writes");
  }
  check_protocols(map, is_sound, complaints);
  check_duplicates(map, is_sound, complaints);
  check_readbacks(map, is_sound, complaints);
  return map;
}

int PointMap::index_of(std::string_view name) const {
  const auto at = std::ranges::find(points_, name, &Point::name);
  return at == points_.end() ? -1 : static_cast<int>(at - points_.begin());
}

const Point* PointMap::find(std::string_view name) const {
  const int index = index_of(name);
  return index < 0 ? nullptr : &points_[static_cast<std::size_t>(index)];
}

const Point& PointMap::at(std::string_view name) const {
  const Point* point = find(name);
  if (point == nullptr) {
    throw InputError(file_, fmt::format("no point \"{}\"", name), "a row for it",
                     named_alike(*this, name) + "add the row with its address, type, scale and limits");
  }
  return *point;
}

std::vector<std::string> PointMap::extras() const {
  std::vector<std::string> names;
  for (const Point& p : points_) {
    if (expected_unit(p.name) == nullptr) names.push_back(p.name);
  }
  return names;
}

std::uint64_t PointMap::fingerprint() const {
  std::vector<const Point*> sorted;
  for (const Point& p : points_) sorted.push_back(&p);
  std::ranges::sort(sorted, {}, [](const Point* p) -> const std::string& { return p->name; });
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (const Point* p : sorted) {
    hash = fnv1a(
        hash, fmt::format("{}|{}|{}|{}|{}|{}|{}|{:.17g}|{:.17g}|{:.17g}|{:.17g}|{:.17g}|{:.17g}|{:x}|{}|{}|"
                          "{:.17g}|{}\n",
                          p->name, p->unit, p->fc, p->addr, static_cast<int>(p->type), static_cast<int>(p->byte_order),
                          static_cast<int>(p->word_order), p->scale, p->offset, p->min, p->max, p->max_rate_per_min,
                          p->stale_s, fmt::join(p->sentinel.begin(), p->sentinel.begin() + p->sentinels, " "),
                          static_cast<int>(p->write_policy), p->fc_write, p->default_value, p->readback));
    if (p->protocol == Protocol::bacnet) hash = fnv1a(hash, fmt::format("bacnet|{}\n", p->object));
  }
  return hash;
}

double PointMap::told_fingerprint() const {
  const Point* point = find("map_fingerprint");
  if (point != nullptr && std::isfinite(point->default_value)) return point->default_value;
  return static_cast<double>(fingerprint() & 0xFFFFFFFFU);
}

}  // namespace airside::hal
