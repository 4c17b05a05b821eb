// Names, formatting and writing of log rows; reading is in log_csv_read.cpp.
#include "hal/log/log_csv.hpp"

#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "hal/log/log_columns.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"

namespace airside::hal {
namespace {

/// A cursor over the output that remembers whether everything fitted.
class Cursor {
 public:
  explicit Cursor(std::span<char> out) : at_(out.data()), end_(out.data() + out.size()) {}

  void put(char c) {
    if (at_ == end_)
      full_ = true;
    else
      *at_++ = c;
  }
  /// To the millionth, as a person would write it: 23.87 and not 23.869999999999997. Small numbers by four digits.
  void put(double value) {
    if (std::isnan(value)) return;
    constexpr double millionths = 1e6;
    const double size = std::abs(value);
    const bool is_small = size > 0 && size < 1e-3;
    const double rounded = size < 1e9 ? std::round(value * millionths) / millionths : value;
    end(is_small ? std::to_chars(at_, end_, value, std::chars_format::general, 4) : std::to_chars(at_, end_, rounded));
  }
  /// With every digit: in a loss of each cycle all bits of the weights show.
  void put_whole(double value) {
    if (!std::isnan(value)) end(std::to_chars(at_, end_, value));
  }
  void put(const std::string& text) {
    for (const char c : text) put(c == ',' || c == '\n' || c == '\r' || c == '"' ? ' ' : c);
  }
  void put(CivilTime time) {
    if (static_cast<std::size_t>(end_ - at_) < civil_text_size)
      full_ = true;
    else
      at_ = write_civil_text(at_, time);
  }
  std::size_t size_from(const char* begin) const { return full_ ? 0 : static_cast<std::size_t>(at_ - begin); }

 private:
  void end(const std::to_chars_result& result) {
    if (result.ec != std::errc{})
      full_ = true;
    else
      at_ = result.ptr;
  }

