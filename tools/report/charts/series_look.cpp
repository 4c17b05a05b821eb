#include "tools/report/charts/series_look.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace airside::tools {
namespace {

constexpr std::size_t colour_count = 8, pattern_count = 12;

template <class List>
std::vector<SeriesLook> looks_of_list(const List& list) {
  const bool is_alone = list.size() == 1;
  std::vector<SeriesLook> looks;
  std::size_t next = 0;
  for (const auto& item : list) {
    if (item.role == SeriesRole::main) {
      looks.push_back({item.name, "main", "d0"});
    } else if (item.role == SeriesRole::reference) {
      looks.push_back({item.name, "ref", "dref"});
    } else {
      const std::size_t pattern = is_alone ? 0 : 1 + next % (pattern_count - 1);
      looks.push_back({item.name, fmt::format("c{}", next % colour_count), fmt::format("d{}", pattern),
                       item.role == SeriesRole::muted});
      ++next;
    }
  }
  return looks;
}

}  // namespace

std::vector<SeriesLook> looks_of(const LineChart& chart) { return looks_of_list(chart.series); }
std::vector<SeriesLook> looks_of(const BarChart& chart) { return looks_of_list(chart.groups); }

std::vector<ChartStretch> kinds_of(const std::vector<ChartStretch>& stretches) {
  std::vector<ChartStretch> kinds;
  for (const ChartStretch& stretch : stretches) {
    if (std::ranges::find(kinds, stretch.kind, &ChartStretch::kind) == kinds.end()) kinds.push_back(stretch);
  }
  return kinds;
}

const char* const own_style = R"(<style>
text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif;font-size:12px;fill:#3d4754}
.title{font-size:16px;font-weight:600;fill:#161c24}.paper{fill:#fff}
.grid{stroke:#e3e7ec;stroke-width:1}.axis{stroke:#8a94a0;stroke-width:1}.band{fill:#0b62b4;opacity:.06}
.stretch{fill-opacity:.2}.run{fill:#0b62b4}.expert{fill:#c77d00}.release{fill:#c4304d}.alarm{fill:#a97a00}
.line,.dash{fill:none;stroke-width:1.5;stroke-linejoin:round}.main{stroke-width:2.6}.muted{stroke-width:1.2;opacity:.75}
.bar.muted{opacity:.6}.bar.ref{opacity:.75}.whisker{stroke:#161c24;stroke-width:1}.cut{fill:#fff}
.d1{stroke-dasharray:9 3}.d2{stroke-dasharray:2 3}.d3{stroke-dasharray:9 3 2 3}.d4{stroke-dasharray:18 6}
.d5{stroke-dasharray:9 3 2 3 2 3}.d6{stroke-dasharray:1 7}.d7{stroke-dasharray:18 4 4 4}.d8{stroke-dasharray:4 10}
.d9{stroke-dasharray:9 3 9 3 2 3}.d10{stroke-dasharray:2 3 2 9}.d11{stroke-dasharray:18 3 2 3 2 3 2 3}
.dref{stroke-dasharray:5 5}
.main{--c:#0b62b4}.ref{--c:#6b7684}.c0{--c:#d1570f}.c1{--c:#0b8f6a}.c2{--c:#b8478f}.c3{--c:#a97a00}.c4{--c:#3aa0d8}
.c5{--c:#7a5cc7}.c6{--c:#8c5a3c}.c7{--c:#5b8c2a}.line,.dash{stroke:var(--c)}.bar,.key{fill:var(--c)}
</style>
<rect class="paper" width="100%" height="100%"/>
)";

}  // namespace airside::tools
