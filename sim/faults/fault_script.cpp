#include "sim/faults/fault_script.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <fstream>

#include "hal/points/point_map.hpp"
#include "hal/points/point_row.hpp"
#include "hal/text/input_error.hpp"

namespace airside::sim {

namespace {

constexpr std::array<FaultKindText, 13> kinds = {{
    {FaultKind::not_a_number, "not_a_number", true, "", "the signal has no value"},
    {FaultKind::set_to, "set_to", true, "the signal's unit", "the signal reads the magnitude"},
    {FaultKind::offset, "offset", true, "the signal's unit", "the signal reads so much too high"},
    {FaultKind::stuck, "stuck", true, "", "the signal repeats its value"},
    {FaultKind::drift, "drift", true, "the signal's unit a day", "the signal reads too high by so much more each day"},
    {FaultKind::reversed, "reversed", true, "", "the signal, of 0 to 1, reads 1 less its value"},
    {FaultKind::all_stuck, "all_stuck", false, "", "the device repeats all its values"},
    {FaultKind::all_offset, "all_offset", false, "K", "all rooms read so much too high"},
    {FaultKind::setpoint_clamped, "setpoint_clamped", false, "degC", "the AHU takes at most this setpoint"},
    {FaultKind::setpoint_by_hand, "setpoint_by_hand", false, "degC", "somebody sets this setpoint once"},
    {FaultKind::setpoint_fought, "setpoint_fought", false, "degC", "somebody sets this setpoint every 12 min"},
    {FaultKind::setpoint_ignored, "setpoint_ignored", false, "", "the AHU shows a new setpoint and keeps the old one"},
    {FaultKind::restarted, "restarted", false, "degC", "the AHU stays at this default until another is written"},
}};

constexpr const char* header = "begin_h,for_h,fault,signal,magnitude";

struct Line {
  const std::string& path;
  int number;

  [[noreturn]] void complain(const char* field, const std::string& found, const std::string& expected) const {
    throw hal::InputError(fmt::format("{}:{}: {}", path, number, field), found, expected,
                          "correct the line; nothing of the script was used");
  }
  double number_in(const char* field, const std::string& text, double least) const {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value) || value < least) {
      complain(field, "'" + text + "'", least == 0 ? "hours, 0 or more" : "a number");
    }
    return value;
  }
};

ScriptedFault parse(const Line& line, const std::vector<std::string>& cell, const hal::TopologyCounts& counts) {
  ScriptedFault fault{};
  fault.begin_h = line.number_in("begin_h", cell[0], 0);
  fault.for_h = line.number_in("for_h", cell[1], 0);
  const FaultKindText* text = nullptr;
  std::string names;
  for (const FaultKindText& k : kinds) {
    if (cell[2] == k.name) text = &k;
    names += std::string(names.empty() ? "" : ", ") + k.name;
  }
  if (text == nullptr) line.complain("fault", "'" + cell[2] + "'", "one of " + names);
  fault.kind = text->kind;
  std::string signals;
  const std::vector<std::string> known = fault_signals(counts);
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (cell[3] == known[i]) fault.signal = static_cast<int>(i);
    signals += (i == 0 ? "" : ", ") + known[i];
  }
  if (text->on_signal && fault.signal < 0) line.complain("signal", "'" + cell[3] + "'", "one of " + signals);
  if (!text->on_signal && !cell[3].empty()) {
    line.complain("signal", "'" + cell[3] + "'", std::string("nothing, as ") + text->name + " has no signal");
  }
  const bool has_magnitude = *text->magnitude != '\0';
  if (has_magnitude) fault.magnitude = line.number_in("magnitude", cell[4], -HUGE_VAL);
  if (!has_magnitude && !cell[4].empty()) {
    line.complain("magnitude", "'" + cell[4] + "'", std::string("nothing, as ") + text->name + " has none");
  }
  return fault;
}

}  // namespace

std::span<const FaultKindText> fault_kinds() { return kinds; }

std::vector<std::string> fault_signals(const hal::TopologyCounts& counts) {
  std::vector<std::string> names;
  for (int i = 0; i < counts.signals(); ++i) names.push_back(hal::point_name(counts.signal(i)));
  for (const char* single : {"supply_temp", "occupied", "supply_flow", "ahu_on"}) names.emplace_back(single);
  for (const char* many : {"damper_", "zone_setpoint_", "zone_heating_setpoint_"}) {
    for (int place = 1; place <= counts.vavs; ++place) names.push_back(many + std::to_string(place));
  }
  return names;
}

FaultScript read_fault_script(const std::string& path, const hal::TopologyCounts& counts) {
  std::ifstream in(path);
  if (!in) {
    throw hal::InputError(path, "a file that cannot be read", std::string("a fault script: ") + header + " and lines",
                          "check the path");
  }
  FaultScript script;
  std::string text;
  bool has_header = false;
  for (int number = 1; std::getline(in, text); ++number) {
    if (!text.empty() && text.back() == '\r') text.pop_back();
    if (text.empty() || text[0] == '#') continue;
    const Line line{path, number};
    if (!has_header) {
      if (text != header) line.complain("header", "'" + text + "'", header);
      has_header = true;
      continue;
    }
    const std::vector<std::string> cell = hal::split_csv_line(text, path, number);
    if (cell.size() != 5) line.complain("cells", std::to_string(cell.size()), "5: " + std::string(header));
    script.push_back(parse(line, cell, counts));
  }
  if (!has_header) throw hal::InputError(path, "no header", header, "begin the script with it");
  return script;
}

}  // namespace airside::sim
