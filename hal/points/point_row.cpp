#include "hal/points/point_row.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>

#include "hal/points/bacnet_row.hpp"
#include "hal/points/point_type_names.hpp"
#include "hal/points/register_codec.hpp"

namespace airside::hal {
namespace {

std::optional<double> to_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Decimal, or hexadecimal with 0x.
std::optional<std::int64_t> to_integer(std::string_view text) {
  const bool hex = text.starts_with("0x") || text.starts_with("0X");
  if (hex) text.remove_prefix(2);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, hex ? 16 : 10);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  if (hex && value < 0) return std::nullopt;
  return value;
}

double number(const PointRow& row, const char* column) {
  const auto value = to_number(row[column]);
  if (!value) {
    row.complain(column, cell_text(row[column]), "a finite decimal number with a point",
                 "write it as in 0.01, without a unit or thousands separator");
  }
  return *value;
}

double number_or(const PointRow& row, const char* column, double otherwise) {
  return row[column].empty() ? otherwise : number(row, column);
}

template <class Value, std::size_t N>
Value choice(const PointRow& row, const char* column, const std::array<std::pair<const char*, Value>, N>& of) {
  std::string expected;
  for (const auto& [text, value] : of) {
    if (row[column] == text) return value;
    if (text[0] != '\0') expected += (expected.empty() ? "" : ", ") + std::string(text);
  }
  row.complain(column, cell_text(row[column]), "one of " + expected, "use one of these words, in lower case");
}

void parse_name(const PointRow& row, Point& p) {
  const std::string& name = row["name"];
  const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (name.empty() || name.size() > 48 || name[0] < 'a' || name[0] > 'z' || !std::ranges::all_of(name, plain)) {
    row.complain("name", cell_text(name), "1 to 48 of a-z, 0-9 and _, a letter first",
                 "name it after its signal and place, as in room_temp_1");
  }
  p.name = name;
}

constexpr const char* read_functions =
    "one of 1, 2, 3, 4: 1 reads coils, 2 discrete inputs, 3 holding registers, 4 input registers";

/// What to write where a cell is no function that reads.
std::string remedy_of_function(const std::string& cell) {
  static constexpr std::array<std::pair<const char*, const char*>, 4> words{{{"hold", "3, holding registers"},
                                                                             {"input r", "4, input registers"},
                                                                             {"coil", "1, coils"},
                                                                             {"discr", "2, discrete inputs"}}};
  if (cell == "5" || cell == "6" || cell == "15" || cell == "16") {
    return fmt::format("function {} writes: use one of the four here ({}), and give fc_write what writes: 5, 6 or 16",
                       cell, cell == "5" || cell == "15" ? "1 for a coil" : "3 for a holding register");
  }
  std::string small(cell);
  for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const auto& [word, function] : words) {
    if (small.starts_with(word)) return fmt::format("use one of these numbers: {}", function);
  }
  return "use one of these numbers; a manual's 4xxxx are 3, 3xxxx are 4, 1xxxx are 2, 0xxxx are 1";
}

void parse_function(const PointRow& row, Point& p) {
  const std::string& function = row["fc"];
  if (function.size() != 1 || function[0] < '1' || function[0] > '4') {
    row.complain("fc", cell_text(function), read_functions, remedy_of_function(function));
  }
  p.fc = function[0] - '0';
}

void check_type(const PointRow& row, const Point& p) {
  if ((p.fc == 1) != (p.type == PointType::coil) || (p.fc == 2) != (p.type == PointType::discrete)) {
    row.complain("type", cell_text(row["type"]),
                 p.fc == 1   ? "coil, which is what function 1 reads"
                 : p.fc == 2 ? "discrete, which is what function 2 reads"
                             : "a register type, which is what functions 3 and 4 read",
                 "correct fc or type");
  }
}

void parse_address(const PointRow& row, Point& p) {
  const auto addr = to_integer(row["addr"]);
  if (!addr || *addr < 0 || *addr + p.width() > 65536) {
    row.complain("addr", cell_text(row["addr"]), fmt::format("a protocol address from 0 to {}", 65536 - p.width()),
                 "count from 0; a manual's 40001 is fc 3, addr 0, and 30001 is fc 4, addr 0");
  }
  p.addr = static_cast<int>(*addr);
}

void parse_scaling(const PointRow& row, Point& p) {
  static constexpr std::array<std::pair<const char*, Endian>, 3> orders{
      {{"big", Endian::big}, {"little", Endian::little}, {"", Endian::big}}};
  p.byte_order = choice(row, "byte_order", orders);
  p.word_order = choice(row, "word_order", orders);
  p.scale = number_or(row, "scale", 1.0);
  if (p.scale == 0.0) {
    row.complain("scale", cell_text(row["scale"]), "a number other than 0", "leave it empty for 1");
  }
  p.offset = number_or(row, "offset", 0.0);
}