  char* at_;
  char* end_;
  bool full_ = false;
};

}  // namespace

SignalId TopologyCounts::signal(int index) const {
  const auto take = [&index](int count, SignalKind kind, SignalId& id) {
    if (index < count) {
      id = {kind, index + 1};
      return true;
    }
    index -= count;
    return false;
  };
  SignalId id{SignalKind::setpoint, 0};
  if (take(vavs, SignalKind::room_temp, id) || take(fcus, SignalKind::fcu_temp, id) ||
      take(vavs, SignalKind::vav_on, id) || take(fcus, SignalKind::fcu_on, id) || take(powers, SignalKind::power, id)) {
    return id;
  }
  constexpr SignalKind single[] = {SignalKind::mau_temp, SignalKind::outdoor_temp, SignalKind::rain};
  return {index < 3 ? single[index] : SignalKind::setpoint, 0};
}

std::string column_of(SignalId id) {
  const SignalText text = text_of(id.kind);
  std::string column = text.name;
  if (id.place > 0) column += "_" + std::to_string(id.place);
  if (*text.unit != '\0') column += std::string("_") + text.unit;
  return column;
}

std::string column_of(const TopologyCounts& counts, int index) {
  return column_of(counts.signal(index)) + (counts.stand_in(index) ? stand_in_mark : "");
}

std::string column_of(SideColumn side) {
  const std::string place = std::to_string(side.place);
  switch (side.signal) {
    case SideSignal::damper: return "damper_" + place;
    case SideSignal::zone_setpoint: return "zone_setpoint_" + place + "_degc";
    case SideSignal::zone_heating_setpoint: return "zone_heating_setpoint_" + place + "_degc";
    case SideSignal::occupied: return "occupied";
    case SideSignal::supply_flow: return "supply_flow_m3s";
    case SideSignal::ahu_on: return "ahu_on";
  }
  return "unknown";
}

bool is_side_column(std::string_view name) {
  return name == "occupied" || name == "supply_flow_m3s" || name == "ahu_on" || name.starts_with("damper_") ||
         name.starts_with("zone_setpoint_") || name.starts_with("zone_heating_setpoint_");
}

LogRow make_log_row(const TopologyCounts& counts) {
  LogRow row;
  row.value.assign(static_cast<std::size_t>(counts.signals()), ControllerColumns::none);
  row.side.assign(counts.sides.size(), ControllerColumns::none);
  row.controller.mode.reserve(47);
  row.controller.reason.reserve(47);
  row.controller.fault.reserve(47);
  return row;
}

double side_of(const TopologyCounts& counts, const LogRow& row, SideSignal signal) {
  for (std::size_t i = 0; i < counts.sides.size() && i < row.side.size(); ++i) {
    if (counts.sides[i].signal == signal) return row.side[i];
  }
  return ControllerColumns::none;
}

std::string log_header(const TopologyCounts& counts, bool controller, std::span<const std::string> extra) {
  std::string header = "time";
  for (int i = 0; i < counts.signals(); ++i) header += "," + column_of(counts, i);
  header += ",setpoint_degc,supply_temp_degc";
  for (const SideColumn& side : counts.sides) header += "," + column_of(side);
  if (controller) {
    for (const ControllerColumn& column : controller_columns) header += std::string(",") + column.name;
  }
  for (const std::string& name : extra) {
    header += ',';
    for (const char c : name)
      header += c == ',' || c == '\n' || c == '\r' || c == '"' ? '_' : c;  // quotes are not written
  }
  return header + "\n";
}

std::size_t format_log_row(std::span<char> out, const LogRow& row, bool controller) {
  Cursor cursor(out);
  cursor.put(row.time);
  for (const double value : row.value) {
    cursor.put(',');
    cursor.put(value);
  }
  cursor.put(',');
  cursor.put(row.setpoint_degc);
  cursor.put(',');
  cursor.put(row.supply_temp_degc);
  for (const double value : row.side) {
    cursor.put(',');
    cursor.put(value);
  }
  if (controller) {
    for (const ControllerColumn& column : controller_columns) {
      cursor.put(',');
      if (column.number != nullptr && std::string_view(column.name).starts_with("loss_"))
        cursor.put_whole(row.controller.*column.number);
      else if (column.number != nullptr)
        cursor.put(row.controller.*column.number);
      else
        cursor.put(row.controller.*column.text);
    }
  }
  for (const std::string& text : row.extra) {
    cursor.put(',');
    cursor.put(text);
  }
  cursor.put('\n');
  return cursor.size_from(out.data());
}

namespace {

/// `path`, unless what is there is no log: a log that replaces a site file is a slip of the hand.
std::string in_place_of_a_log(const std::string& path) {
  std::error_code ignored;
  std::string begin(7, '\0');
  std::ifstream file;
  if (std::filesystem::is_regular_file(path, ignored)) file.open(path, std::ios::binary);
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(file.gcount()));
  const std::string_view header = begin.starts_with("\xEF\xBB\xBF") ? std::string_view(begin).substr(3) : begin;
  if (!header.empty() && !header.starts_with("time")) {
    throw InputError(path, "another kind of file, which the log would replace", "a new name, or that of a log",
                     "choose another output path");
  }
  return path;
}

}  // namespace

LogWriter::LogWriter(std::string path, const TopologyCounts& counts, bool controller,
                     std::vector<std::string> extra_columns)
    : path_(std::move(path)),
      controller_(controller),
      values_(static_cast<std::size_t>(counts.signals())),
      sides_(counts.sides.size()),
      extras_(extra_columns.size()),
      file_(in_place_of_a_log(path_)) {
  file_.write(log_header(counts, controller, extra_columns));
}

void LogWriter::append(const LogRow& row) {
  if (row.value.size() != values_ || row.side.size() != sides_ || row.extra.size() != extras_) {
    throw std::runtime_error(path_ + ": a row of " + std::to_string(row.value.size() + row.side.size()) +
                             " signals and " + std::to_string(row.extra.size()) +
                             " further fields does not fit the header");
  }
  char text[max_log_row_text];
  const std::size_t size = format_log_row(text, row, controller_);
  if (size == 0) throw std::runtime_error(path_ + ": cannot be written: row too long");
  file_.write({text, size});
}

}  // namespace airside::hal
