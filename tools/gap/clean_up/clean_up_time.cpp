// Rows as wholes: their shape, their order, their times, what is missing between them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "hal/text/civil_text.hpp"
#include "tools/gap/clean_up/clean_up_table.hpp"

namespace airside::tools::gap {

namespace {

using Rows = std::vector<hal::LogRow>;

double value_at(const hal::LogRow& row, std::size_t i) {
  if (i < row.value.size()) return row.value[i];
  return i == row.value.size() ? row.setpoint_degc : row.supply_temp_degc;
}

bool agree(const hal::LogRow& a, const hal::LogRow& b) {
  for (std::size_t i = 0; i < a.value.size() + 2; ++i) {
    const double x = value_at(a, i), y = value_at(b, i);
    if (std::isfinite(x) && std::isfinite(y) && x != y) return false;
  }
  return true;
}

/// Fills in what `into` lacks.
void merge(hal::LogRow& into, const hal::LogRow& from) {
  for (std::size_t i = 0; i < into.value.size(); ++i) {
    if (!std::isfinite(into.value[i])) into.value[i] = from.value[i];
  }
  if (!std::isfinite(into.setpoint_degc)) into.setpoint_degc = from.setpoint_degc;
  if (!std::isfinite(into.supply_temp_degc)) into.supply_temp_degc = from.supply_temp_degc;
}

/// First and last time and the number of what a remark is about.
struct Extent {
  CivilTime from, to;
  std::size_t count = 0;
  void add(CivilTime t) {
    if (count == 0 || t < from) from = t;
    if (count == 0 || to < t) to = t;
    ++count;
  }
};

Remark remark_of(Defect defect, Action action, const Extent& extent, std::string text) {
  return {defect, action, "", extent.from, extent.to, extent.count, std::move(text), "", ""};
}

Remark refusal(Defect defect, const Extent& extent, std::string text, std::string expected, std::string remedy) {
  return {defect,          Action::refused,     "",
          extent.from,     extent.to,           extent.count,
          std::move(text), std::move(expected), std::move(remedy)};
}

}  // namespace

void check_shape(Rows& rows, const CleanUpContext& context, std::vector<Remark>& remarks) {
  const auto signals = static_cast<std::size_t>(context.counts.signals());
  Extent other;
  for (const hal::LogRow& row : rows) {
    if (row.value.size() != signals) other.add(row.time);
  }
  if (rows.empty()) {
    remarks.push_back(refusal(Defect::too_little, other, "no row", "a log of two days or more",
                              "check that the export finished and covers the days that you want"));
  } else if (other.count > 0) {
    remarks.push_back(refusal(Defect::other_room, other,
                              fmt::format("{} row{} of another number of signals", other.count, plural(other.count)),
                              fmt::format("{} signals in every row", signals), "give the log of this site"));
    rows.clear();
  }
}

void check_order(Rows& rows, const CleanUpContext&, std::vector<Remark>& remarks) {
  Extent late;
  std::unordered_set<std::int64_t> seen;
  CivilTime newest = rows.front().time;
  for (const hal::LogRow& row : rows) {
    // A time that was there before is a duplicate's matter, not one of order.
    if (seen.insert(row.time.seconds).second && row.time < newest) late.add(row.time);
    newest = std::max(newest, row.time);
  }
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  if (late.count == 0) return;
  remarks.push_back(remark_of(
      Defect::shuffled, Action::fixed, late,
      fmt::format("{} row{} came after a later one; the rows were sorted by time", late.count, plural(late.count))));
}

void check_grid(Rows& rows, const CleanUpContext&, std::vector<Remark>& remarks) {
  constexpr std::int64_t near_s = 90;
  std::vector<double> spacing;
  Extent all;
  for (const hal::LogRow& row : rows) all.add(row.time);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const auto s = static_cast<double>(rows[i].time.seconds - rows[i - 1].time.seconds);
    if (s > 0) spacing.push_back(s);
  }
  const double usual_s = median_of(spacing);
  if (spacing.size() >= 3 && std::abs(usual_s - row_s) > 30) {
    remarks.push_back(refusal(Defect::off_grid, all, fmt::format("rows every {:g} min", usual_s / 60),
                              "rows every 6 min", "export the log with a 6-min interval"));
    return;
  }
  Extent moved, lost;
  std::erase_if(rows, [&](hal::LogRow& row) {
    const std::int64_t grid_s = (row.time.seconds + row_s / 2) / row_s * row_s;
    const std::int64_t beside_s = std::abs(row.time.seconds - grid_s);
    if (beside_s > 0) (beside_s > near_s ? lost : moved).add(row.time);
    if (beside_s > near_s) return true;
    row.time.seconds = grid_s;
    return false;
  });
  if (moved.count > 0) {
    remarks.push_back(remark_of(
        Defect::off_grid, Action::fixed, moved,
        fmt::format("{} row{} up to 90 s beside the 6-min grid; moved onto it", moved.count, plural(moved.count))));
  }
  if (lost.count > 0) {
    const Action action = rows.empty() ? Action::refused : Action::left_out;
    Remark remark =
        refusal(Defect::off_grid, lost,
                fmt::format("{} row{} between the times of the 6-min grid; left out", lost.count, plural(lost.count)),
                "rows at 00:00, 00:06, 00:12 ...", "resample the log to 00:00, 00:06, 00:12 ...");
    remark.action = action;
    remarks.push_back(std::move(remark));
  }
}

