#pragma once
// One row of points.csv on its way to a Point: cells by column name, each complaint with its place.

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "hal/points/point_map.hpp"

namespace airside::hal {

/// The columns of points.csv; a file may order them as it likes. The last two may be left out; with `protocol`, any of
/// those that a row of BACnet leaves empty may be.
constexpr std::array<const char*, 20> point_columns = {
    "name",         "unit",     "fc",      "addr",     "type",     "byte_order", "word_order",
    "scale",        "offset",   "min",     "max",      "max_rate", "stale_s",    "sentinel",
    "write_policy", "fc_write", "default", "readback", "protocol", "object"};
constexpr std::size_t modbus_columns = point_columns.size() - 2;

/// The header line of a map of Modbus registers, without its end.
std::string modbus_header();

/// A row's cells in the order of point_columns, trimmed.
struct PointRow {
  std::string_view file;
  int line = 0;
  std::array<std::string, point_columns.size()> cell;

  /// Errors: InputError at file:line, the column.
  [[noreturn]] void complain(const char* column, std::string found, std::string expected, std::string remedy) const;
  const std::string& operator[](std::string_view column) const;
};

/// What is in a cell, as a complaint says it.
std::string cell_text(std::string_view text);

/// Splits one line of CSV; quotes may enclose commas, a doubled quote is a quote.
/// Errors: InputError where a quote is left open or text follows a closing quote.
std::vector<std::string> split_csv_line(std::string_view line, std::string_view file, int line_number);

/// Runs `look`, and keeps its complaint; returns whether there was none.
template <class Look>
bool keeps_complaint(std::vector<InputError>& complaints, Look&& look) {
  try {
    look();
    return true;
  } catch (const InputError& complaint) {
    complaints.push_back(complaint);
    return false;
  }
}

/// Checks everything a row can say about itself and makes the Point; `index`: its place among the points, from 0.
/// Each part of the row is looked at, whatever became of the others; what is wrong is added to `complaints`, at
/// file:line, column. After a complaint only name and line of the Point can be trusted.
Point parse_point(const PointRow& row, std::size_t index, std::vector<InputError>& complaints);

}  // namespace airside::hal
