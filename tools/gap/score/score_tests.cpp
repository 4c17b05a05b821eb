#include "tools/gap/score/score_tests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tools/gap/score/score_measures.hpp"

namespace airside::tools::gap {

namespace {

bool is_hidden(const std::string& id, const ScoredCase& c) {
  return std::ranges::find(c.hidden, id, &HiddenEffect::id) != c.hidden.end();
}
bool says_exactly(const ScoredCase& c) {
  return is_named(c) && std::ranges::any_of(c.effects, [&](const SaidEffect& e) { return is_hidden(e.id, c); });
}
bool says_in_class(const ScoredCase& c) {
  if (!is_named(c) && c.kind != SaidKind::ambiguous) return false;
  return std::ranges::any_of(c.effects, [&](const SaidEffect& e) {
    return is_hidden(e.id, c) || std::ranges::any_of(e.class_ids, [&](const auto& id) { return is_hidden(id, c); });
  });
}

std::string after(std::size_t tests) { return fmt::format(", {} test{}", tests, tests == 1 ? "" : "s"); }

/// The verdicts after at most that number of tests.
std::vector<ScoredCase> after_at_most(std::size_t tests, const std::vector<ScoredCase>& cases) {
  std::vector<ScoredCase> said;
  for (const ScoredCase& c : cases) said.push_back(c.after.empty() ? c : c.after[std::min(tests, c.after.size()) - 1]);
  return said;
}

void count_tests(ScoreTable& table, const std::vector<ScoredCase>& cases) {
  std::map<std::string, TestFacts> tests;
  for (const ScoredCase& c : cases) {
    if (c.after.empty() || c.after.back().tests.empty() || c.set != "single") continue;
    const ScoredCase& last = c.after.back();
    TestFacts& facts = tests[last.tests.back()];
    facts.test = last.tests.back();
    ++facts.cases;
    facts.before += says_exactly(c) ? 1 : 0;
    facts.exact += says_exactly(last) ? 1 : 0;
    facts.in_class += says_in_class(last) ? 1 : 0;
    facts.wrong += is_named(last) && !says_in_class(last) ? 1 : 0;
  }
  for (const auto& [name, facts] : tests) table.tests.push_back(facts);
  std::ranges::stable_sort(table.tests, std::greater<>(), &TestFacts::cases);
}

std::string cell(const CountRow* row) {
  if (row == nullptr || row->n == 0) return "";
  const auto [low, high] = row->interval();
  return fmt::format("{:.1f} [{:.1f}, {:.1f}] {}/{}", 100 * row->share(), 100 * low, 100 * high, row->k, row->n);
}

}  // namespace

void count_after_tests(ScoreTable& table, const std::vector<ScoredCase>& cases) {
  std::size_t most = 0;
  for (const ScoredCase& c : cases) most = std::max(most, c.after.size());
  for (std::size_t tests = 1; tests <= most; ++tests) {
    ScoreTable later;
    count_sets(later, after_at_most(tests, cases));
    for (CountRow& row : later.counts) {
      if (row.n == 0) continue;
      row.measure += after(tests);
      row.target.reset();
      table.counts.push_back(std::move(row));
    }
  }
  if (most > 0) count_tests(table, cases);
}

std::string tests_text(const ScoreTable& table) {
  if (table.tests.empty()) return "";
  const auto find = [&](const std::string& measure, const std::string& slice) -> const CountRow* {
    const auto row = std::ranges::find_if(
        table.counts, [&](const CountRow& r) { return r.set == "single" && r.measure == measure && r.slice == slice; });
    return row == table.counts.end() ? nullptr : &*row;
  };
  std::string text = "\nSingle effects, without and with executed tests: % [Wilson 95 % interval] cases\n";
  for (const char* slice : {"ratio 0.5", "ratio 1", "ratio 3", "ratio >= 1"}) {
    for (const char* measure : {"exact", "class", "wrong name"}) {
      if (cell(find(measure, slice)).empty()) continue;
      text += fmt::format("  {:<12}{:<12}passive {:<30}", slice, measure, cell(find(measure, slice)));
      for (std::size_t tests = 1; find(measure + after(tests), slice) != nullptr; ++tests)
        text += fmt::format("at most {} {:<30}", tests, cell(find(measure + after(tests), slice)));
      text.erase(text.find_last_not_of(' ') + 1);
      text += '\n';
    }
  }
  text += fmt::format("  {:<24}{:>7}{:>14}{:>14}{:>10}{:>8}\n", "test, the last of a case", "cases", "exact before",
                      "exact after", "in class", "wrong");
  for (const TestFacts& t : table.tests) {
    text +=
        fmt::format("  {:<24}{:>7}{:>14}{:>14}{:>10}{:>8}\n", t.test, t.cases, t.before, t.exact, t.in_class, t.wrong);
  }
  return text;
}

nlohmann::json tests_json(const ScoreTable& table) {
  nlohmann::json list = nlohmann::json::array();
  for (const TestFacts& t : table.tests) {
    list.push_back({{"test", t.test},
                    {"cases", t.cases},
                    {"exact_before", t.before},
                    {"exact_after", t.exact},
                    {"in_class", t.in_class},
                    {"wrong_name", t.wrong}});
  }
  return list;
}

}  // namespace airside::tools::gap
