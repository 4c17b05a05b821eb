#include "tools/gap/model/stretches.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace airside::tools::gap {

Window stacked_windows(const std::vector<Window>& windows) {
  if (windows.empty()) throw std::invalid_argument("no window");
  Window all = windows.front();
  for (std::size_t i = 1; i < windows.size(); ++i) {
    const Window& next = windows[i];
    const Eigen::Index before = all.measured.rows();
    all.recording.later.push_back({all.recording.rows.size(), next.recording.from});
    all.recording.rows.insert(all.recording.rows.end(), next.recording.rows.begin(), next.recording.rows.end());
    all.measured.conservativeResize(before + next.measured.rows(), Eigen::NoChange);
    all.measured.bottomRows(next.measured.rows()) = next.measured;
    all.measured.middleRows(before, std::min<Eigen::Index>(bins_per_day, next.measured.rows()))
        .setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return all;
}

sim::Recording part_of(const sim::Recording& recording, std::size_t first_row, std::size_t rows) {
  sim::Recording part;
  part.from = recording.time(first_row);
  part.station = recording.station;
  const auto begin = recording.rows.begin() + static_cast<std::ptrdiff_t>(first_row);
  part.rows.assign(begin, begin + static_cast<std::ptrdiff_t>(rows));
  for (const sim::LaterStretch& stretch : recording.later) {
    if (stretch.row > first_row && stretch.row < first_row + rows)
      part.later.push_back({stretch.row - first_row, stretch.from});
  }
  return part;
}

Span span_of(const sim::Recording& recording) {
  Span span{recording.from, recording.to()};
  for (const sim::LaterStretch& stretch : recording.later) {
    span.from = std::min(span.from, stretch.from);
    span.to = std::max(span.to, {recording.time(stretch.row - 1).seconds + row_s});
  }
  return span;
}

namespace {

/// `simulate(changes, recording)` of each stretch; empty where it is.
template <class Simulate>
sim::ChannelTable each_stretch(const Engine& engine, const Changes& changes, const sim::Recording& recording,
                               const Simulate& simulate) {
  if (recording.later.empty()) return simulate(changes, recording);
  // What sensors alone show counts days from the first stretch's first day on, in responses too.
  Changes lived = changes, shown;
  const auto only_shown = std::stable_partition(
      lived.begin(), lived.end(), [&engine](const sim::EffectChange& c) { return !engine.only_shows(*c.at.effect); });
  shown.assign(only_shown, lived.end());
  lived.erase(only_shown, lived.end());
  sim::ChannelTable table(static_cast<Eigen::Index>(recording.rows.size()), engine.channels().count());
  for (std::size_t i = 0; i <= recording.later.size(); ++i) {
    const std::size_t first = i == 0 ? 0 : recording.later[i - 1].row;
    const std::size_t last = i < recording.later.size() ? recording.later[i].row : recording.rows.size();
    const sim::ChannelTable part = simulate(lived, part_of(recording, first, last - first));
    if (part.size() == 0) return {};
    table.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(last - first)) = part;
  }
  return shown.empty() ? table : sim::changed_sensors(std::move(table), engine.channels(), shown);
}

}  // namespace

sim::ChannelTable StretchedEngine::simulate(const Changes& changes, const sim::Recording& recording) const {
  return each_stretch(engine(), changes, recording, [this](const Changes& lived, const sim::Recording& part) {
    return engine().simulate(lived, part);
  });
}

sim::ChannelTable StretchedEngine::simulate_differing(std::uint64_t seed, const Changes& changes,
                                                      const sim::Recording& recording) const {
  return each_stretch(engine(), changes, recording, [this, seed](const Changes& lived, const sim::Recording& part) {
    return engine().simulate_differing(seed, lived, part);
  });
}

}  // namespace airside::tools::gap
