#include <algorithm>
#include <set>

#include "tools/gap/score/score_measures.hpp"

namespace airside::tools::gap {

namespace {

struct ConfusedCase {
  std::string row, right, said;
  int order = 0;  ///< library, real, outside, nothing
};

ConfusedCase confused(const ScoredCase& c) {
  ConfusedCase one;
  if (c.hidden.empty()) {
    one = {c.set == "real_null" ? "nothing (real)" : "nothing", "none", "", 3};
  } else {
    const std::string name = name_of(c.hidden[0].id);
    if (c.set == "outside")
      one = {name + " (outside)", "unknown", "", 2};
    else if (c.set == "real")
      one = {name + " (real)", name, "", 1};
    else
      one = {name, name, "", 0};
  }
  one.said = c.answered ? kind_names[static_cast<std::size_t>(c.kind)] : "no verdict";
  if (is_named(c)) {
    const auto right = std::ranges::find(c.effects, one.right, [](const SaidEffect& e) { return name_of(e.id); });
    one.said = right == c.effects.end() ? name_of(c.effects[0].id) : one.right;
  }
  return one;
}

}  // namespace

Confusion confusion_of(const std::vector<ScoredCase>& cases, const std::function<bool(const ScoredCase&)>& takes) {
  static const std::vector<std::string> abstentions{"ambiguous", "unknown", "none", "refused", "no verdict"};
  const auto is_effect = [](const std::string& word) {
    return std::ranges::find(abstentions, word) == abstentions.end();
  };
  std::vector<ConfusedCase> list;
  std::set<std::pair<int, std::string>> rows;
  std::map<std::string, std::string> right_of;
  std::set<std::string> effects, said;
  for (const ScoredCase& c : cases) {
    if (c.set == "pair" || !takes(c)) continue;
    const ConfusedCase one = confused(c);
    rows.insert({one.order, one.row});
    right_of[one.row] = one.right;
    for (const std::string& word : {one.right, one.said}) {
      if (is_effect(word)) effects.insert(word);
    }
    said.insert(one.said);
    list.push_back(one);
  }
  Confusion result;
  if (list.empty()) return result;
  result.said.assign(effects.begin(), effects.end());
  for (const std::string& word : abstentions) {
    const bool rare = word == "refused" || word == "no verdict";
    if (!rare || said.contains(word)) result.said.push_back(word);
  }
  for (const auto& [order, name] : rows) {
    result.hidden.push_back(name);
    result.right.push_back(right_of[name]);
  }
  result.counts.assign(result.hidden.size(), std::vector<int>(result.said.size(), 0));
  const auto index = [](const std::vector<std::string>& names, const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  for (const ConfusedCase& one : list) ++result.counts[index(result.hidden, one.row)][index(result.said, one.said)];
  return result;
}

}  // namespace airside::tools::gap
