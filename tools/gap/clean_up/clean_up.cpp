#include "tools/gap/clean_up/clean_up.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/text/input_error.hpp"
#include "tools/gap/clean_up/clean_up_table.hpp"

namespace airside::tools::gap {

namespace {

// Repeated rows are dropped before the hour that comes twice is looked for, rows that contradict each other after it.
constexpr std::array<RowCheck, 7> row_checks{check_shape,           check_order,     check_grid, check_repeated,
                                             check_daylight_saving, check_conflicts, check_gaps};

// Units first: limits and comparisons are in the log's units. Types before limits, which would empty a swapped column.
constexpr std::array<TableCheck, 10> table_checks{check_missing, check_sentinels,  check_units, check_swapped,
                                                  check_range,   check_spikes,     check_stuck, check_clock,
                                                  check_weather, check_enough_left};

}  // namespace

const char* text_of(Defect defect) {
  switch (defect) {
    case Defect::unreadable: return "unreadable";
    case Defect::off_grid: return "off the grid";
    case Defect::shuffled: return "shuffled";
    case Defect::duplicate: return "duplicate";
    case Defect::daylight_saving: return "daylight saving";
    case Defect::gap: return "gap";
    case Defect::other_period: return "other period";
    case Defect::missing_value: return "missing value";
    case Defect::sentinel: return "no-value number";
    case Defect::wrong_unit: return "wrong unit";
    case Defect::swapped: return "swapped";
    case Defect::implausible: return "implausible";
    case Defect::out_of_range: return "out of range";
    case Defect::spike: return "spike";
    case Defect::constant: return "constant";
    case Defect::stuck: return "stuck";
    case Defect::clock_shift: return "clock shift";
    case Defect::other_weather: return "other weather";
    case Defect::other_room: return "other room";
    case Defect::too_little: return "too little";
  }
  return "unknown";
}

const char* text_of(Action action) {
  switch (action) {
    case Action::noted: return "noted";
    case Action::warned: return "warning";
    case Action::fixed: return "fixed";
    case Action::left_out: return "left out";
    case Action::refused: return "refused";
  }
  return "unknown";
}

bool CleanLog::usable() const {
  return std::none_of(remarks.begin(), remarks.end(), [](const Remark& r) { return r.action == Action::refused; });
}

void CleanLog::require_usable() const {
  const Remark* first = nullptr;
  int others = 0;
  for (const Remark& remark : remarks) {
    if (remark.action != Action::refused) continue;
    if (first == nullptr)
      first = &remark;
    else
      ++others;
  }
  if (first == nullptr) return;
  std::string remedy = first->remedy;
  if (others > 0) remedy += fmt::format(" (and {} more reason{} to refuse this log)", others, others > 1 ? "s" : "");
  throw hal::InputError(first->column.empty() ? place : place + ": " + first->column, first->text, first->expected,
                        remedy);
}

CleanLog clean_up(std::vector<hal::LogRow> rows, const CleanUpContext& context) {
  CleanLog log{context.place, std::move(rows), {}, {}};
  for (const RowCheck check : row_checks) {
    check(log.rows, context, log.remarks);
    if (log.rows.empty()) return log;
  }
  LogTable table = table_of(log.rows, context);
  for (const TableCheck check : table_checks) check(table, context, log.remarks);
  write_back(table, log.rows);
  log.outdoor_difference = table.outdoor_difference;
  return log;
}

std::string warnings_text(const CleanLog& log) {
  std::string text;
  for (const Remark& r : log.remarks)
    if (r.action == Action::warned) text += fmt::format("{}: {}\n", log.place, r.text);
  return text;
}

bool same_room(const CleanLog& reference, CleanLog& measured, const CleanUpContext& context) {
  if (reference.rows.empty() || measured.rows.empty()) return true;
  const std::string remedy = "give the reference log and the measured log of one room";
  Remark remark{Defect::other_room,
                Action::refused,
                "",
                measured.rows.front().time,
                measured.rows.back().time,
                0,
                "",
                "the same room as in " + reference.place,
                remedy};
  if (reference.rows.front().value.size() != measured.rows.front().value.size()) {
    remark.text = fmt::format("rows of {} signals, but {} has rows of {}: another room's file?",
                              measured.rows.front().value.size(), reference.place, reference.rows.front().value.size());
    measured.remarks.push_back(remark);
    return false;
  }
  LogTable known = table_of(reference.rows, context), shown = table_of(measured.rows, context);

  std::vector<double> differences;
  const auto& a = known.only(Role::outdoor).value;
  const auto& b = shown.only(Role::outdoor).value;
  for (std::size_t i = 0, k = 0; i < a.size() && k < b.size();) {
    if (known.time[i] == shown.time[k])
      differences.push_back(b[k++] - a[i++]);
    else if (known.time[i] < shown.time[k])
      ++i;
    else
      ++k;
  }
  const double offset_k = median_of(differences);
  std::vector<double> left;
  for (const double d : differences) left.push_back(std::abs(d - offset_k));
  const double spread_k = median_of(left);
  bool same = true;
  if (count_finite(differences) >= 24 && (spread_k > 0.4 || std::abs(offset_k) > 5)) {
    remark.column = shown.only(Role::outdoor).name;
    remark.count = count_finite(differences);
    remark.text = fmt::format(
        "outdoor temperatures that differ from those of {} at the same hours by {:.1f} K: "
        "another site's file?",
        reference.place, std::max(spread_k, std::abs(offset_k)));
    measured.remarks.push_back(remark);
    same = false;
  }

  double nearest_k = 1e9;
  for (std::size_t c = 0; c < known.columns.size(); ++c) {
    if (known.columns[c].role != Role::room) continue;
    const double k = std::abs(median_of(shown.columns[c].value) - median_of(known.columns[c].value));
    if (std::isfinite(k)) nearest_k = std::min(nearest_k, k);
  }
  if (nearest_k > 5 && nearest_k < 1e9) {
    remark.action = Action::noted;
    remark.column.clear();
    remark.count = measured.rows.size();
    remark.text = fmt::format(
        "every room differs from {} by {:.1f} K or more in its median: another room's file? "
        "used as it is",
        reference.place, nearest_k);
    measured.remarks.push_back(remark);
  }
  return same;
}

}  // namespace airside::tools::gap