void check_repeated(Rows& rows, const CleanUpContext&, std::vector<Remark>& remarks) {
  Extent dropped;
  Rows kept;
  kept.reserve(rows.size());
  std::size_t first_of_time = 0;
  for (hal::LogRow& row : rows) {
    if (kept.empty() || kept.back().time < row.time) first_of_time = kept.size();
    const auto same = std::find_if(kept.begin() + static_cast<std::ptrdiff_t>(first_of_time), kept.end(),
                                   [&row](const hal::LogRow& k) { return agree(k, row); });
    if (same == kept.end()) {
      kept.push_back(std::move(row));
    } else {
      dropped.add(row.time);
      merge(*same, row);
    }
  }
  rows = std::move(kept);
  if (dropped.count == 0) return;
  remarks.push_back(
      remark_of(Defect::duplicate, Action::fixed, dropped,
                fmt::format("{} row{} that repeat another one; dropped", dropped.count, plural(dropped.count))));
}

void check_conflicts(Rows& rows, const CleanUpContext&, std::vector<Remark>& remarks) {
  const std::size_t before = rows.size();
  Extent times, all;
  Rows kept;
  kept.reserve(rows.size());
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t end = i + 1;
    while (end < rows.size() && rows[end].time == rows[i].time) ++end;
    all.add(rows[i].time);
    if (end == i + 1)
      kept.push_back(std::move(rows[i]));
    else
      times.add(rows[i].time);
    i = end;
  }
  rows = std::move(kept);
  if (times.count == 0) return;
  const std::size_t contradicting = before - rows.size();
  const std::string found =
      fmt::format("{} time{} with several rows that contradict each other", times.count, plural(times.count));
  if (times.count > 12 && 50 * times.count > all.count) {
    remarks.push_back(refusal(Defect::duplicate, times, found, "one row for each time",
                              "remove the rows that do not belong to this room; two logs may have been joined"));
    return;
  }
  remarks.push_back(remark_of(Defect::duplicate, Action::left_out, times,
                              fmt::format("{}; all {} rows were left out", found, contradicting)));
}

void check_gaps(Rows& rows, const CleanUpContext& context, std::vector<Remark>& remarks) {
  Extent all;
  for (const hal::LogRow& row : rows) all.add(row.time);
  // Without a period that was asked for, the log's own.
  const CivilTime from = context.from.value_or(all.from);
  const CivilTime to = context.to ? CivilTime{context.to->seconds - row_s} : all.to;
  if (all.to < from || to < all.from) {
    remarks.push_back(refusal(Defect::other_period, all,
                              fmt::format("rows from {} to {}", hal::civil_text(all.from), hal::civil_text(all.to)),
                              fmt::format("rows between {} and {}", hal::civil_text(from), hal::civil_text(to)),
                              "give the log of that time, or name another period"));
    return;
  }
  Extent where;
  std::int64_t missing = 0, longest = 0;
  CivilTime last{from.seconds - row_s}, longest_at = from;
  const auto step_to = [&](CivilTime next) {
    const std::int64_t gap = (next.seconds - last.seconds) / row_s - 1;
    if (gap > 0) {
      where.add({last.seconds + row_s});
      where.add({next.seconds - row_s});
      missing += gap;
    }
    if (gap > longest) longest = gap, longest_at = {last.seconds + row_s};
    last = next;
  };
  for (const hal::LogRow& row : rows) {
    if (row.time < from || to < row.time) continue;
    step_to(row.time);
  }
  step_to({to.seconds + row_s});
  if (missing == 0) return;
  const std::size_t gaps = where.count / 2;
  where.count = static_cast<std::size_t>(missing);
  const std::int64_t expected = (to.seconds - from.seconds) / row_s + 1;
  const double share = static_cast<double>(missing) / static_cast<double>(expected);
  const std::string found = fmt::format(
      "{} row{} missing in {} gap{}, {:.1f} % of the time, the longest {:.1f} h from {}", missing, plural(where.count),
      gaps, plural(gaps), 100 * share, static_cast<double>(longest) / 10, hal::civil_text(longest_at));
  if (share > 0.3 || longest * row_s > seconds_per_day) {
    remarks.push_back(refusal(Defect::gap, where, found, "at most 30 % missing and no gap of more than a day",
                              "give a log or name a period without such gaps"));
  } else {
    remarks.push_back(remark_of(Defect::gap, Action::left_out, where, found + "; left out"));
  }
}

}  // namespace airside::tools::gap