void parse_limits(const PointRow& row, Point& p) {
  p.min = p.is_bit() ? number_or(row, "min", 0.0) : number(row, "min");
  p.max = p.is_bit() ? number_or(row, "max", 1.0) : number(row, "max");
  if (p.min > p.max) {
    row.complain("min", row["min"] + " with max " + row["max"], "min not above max", "swap or correct them");
  }
  for (const char* column : {"max_rate", "stale_s"}) {
    const double value = number_or(row, column, std::numeric_limits<double>::infinity());
    if (value <= 0) {
      row.complain(column, cell_text(row[column]), "a number above 0, or an empty cell for no limit",
                   column[0] == 'm' ? "give the fastest credible change in the unit per minute"
                                    : "give the age in seconds after which the value is worthless");
    }
    (column[0] == 'm' ? p.max_rate_per_min : p.stale_s) = value;
  }
}

/// Hexadecimal: the bit pattern itself. Decimal: the raw number before scale and offset.
void parse_sentinels(const PointRow& row, Point& p) {
  const std::string& cell = row["sentinel"];
  if (cell.empty() || cell == "none") return;
  const auto bad = [&](const std::string& found) {
    row.complain("sentinel", found,
                 fmt::format("up to {} raw values that {} can hold, separated by spaces", max_sentinels, row["type"]),
                 "write bit patterns as 0xFFFF or raw numbers as -32768; leave it empty where there are none");
  };
  std::size_t at = 0;
  while (at < cell.size()) {
    const std::size_t end = std::min(cell.find(' ', at), cell.size());
    const std::string word = cell.substr(at, end - at);
    at = end + 1;
    if (word.empty()) continue;
    if (p.sentinels == max_sentinels) bad(cell_text(cell));
    const auto integer = to_integer(word);
    std::uint32_t bits = 0;
    if (p.is_bit()) bad(cell_text(word));
    if (integer && (word.starts_with("0x") || word.starts_with("0X"))) {
      if (*integer > (p.width() == 1 ? 0xFFFFLL : 0xFFFFFFFFLL)) bad(cell_text(word));
      bits = static_cast<std::uint32_t>(*integer);
    } else if (p.type == PointType::float32 && to_number(word)) {
      bits = std::bit_cast<std::uint32_t>(static_cast<float>(*to_number(word)));
    } else if (integer) {
      Point raw;
      raw.type = p.type;
      const auto registers = encode(raw, static_cast<double>(*integer));
      if (!registers) bad(cell_text(word));
      bits = registers->count == 1 ? registers->word[0] : std::uint32_t{registers->word[0]} << 16 | registers->word[1];
    } else {
      bad(cell_text(word));
    }
    p.sentinel[static_cast<std::size_t>(p.sentinels++)] = bits;
  }
}

/// 0 where nothing may be written.
int write_function(const PointRow& row) {
  const std::string& cell = row["fc_write"];
  if (cell.empty()) return 0;
  if (cell == "5" || cell == "6" || cell == "16") return cell == "16" ? 16 : cell[0] - '0';
  row.complain("fc_write", cell_text(cell),
               "one of 5, 6, 16, or an empty cell: 5 writes a coil, 6 one holding register, 16 several",
               cell == "15" ? "write 5: one coil is written at a time"
                            : "use one of these numbers, or leave it empty where nothing is written");
}

void parse_write(const PointRow& row, Point& p) {
  static constexpr std::array<std::pair<const char*, WritePolicy>, 4> policies{{{"on-change", WritePolicy::on_change},
                                                                                {"refresh", WritePolicy::refresh},
                                                                                {"none", WritePolicy::none},
                                                                                {"", WritePolicy::none}}};
  p.write_policy = choice(row, "write_policy", policies);
  p.fc_write = write_function(row);
  if (p.fc_write != 0) {
    if (p.fc == 2 || p.fc == 4) {
      row.complain("fc_write", cell_text(row["fc_write"]), fmt::format("an empty cell, since fc {} is read-only", p.fc),
                   "leave it empty, or read the point with fc 1 or 3");
    }
    if ((p.fc == 1) != (p.fc_write == 5)) {
      row.complain("fc_write", cell_text(row["fc_write"]),
                   p.fc == 1 ? "5 for a coil" : "6 or 16 for a holding register", "correct fc or fc_write");
    }
    if (p.fc_write == 6 && p.width() == 2) {
      row.complain("fc_write", "6 for " + row["type"], "16, which writes both registers at once",
                   "function 6 writes one register and would leave a torn value");
    }
  }
  if ((p.fc_write != 0) != (p.write_policy != WritePolicy::none)) {
    row.complain("write_policy", cell_text(row["write_policy"]) + " with fc_write " + cell_text(row["fc_write"]),
                 "both for a writable point, neither for the others", "fill or clear both");
  }
  p.default_value = number_or(row, "default", std::numeric_limits<double>::quiet_NaN());
  const bool is_fingerprint = p.name == "map_fingerprint";  // its default is what the device must tell
  if (!std::isnan(p.default_value) && !p.writable() && !is_fingerprint) {
    row.complain("default", cell_text(row["default"]), "an empty cell, since the point is not writable",
                 "clear it, or give write_policy and fc_write");
  }
  if (!std::isnan(p.default_value) && (p.default_value < p.min || p.default_value > p.max)) {
    row.complain("default", cell_text(row["default"]), fmt::format("a value within min {} and max {}", p.min, p.max),
                 "correct default or the limits");
  }
  p.readback = row["readback"].empty() ? (p.writable() ? "self" : "none") : row["readback"];
  if (!p.writable() && p.readback != "none") {
    row.complain("readback", cell_text(p.readback), "an empty cell, since the point is not writable", "clear it");
  }
}

