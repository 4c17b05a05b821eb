#include "tools/gap/run/more_days.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "tools/gap/model/stretches.hpp"
#include "tools/run/site.hpp"

namespace airside::tools::gap {

namespace {

/// How the site's outdoor sensor differs from the station, K.
struct OutdoorOffset {
  double median_k = 0, spread_k = 0;
  int rows = 0;
};

double middle_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

OutdoorOffset outdoor_offset(const sim::Recording& recording) {
  std::vector<double> differences, left;
  for (std::size_t row = 0; row < recording.rows.size(); ++row) {
    const double k =
        recording.rows[row].outdoor_temp_degc - recording.station->at(recording.time(row)).outdoor_temp_degc;
    if (std::isfinite(k)) differences.push_back(k);
  }
  OutdoorOffset offset;
  offset.rows = static_cast<int>(differences.size());
  offset.median_k = middle_of(differences);
  for (const double k : differences) left.push_back(std::abs(k - offset.median_k));
  offset.spread_k = middle_of(left);
  return offset;
}

/// The weather of another place, or the shape of another room.
void require_same_site(const GapRun& run, const AddedDays& more) {
  constexpr double most_offset_k = 3, least_spread_k = 0.3, most_spread_ratio = 2;
  const OutdoorOffset known = outdoor_offset(run.loaded.data.test.recording),
                      shown = outdoor_offset(more.window.recording);
  const bool other_level = std::abs(shown.median_k - known.median_k) > most_offset_k;
  const bool other_course = shown.spread_k > least_spread_k + most_spread_ratio * known.spread_k;
  if (known.rows == 0 || shown.rows == 0 || !(other_level || other_course)) return;
  throw hal::InputError(
      more.log.place,
      fmt::format("outdoor temperatures that differ from the weather file's by {:.1f} K, and change otherwise by "
                  "{:.1f} K; in {} it was {:.1f} and {:.1f} K: another site's log",
                  shown.median_k, shown.spread_k, run.loaded.logs.measured.place, known.median_k, known.spread_k),
      "a log of the site that the earlier verdict is of, in days that the weather file holds",
      "name that site's log; where the weather file ends, judge all days anew with airside gap and another file");
}

void require_new(const hal::LogRow& first, const hal::LogRow& last, const CleanLog& known, const std::string& place) {
  if (known.rows.empty() || last.time < known.rows.front().time || known.rows.back().time < first.time) return;
  throw hal::InputError(place,
                        fmt::format("rows from {} to {}, within those of {}, which go from {} to {}",
                                    hal::civil_text(first.time), hal::civil_text(last.time), known.place,
                                    hal::civil_text(known.rows.front().time), hal::civil_text(known.rows.back().time)),
                        "days that were not judged yet", "leave out the days that are known");
}

/// Duties of fan coils that the test commanded say nothing of their thermostats.
void apply_test(AddedDays& more, const TestPlan& plan, const sim::Channels& channels) {
  if (!was_done(more.window.recording, plan)) {
    throw hal::InputError(more.log.place, fmt::format("no day on which \"{}\" was done", plan.text),
                          "the log of the test \"" + plan.name + "\", with its setpoints and commands",
                          "leave --test out where the days hold no test, or name the test that was done");
  }
  for (int f = 0; f < channels.fcus && plan.fcu_command; ++f) {
    if (plan.fcu >= 0 && plan.fcu != f) continue;
    more.window.measured.col(channels.fcu_duty() + f).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

AddedDays read_days(const GapRun& run, const MoreDays& from, const std::vector<sim::Effect>& effects) {
  CleanUpContext context;
  context.counts = run.loaded.counts;
  context.station = run.loaded.data.test.recording.station;
  AddedDays more;
  more.test = from.test;
  const sim::Channels channels = run.channels();
  try {
    more.log = read_log_of(run.request.source, from.log, context);
    same_room(run.loaded.logs.measured, more.log, context);
    more.log.require_usable();
    more.window = window_of_log(run.request.source, more.log.rows, channels, context.station, from.log, context.counts);
  } catch (const hal::InputError& reason) {
    throw RefusedLog(reason, {{}, more.log});
  }
  std::vector<const CleanLog*> known{&run.loaded.logs.reference, &run.loaded.logs.measured};
  for (const AddedDays& earlier : run.added) known.push_back(&earlier.log);
  for (const CleanLog* log : known) require_new(more.log.rows.front(), more.log.rows.back(), *log, from.log);
  require_same_site(run, more);
  if (!from.test.empty()) apply_test(more, named_plan(from.test, channels, effects), channels);
  return more;
}

/// The last window's days, and those that follow within a day, as one.
bool joined_days(std::vector<hal::LogRow>& last, const std::vector<hal::LogRow>& more) {
  const std::int64_t gap_s = more.front().time.seconds - last.back().time.seconds;
  if (gap_s <= 0 || gap_s >= seconds_per_day) return false;
  last.insert(last.end(), more.begin(), more.end());
  return true;
}

}  // namespace

void add_more_days(GapRun& run, const std::vector<sim::Effect>& effects) {
  if (run.request.more.empty()) return;
  for (const MoreDays& more : run.request.more) run.added.push_back(read_days(run, more, effects));
  const Window& first = run.loaded.data.test;
  const sim::Channels channels = run.channels();
  std::vector<std::vector<hal::LogRow>> passive{run.loaded.logs.measured.rows};
  std::vector<Window> windows;
  Eigen::Index bins_of_tests = 0, bins = 0;
  for (const AddedDays& more : run.added) {
    if (more.test.empty()) {
      if (!joined_days(passive.back(), more.log.rows)) passive.push_back(more.log.rows);
    } else {
      windows.push_back(more.window);
      bins_of_tests += more.window.measured.rows();
    }
  }
  for (const std::vector<hal::LogRow>& rows : passive)
    windows.push_back(window_of_log(run.request.source, rows, channels, first.recording.station,
                                    run.loaded.logs.measured.place, run.loaded.counts));
  for (const Window& w : windows) bins += w.measured.rows();
  run.loaded.data.test = stacked_windows(windows);
  run.rules.locked_share *= static_cast<double>(bins - bins_of_tests) / static_cast<double>(bins);
}

}  // namespace airside::tools::gap
