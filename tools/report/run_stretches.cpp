#include "tools/report/run_stretches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "airside/fault.hpp"
#include "airside/supervision/mode_table.hpp"
#include "tools/report/charts/report_text.hpp"

namespace airside::tools {
namespace {

/// Of a signal or of the AHU. Others, such as an update of the weights that was refused, come and go every cycle.
constexpr auto shown_faults = std::to_array<Fault>(
    {Fault::not_finite, Fault::out_of_range, Fault::rate_exceeded, Fault::stuck, Fault::stale, Fault::no_reading,
     Fault::not_applied, Fault::disagrees, Fault::frozen, Fault::write_refused, Fault::other_device});

bool is_shown(const std::string& fault) {
  return std::ranges::any_of(shown_faults, [&](Fault f) { return fault == text_of(f); });
}

/// Rows [begin, end) of one mode, reason, fault and signal.
struct RunStretch {
  std::size_t begin = 0, end = 0;
  CivilTime from, to;
  std::string mode, reason, fault, signal;
  bool has_reason() const { return !reason.empty() && reason != "none"; }
  bool is_event() const { return has_reason() || !fault.empty(); }
  std::string alarm() const { return fault.empty() || signal.empty() ? fault : fault + ": " + signal; }
};

std::vector<RunStretch> run_stretches(const RunRecord& r) {
  std::vector<RunStretch> stretches;
  for (std::size_t i = 0; i < r.mode.size(); ++i) {
    RunStretch now{i, i + 1, r.row_time[i], {r.row_time[i].seconds + row_s}, r.mode[i], "", "", ""};
    if (i < r.reason.size()) now.reason = r.reason[i];
    if (i < r.fault.size() && is_shown(r.fault[i])) now.fault = r.fault[i];
    if (i < r.signal.size() && !now.fault.empty()) now.signal = r.signal[i];
    if (!stretches.empty()) {
      RunStretch& last = stretches.back();
      const bool same = last.mode == now.mode && last.reason == now.reason && last.fault == now.fault &&
                        last.signal == now.signal && last.to.seconds == now.from.seconds;
      if (same) {
        last.end = now.end;
        last.to = now.to;
        continue;
      }
    }
    stretches.push_back(std::move(now));
  }
  return stretches;
}

std::string kind_of(const RunStretch& stretch) {
  if (stretch.mode == "learn") return stretch.is_event() ? "alarm" : "";
  return stretch.mode;
}

/// Every temperature by its place in LogRow::value.
std::vector<std::size_t> temperatures_of(const hal::TopologyCounts& counts) {
  std::vector<std::size_t> places;
  for (int i = 0; i < counts.signals(); ++i) {
    if (hal::column_of(counts.signal(i)).ends_with("_degc") && !counts.stand_in(i))
      places.push_back(static_cast<std::size_t>(i));
  }
  return places;
}

/// "room_temp_2" of the column "room_temp_2_degc", as the point map and the operator's page have it.
std::string point_of(const hal::TopologyCounts& counts, std::size_t place) {
  std::string name = hal::column_of(counts.signal(static_cast<int>(place)));
  for (const std::string unit : {"_degc", "_kw"}) {
    if (name.ends_with(unit)) name.resize(name.size() - unit.size());
  }
  return name;
}

std::string without_number(const hal::TopologyCounts& counts, const hal::LogRow& row, const std::vector<bool>& ever) {
  constexpr std::size_t most = 3;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < row.value.size(); ++i) {
    if (ever[i] && !std::isfinite(row.value[i])) names.push_back(point_of(counts, i));
  }
  const std::size_t more = names.size() > most ? names.size() - most : 0;
  names.resize(names.size() - more);
  return fmt::format("{}{}", fmt::join(names, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
}

std::string furthest_room(const hal::TopologyCounts& counts, const hal::LogRow& row) {
  std::vector<double> rooms(row.value.begin(), row.value.begin() + counts.vavs);
  std::erase_if(rooms, [](double v) { return !std::isfinite(v); });
  if (rooms.size() < 3) return "";
  const auto middle = rooms.begin() + static_cast<std::ptrdiff_t>(rooms.size() / 2);
  std::ranges::nth_element(rooms, middle);
  std::size_t found = 0;
  double most = -1;
  for (std::size_t i = 0; i < static_cast<std::size_t>(counts.vavs); ++i) {
    const double off = std::abs(row.value[i] - *middle);
    if (off > most) {
      most = off;
      found = i;
    }
  }
  return point_of(counts, found);
}

}  // namespace

std::string mode_words(std::string_view mode) {
  if (mode == "learn") return "Controls and learns";
  if (mode == "run") return "Controls, weights frozen";
  if (mode == "expert") return "Schedule";
  if (mode == "release") return "Released";
  return std::string(mode);
}

std::string reason_words(const std::string& reason) {
  for (const ModeRequest& row : mode_table) {
    if (reason == row.name) return reason + ": " + row.why;
  }
  return reason;
}

std::vector<std::string> signals_at_fault(const hal::TopologyCounts& counts, const std::vector<hal::LogRow>& rows) {
  std::vector<bool> ever(static_cast<std::size_t>(counts.signals()));
  for (const hal::LogRow& row : rows) {
    for (std::size_t i = 0; i < ever.size(); ++i) ever[i] = ever[i] || std::isfinite(row.value[i]);
  }
  const std::vector<std::size_t> temperatures = temperatures_of(counts);
  std::vector<int> still(ever.size());  // rows since it moved
  std::vector<std::string> signals;
  signals.reserve(rows.size());
  for (std::size_t t = 0; t < rows.size(); ++t) {
    const hal::LogRow& row = rows[t];
    for (const std::size_t i : temperatures)
      still[i] = t > 0 && row.value[i] == rows[t - 1].value[i] ? still[i] + 1 : 0;
    const std::string& fault = row.controller.fault;
    std::string signal;
    if (fault == text_of(Fault::stuck)) {
      const auto longest = std::ranges::max_element(still);
      if (*longest > 0) signal = point_of(counts, static_cast<std::size_t>(longest - still.begin()));
    } else if (fault == text_of(Fault::disagrees)) {
      signal = furthest_room(counts, row);
    } else if (is_shown(fault) && fault != text_of(Fault::no_reading)) {
      signal = without_number(counts, row, ever);
    }
    // A fault stays in the log until the next decision, the signal may be back before.
    if (signal.empty() && t > 0 && is_shown(fault) && fault == rows[t - 1].controller.fault) signal = signals.back();
    signals.push_back(std::move(signal));
  }
  return signals;
}

std::vector<ChartStretch> stretches_of(const RunRecord& r) {
  std::vector<ChartStretch> shown;
  for (const RunStretch& s : run_stretches(r)) {
    const std::string kind = kind_of(s);
    if (kind.empty()) continue;
    std::string why = s.has_reason() ? s.reason : "";
    if (!s.fault.empty()) why += (why.empty() ? "" : "; ") + s.alarm();
    shown.push_back({static_cast<double>(s.from.seconds), static_cast<double>(s.to.seconds), kind,
                     mode_words(s.mode) + (kind == "alarm" ? ", with an alarm" : ""), why});
  }
  return shown;
}

std::optional<ReportTable> events_table(const RunRecord& r) {
  constexpr std::size_t most = 40;
  ReportTable table;
  table.title = "What the controller did, and why";
  table.row_header = "from";
  table.prose = true;
  for (const char* name : {"to", "for", "mode", "reason", "fault and signal"}) table.columns.emplace_back().name = name;
  const auto cell = [](std::string text) {
    TableCell c;
    c.text = std::move(text);
    return c;
  };
  std::size_t events = 0;
  for (const RunStretch& s : run_stretches(r)) {
    if (!s.is_event() || ++events > most) continue;
    const double hours = static_cast<double>(s.to.seconds - s.from.seconds) / 3600;
    table.rows.push_back({minute_text(s.from),
                          {cell(minute_text(s.to)), cell(fmt::format("{:.1f} h", hours)), cell(mode_words(s.mode)),
                           cell(s.has_reason() ? reason_words(s.reason) : ""), cell(s.alarm())},
                          SeriesRole::plain,
                          false});
  }
  if (events == 0) return {};
  table.note =
      "The log names a fault but not its signal. Where one stands here it was looked for in the rows: a signal without "
      "a number, a temperature that stands still, a room far from the others.";
  if (events > most) table.note += fmt::format(" The first {} of {}.", most, events);
  return table;
}

}  // namespace airside::tools
