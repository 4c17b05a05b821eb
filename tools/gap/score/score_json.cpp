#include <cmath>

#include "tools/gap/score/score.hpp"
#include "tools/gap/score/score_tests.hpp"

namespace airside::tools::gap {

namespace {

using Json = nlohmann::json;

Json number_json(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

template <class Row>
void add_target(Json& object, const Row& row, double figure) {
  if (!row.target) return;
  object["target"] = {{row.target->at_least ? "at_least" : "at_most", row.target->value}};
  object["met"] = row.n > 0 ? Json(row.target->holds(figure)) : Json(nullptr);
}

Json confusion_json(const Confusion& c) {
  return {{"hidden", c.hidden}, {"right", c.right}, {"said", c.said}, {"counts", c.counts}};
}

}  // namespace

nlohmann::json json_of(const ScoreTable& table) {
  Json object = {{"format", 1},
                 {"sets", Json::array()},
                 {"counts", Json::array()},
                 {"spreads", Json::array()},
                 {"confusion", confusion_json(table.confusion)},
                 {"confusion_below_1", confusion_json(table.confusion_below_1)},
                 {"tests", tests_json(table)},
                 {"warnings", table.warnings}};
  for (const SetFacts& s : table.sets) {
    object["sets"].push_back({{"set", s.set},
                              {"cases", s.cases},
                              {"planned", s.planned},
                              {"energyplus", s.energyplus},
                              {"energyplus_feedback", s.energyplus_feedback},
                              {"unanswered", s.unanswered},
                              {"refused", s.refused}});
  }
  for (const CountRow& row : table.counts) {
    const auto [low, high] = row.interval();
    Json one = {{"set", row.set}, {"measure", row.measure}, {"slice", row.slice}, {"k", row.k}, {"n", row.n}};
    one["share"] = row.n > 0 ? Json(row.share()) : Json(nullptr);
    one["interval"] = {low, high};
    add_target(one, row, row.share());
    object["counts"].push_back(one);
  }
  for (const SpreadRow& row : table.spreads) {
    Json one = {{"set", row.set}, {"measure", row.measure}, {"slice", row.slice}, {"n", row.n}};
    const bool any = row.n > 0;
    one["quartile_1"] = any ? number_json(row.quartile_1) : Json(nullptr);
    one["median"] = any ? number_json(row.median) : Json(nullptr);
    one["quartile_3"] = any ? number_json(row.quartile_3) : Json(nullptr);
    add_target(one, row, row.median);
    object["spreads"].push_back(one);
  }
  const PosteriorFacts& p = table.posteriors;
  object["posteriors"] = {{"single", p.single},
                          {"set_size", {p.set_size_quartile_1, p.set_size_median, p.set_size_quartile_3}},
                          {"reliability", Json::array()}};
  for (const ReliabilityBin& bin : p.reliability) {
    const auto [low, high] = wilson_95(bin.came, bin.n);
    object["posteriors"]["reliability"].push_back({{"above", bin.low},
                                                   {"to", bin.high},
                                                   {"n", bin.n},
                                                   {"said", bin.said},
                                                   {"came", bin.came},
                                                   {"interval", {low, high}}});
  }
  return object;
}

}  // namespace airside::tools::gap