void check_representable(const PointRow& row, const Point& p) {
  Point raw = p;
  raw.sentinels = 0;
  for (const auto& [column, value] : {std::pair{"min", p.min}, std::pair{"max", p.max}}) {
    if (!encode(raw, value)) {
      row.complain(column, fmt::format("{} (raw {:.10g})", value, (value - p.offset) / p.scale),
                   "a limit that " + row["type"] + " can hold", "correct the limit, scale, offset or type");
    }
  }
  if (!std::isnan(p.default_value) && !encode(p, p.default_value)) {
    row.complain("default", cell_text(row["default"]), "a value that " + row["type"] + " can hold and no sentinel",
                 "correct default, scale or sentinel");
  }
}

}  // namespace

std::string cell_text(std::string_view text) {
  return text.empty() ? std::string("an empty cell") : fmt::format("\"{}\"", text.substr(0, 60));
}

void PointRow::complain(const char* column, std::string found, std::string expected, std::string remedy) const {
  throw InputError(fmt::format("{}:{}, column {}", file, line, column), std::move(found), std::move(expected),
                   std::move(remedy));
}

const std::string& PointRow::operator[](std::string_view column) const {
  const auto at = std::ranges::find(point_columns, column);
  return cell[static_cast<std::size_t>(at - point_columns.begin())];
}

std::vector<std::string> split_csv_line(std::string_view line, std::string_view file, int line_number) {
  std::vector<std::string> cells(1);
  enum class In { plain, quotes, after } in = In::plain;
  const auto complain = [&](const char* found) {
    throw InputError(fmt::format("{}:{}, cell {}", file, line_number, cells.size()), found,
                     "cells separated by commas, quotes around a whole cell",
                     "close the quote, and double a quote that belongs to the text");
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (in == In::quotes) {
      if (c != '"') {
        cells.back() += c;
      } else if (i + 1 < line.size() && line[i + 1] == '"') {
        cells.back() += '"';
        ++i;
      } else {
        in = In::after;
      }
    } else if (c == ',') {
      cells.emplace_back();
      in = In::plain;
    } else if (c == ' ' || c == '\t') {
      if (in == In::plain && !cells.back().empty()) cells.back() += ' ';
    } else if (in == In::after) {
      complain("text after a closing quote");
    } else if (c == '"') {
      if (!cells.back().empty()) complain("a quote inside a cell");
      in = In::quotes;
    } else {
      cells.back() += c;
    }
  }
  if (in == In::quotes) complain("a quote that is not closed");
  for (std::string& cell : cells) {
    while (!cell.empty() && cell.back() == ' ') cell.pop_back();
  }
  return cells;
}

std::string modbus_header() {
  return fmt::format("{}", fmt::join(point_columns.begin(), point_columns.begin() + modbus_columns, ","));
}

Point parse_point(const PointRow& written, std::size_t index, std::vector<InputError>& complaints) {
  static constexpr std::array<std::pair<const char*, Protocol>, 3> protocols{
      {{"modbus", Protocol::modbus}, {"bacnet", Protocol::bacnet}, {"", Protocol::modbus}}};
  PointRow row = written;
  Point p;
  p.line = row.line;
  const std::size_t before = complaints.size();
  const auto tries = [&](auto&& look) { return keeps_complaint(complaints, look); };
  tries([&] { parse_name(row, p); });
  p.unit = row["unit"];
  const bool is_held = tries([&] {
    p.protocol = choice(row, "protocol", protocols);
    p.object = p.protocol == Protocol::bacnet ? take_bacnet_row(row, index) : refuse_object(row);
  });
  bool is_placed = is_held && tries([&] { parse_function(row, p); });
  is_placed = is_held && tries([&] { p.type = choice(row, "type", point_type_names); }) && is_placed;
  is_placed = is_placed && tries([&] { check_type(row, p); });
  is_placed = is_held && tries([&] { parse_address(row, p); }) && is_placed;
  tries([&] { parse_scaling(row, p); });
  // What the type decides is looked at where there is one: a complaint of what follows from another would be none.
  const bool has_limits = is_placed || (!row["min"].empty() && !row["max"].empty());
  const bool is_limited = has_limits && tries([&] { parse_limits(row, p); });
  if (is_placed) tries([&] { parse_sentinels(row, p); });
  if (is_placed && is_limited) tries([&] { parse_write(row, p); });
  if (complaints.size() == before) tries([&] { check_representable(row, p); });
  return p;
}

}  // namespace airside::hal
