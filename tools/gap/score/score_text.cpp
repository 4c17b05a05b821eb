#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tools/gap/score/score.hpp"
#include "tools/gap/score/score_cases.hpp"
#include "tools/gap/score/score_tests.hpp"

namespace airside::tools::gap {

namespace {

std::string target_text(const Target& target) {
  return fmt::format("{} {:g} %", target.at_least ? "≥" : "≤", 100 * target.value);
}

/// Whether the target is met, and whether so few cases can tell.
std::string judged(const CountRow& row) {
  if (row.n == 0) return "no cases";
  const auto [low, high] = row.interval();
  const bool met = row.target->holds(row.share());
  const bool sure = row.target->holds(low) == met && row.target->holds(high) == met;
  return fmt::format("{}{}", met ? "met" : "MISSED", sure ? "" : ", unsure");
}

std::string judged(const SpreadRow& row) {
  if (row.n == 0) return "no cases";
  return row.target->holds(row.median) ? "met" : "MISSED";
}

std::string percent(double share) { return std::isfinite(share) ? fmt::format("{:.1f}", 100 * share) : "–"; }

void write_targets(std::string& text, const ScoreTable& table) {
  text += fmt::format("\nAgainst the targets (%, Wilson 95 % intervals; unsure: the interval reaches across)\n");
  text += fmt::format("  {:<12}{:<18}{:<14}{:>9}{:>9}  {:<16}{:<9}{}\n", "set", "measure", "slice", "cases", "share",
                      "interval", "target", "");
  for (const CountRow& row : table.counts) {
    if (!row.target) continue;
    const auto [low, high] = row.interval();
    text += fmt::format("  {:<12}{:<18}{:<14}{:>9}{:>9}  {:<16}{:<9}{}\n", row.set, row.measure, row.slice,
                        fmt::format("{}/{}", row.k, row.n), row.n > 0 ? percent(row.share()) : "–",
                        row.n > 0 ? fmt::format("{} .. {}", percent(low), percent(high)) : "", target_text(*row.target),
                        judged(row));
  }
  for (const SpreadRow& row : table.spreads) {
    if (!row.target) continue;
    text += fmt::format("  {:<12}{:<18}{:<14}{:>9}{:>9}  {:<16}{:<9}{}\n", row.set, row.measure, "median", row.n,
                        row.n > 0 ? percent(row.median) : "–",
                        row.n > 0 ? fmt::format("{} .. {} *", percent(row.quartile_1), percent(row.quartile_3)) : "",
                        target_text(*row.target), judged(row));
  }
  text += "  * quartiles\n";
}

/// Slices down, measures across, three at a time.
void write_slices(std::string& text, const ScoreTable& table, const std::string& set) {
  std::vector<std::string> slices, columns;
  const auto note = [](std::vector<std::string>& list, const std::string& name) {
    if (std::ranges::find(list, name) == list.end()) list.push_back(name);
  };
  for (const CountRow& row : table.counts) {
    if (row.set != set || row.n == 0) continue;
    note(slices, row.slice);
    note(columns, row.measure);
  }
  for (std::size_t from = 0; from < columns.size(); from += 3) {
    const std::size_t to = std::min(from + 3, columns.size());
    text += fmt::format("\n  {:<34}", set);
    for (std::size_t i = from; i < to; ++i) text += fmt::format("{:>28}", columns[i]);
    text += '\n';
    for (const std::string& slice : slices) {
      std::string line = fmt::format("  {:<34}", slice);
      for (std::size_t i = from; i < to; ++i) {
        const auto row = std::ranges::find_if(table.counts, [&](const CountRow& r) {
          return r.set == set && r.slice == slice && r.measure == columns[i];
        });
        std::string cell;
        if (row != table.counts.end() && row->n > 0) {
          const auto [low, high] = row->interval();
          cell = fmt::format("{} [{}, {}] {}/{}", percent(row->share()), percent(low), percent(high), row->k, row->n);
        }
        line += fmt::format("{:>28}", cell);
      }
      text += line + '\n';
    }
  }
}

void write_confusions(std::string& text, const Confusion& c, const char* which) {
  struct Mistake {
    int count = 0, of = 0;
    std::size_t row = 0, column = 0;
  };
  std::vector<Mistake> mistakes;
  for (std::size_t i = 0; i < c.hidden.size(); ++i) {
    int of = 0;
    for (const int n : c.counts[i]) of += n;
    for (std::size_t j = 0; j < c.said.size(); ++j) {
      if (c.counts[i][j] > 0 && c.said[j] != c.right[i]) mistakes.push_back({c.counts[i][j], of, i, j});
    }
  }
  if (mistakes.empty()) return;
  std::ranges::stable_sort(mistakes, std::greater<>(), &Mistake::count);
  text += fmt::format("\nMost often said instead ({})\n", which);
  for (std::size_t i = 0; i < std::min<std::size_t>(12, mistakes.size()); ++i) {
    const Mistake& m = mistakes[i];
    text += fmt::format("  {:<32} {:<32} {:>4} of {}\n", c.hidden[m.row], c.said[m.column], m.count, m.of);
  }
}

void write_posteriors(std::string& text, const PosteriorFacts& p) {
  if (p.reliability.empty()) return;
  text += fmt::format(
      "\nPosteriors: the smallest sets of 90 % hold {:g} effects (quartiles {:g} and {:g}; {} of ratio >= 1)\n",
      p.set_size_median, p.set_size_quartile_1, p.set_size_quartile_3, p.single);
  text += "  how probable the likeliest was, and how often it was the truth (without single cases of ratio < 1)\n";
  for (const ReliabilityBin& bin : p.reliability) {
    if (bin.n == 0) continue;
    const auto [low, high] = wilson_95(bin.came, bin.n);
    text += fmt::format("  {:>3.0f} to {:>3.0f} %: said {:>5} %, came {:>5} % [{}, {}] {}/{}\n", 100 * bin.low,
                        100 * bin.high, percent(bin.said), percent(static_cast<double>(bin.came) / bin.n), percent(low),
                        percent(high), bin.came, bin.n);
  }
}

}  // namespace

std::string text_of(const ScoreTable& table) {
  std::string text = "What was tested (planned: a quarter from EnergyPlus, half of that with feedback)\n";
  text += fmt::format("  {:<12}{:>8}{:>9}{:>12}{:>15}{:>17}{:>14}\n", "set", "cases", "planned", "EnergyPlus",
                      "with feedback", "without verdict", "logs refused");
  for (const SetFacts& s : table.sets) {
    text += fmt::format("  {:<12}{:>8}{:>9}{:>12}{:>15}{:>17}{:>14}\n", s.set, s.cases, s.planned, s.energyplus,
                        s.energyplus_feedback, s.unanswered, s.refused);
  }
  write_targets(text, table);
  text += tests_text(table);
  text += "\nIn parts: % [Wilson 95 % interval] cases\n";
  for (const char* set : set_names) write_slices(text, table, set);
  for (const char* set : {"named", "right names"}) write_slices(text, table, set);
  text += fmt::format("\n  {:<34}{:>16}{:>8}{:>12}{:>12}{:>12}\n", "quartiles, %", "", "n", "25 %", "median", "75 %");
  for (const SpreadRow& row : table.spreads) {
    if (row.n == 0) continue;
    text += fmt::format("  {:<34}{:>16}{:>8}{:>12}{:>12}{:>12}\n", row.slice, row.measure, row.n,
                        percent(row.quartile_1), percent(row.median), percent(row.quartile_3));
  }
  write_posteriors(text, table.posteriors);
  write_confusions(text, table.confusion, "all but ratio < 1");
  write_confusions(text, table.confusion_below_1, "ratio < 1");
  if (!table.warnings.empty()) text += "\nWarnings\n";
  for (const std::string& warning : table.warnings) text += "  " + warning + "\n";
  return text;
}

}  // namespace airside::tools::gap
