#include "tools/report/charts/downsample.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace airside::tools {
namespace {

/// Appends the two values that stand for y[begin, end).
void append_extremes(const std::vector<double>& y, std::size_t begin, std::size_t end, std::vector<double>& out) {
  std::size_t least = end, greatest = end;
  for (std::size_t i = begin; i < end; ++i) {
    if (!std::isfinite(y[i])) continue;
    if (least == end || y[i] < y[least]) least = i;
    if (greatest == end || y[i] > y[greatest]) greatest = i;
  }
  if (least == end) {
    out.insert(out.end(), 2, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  out.push_back(y[std::min(least, greatest)]);
  out.push_back(y[std::max(least, greatest)]);
}

}  // namespace

LineChart downsample(const LineChart& chart, std::size_t points) {
  const std::size_t n = chart.x.size();
  if (n <= std::max<std::size_t>(points, 4)) return chart;
  const std::size_t buckets = std::max<std::size_t>(points / 2, 2);
  LineChart out = chart;
  out.x.clear();
  for (ChartSeries& s : out.series) {
    if (s.y.size() == n) s.y.clear();
  }
  for (std::size_t b = 0; b < buckets; ++b) {
    const std::size_t begin = b * n / buckets, end = (b + 1) * n / buckets;
    if (end - begin < 2) {  // fewer than two rows to the interval: keep them
      for (std::size_t i = begin; i < end; ++i) {
        out.x.push_back(chart.x[i]);
        for (std::size_t k = 0; k < chart.series.size(); ++k) {
          if (chart.series[k].y.size() == n) out.series[k].y.push_back(chart.series[k].y[i]);
        }
      }
      continue;
    }
    out.x.push_back(chart.x[begin]);
    out.x.push_back(chart.x[begin + (end - begin) / 2]);
    for (std::size_t k = 0; k < chart.series.size(); ++k) {
      if (chart.series[k].y.size() == n) append_extremes(chart.series[k].y, begin, end, out.series[k].y);
    }
  }
  return out;
}

}  // namespace airside::tools
