#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "tools/gap/score/score_measures.hpp"

namespace airside::tools::gap {

namespace {

bool contains(const std::vector<std::string>& list, const std::string& id) {
  return std::ranges::find(list, id) != list.end();
}

/// What is true beside the other findings: any of these.
std::vector<std::string> truth_of(const ScoredCase& c, const SaidPosterior& p) {
  if (c.set == "outside") return {"other"};
  std::vector<std::string> left;
  for (const HiddenEffect& h : c.hidden) {
    if (!contains(p.beside, h.id)) left.push_back(h.id);
  }
  if (left.empty()) left.emplace_back("nothing");
  return left;
}

bool holds_truth(const ScoredCase& c, const SaidPosterior& p) {
  const auto truth = truth_of(c, p);
  return std::ranges::any_of(truth, [&p](const std::string& id) { return contains(p.set, id); });
}

bool is_small(const ScoredCase& c) { return c.set == "single" && c.ratio && *c.ratio < 1; }

void count_sets_that_hold(ScoreTable& table, const std::vector<ScoredCase>& cases) {
  struct SetGroup {
    const char* name;
    std::function<bool(const ScoredCase&)> takes;
  };
  const std::array slices{SetGroup{"all", [](const ScoredCase&) { return true; }},
                          SetGroup{"ratio 0.5", [](const ScoredCase& c) { return c.ratio && *c.ratio == 0.5; }},
                          SetGroup{"ratio 1", [](const ScoredCase& c) { return c.ratio && *c.ratio == 1; }},
                          SetGroup{"ratio 3", [](const ScoredCase& c) { return c.ratio && *c.ratio == 3; }},
                          SetGroup{"ratio >= 1", [](const ScoredCase& c) { return c.ratio && *c.ratio >= 1; }}};
  for (const char* set : set_names) {
    for (const SetGroup& slice : slices) {
      if (std::string(set) != "single" && std::string(slice.name) != "all") continue;
      CountRow row{set, "90 % set", slice.name, 0, 0, std::nullopt};
      if (std::string(slice.name) == "ratio >= 1") row.target = Target{0.9, true};
      for (const ScoredCase* c : of_set(cases, set)) {
        if (c->posteriors.empty() || !slice.takes(*c)) continue;
        ++row.n;
        row.k += std::ranges::all_of(c->posteriors, [c](const SaidPosterior& p) { return holds_truth(*c, p); }) ? 1 : 0;
      }
      if (row.n > 0) table.counts.push_back(row);
    }
  }
}

void add_to_bins(PosteriorFacts& facts, const ScoredCase& c, const SaidPosterior& p) {
  const auto likeliest = std::ranges::max_element(p.probabilities, {}, [](const auto& one) { return one.second; });
  for (ReliabilityBin& bin : facts.reliability) {
    if (likeliest->second <= bin.low || likeliest->second > bin.high) continue;
    bin.said += likeliest->second;
    ++bin.n;
    bin.came += contains(truth_of(c, p), likeliest->first) ? 1 : 0;
  }
}

}  // namespace

void measure_posteriors(ScoreTable& table, const std::vector<ScoredCase>& cases) {
  count_sets_that_hold(table, cases);
  PosteriorFacts& facts = table.posteriors;
  const bool any = std::ranges::any_of(cases, [](const ScoredCase& c) { return !c.posteriors.empty(); });
  if (!any) return;
  constexpr std::array edges{0.0, 0.5, 0.8, 0.95, 1.0};
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) facts.reliability.push_back({edges[i], edges[i + 1]});
  std::vector<double> sizes;
  for (const ScoredCase& c : cases) {
    if (is_small(c)) continue;
    for (const SaidPosterior& p : c.posteriors) {
      add_to_bins(facts, c, p);
      if (c.set == "single") sizes.push_back(static_cast<double>(p.set.size()));
    }
  }
  for (ReliabilityBin& bin : facts.reliability) bin.said /= std::max(1, bin.n);
  std::ranges::sort(sizes);
  facts.single = static_cast<int>(sizes.size());
  if (sizes.empty()) return;
  const auto at = [&sizes](double share) {
    return sizes[static_cast<std::size_t>(std::lround(share * static_cast<double>(sizes.size() - 1)))];
  };
  facts.set_size_quartile_1 = at(0.25);
  facts.set_size_median = at(0.5);
  facts.set_size_quartile_3 = at(0.75);
}

}  // namespace airside::tools::gap
