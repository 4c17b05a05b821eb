// Bills of an RC room in which something is hidden, and of one in which nothing is.

#include "tools/gap/bills/bill_verdict.hpp"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <random>

#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/bills/bill_picture.hpp"
#include "tools/gap/bills/bill_text.hpp"

namespace airside::tools::gap {
namespace {

/// May to September, two meters: fans and the plant.
class BillDesk {
 public:
  BillDesk() : effects_(sim::load_effects(sim::find_effects())) {
    std::erase_if(effects_, [](const sim::Effect& e) {
      return e.name != "fan_power" && e.name != "chiller_cop" && e.name != "gain_base" && e.name != "infiltration";
    });
    library_ = library_of(engine_, effects_);
    std::string text = "from,to,fans,plant\n";
    for (const char* month : {"05", "06", "07", "08", "09"})
      text += fmt::format("2021-{0}-01,2021-{0}-{1},1,1\n", month, month[1] == '6' || month[1] == '9' ? 30 : 31);
    const std::vector<std::string> names{"fans", "plant"};
    table_ = parse_bills(text, "bills.csv", names);
    responses_ = bill_responses(engine_, library_, table_, {0, 1}, weather_, 2);
  }

  /// Bills with this much of an effect's first or second probe in them, each off by 2 % of itself.
  BillTable bills(const std::string& id, std::size_t side, double share, unsigned seed) const {
    BillTable t = table_;
    t.kwh = responses_.base;
    std::size_t probe = 0;
    for (const BillResponses::Direction& d : responses_.candidates) {
      if (d.at.id() == id && probe++ % 2 == side) t.kwh += share * d.kwh;
    }
    std::mt19937_64 bits(seed);
    std::normal_distribution<double> noise(0, 0.02);
    for (double& kwh : t.kwh.reshaped()) kwh *= 1 + noise(bits);
    return t;
  }
  const BillResponses& responses() const { return responses_; }

 private:
  std::vector<sim::Effect> effects_;
  RcEngine engine_{sim::load_room("301")};
  std::shared_ptr<const sim::Weather> weather_ = sim::synthetic_weather(11);
  Library library_;
  BillTable table_;
  BillResponses responses_;
};

double sum_of_bills(const BillVerdict& v) {
  double sum = v.nothing + v.other;
  for (const BillCandidate& c : v.candidates) sum += c.probability;
  return sum;
}

TEST(Bills, NameAFanAndSayNothingOfARightModel) {
  const BillDesk desk;
  const BillTable right = desk.bills("", 0, 0, 1);
  const BillVerdict nothing = judge_bills({right, desk.responses()}, nullptr);
  EXPECT_NEAR(sum_of_bills(nothing), 1, 1e-9);
  EXPECT_GT(nothing.nothing, nothing.other);
  EXPECT_FALSE(nothing.named);
  EXPECT_EQ(sentence_of(nothing).rfind("nothing that these bills could show", 0), 0U) << sentence_of(nothing);

  // A year of bills before narrows what a level may be.
  const BillTable fan = desk.bills("fan_power", 1, 1.5, 2), before = desk.bills("", 0, 0, 3);
  const BillEvidence reference{before, desk.responses()};
  const BillVerdict with = judge_bills({fan, desk.responses()}, &reference);
  ASSERT_FALSE(with.candidates.empty());
  EXPECT_EQ(with.candidates[0].at.id(), "fan_power");
  EXPECT_TRUE(with.named) << text_of(with);
  const BillVerdict without = judge_bills({fan, desk.responses()}, nullptr);
  EXPECT_LT(without.candidates[0].probability, with.candidates[0].probability) << "wider without a reference";
  EXPECT_GT(with.candidates[0].kwh_per_day, 0);
}

TEST(Bills, HoldWhatTheyCannotShowAndSayIt) {
  const BillDesk desk;
  const BillTable right = desk.bills("", 0, 0, 1);
  const BillVerdict v = judge_bills({right, desk.responses()}, nullptr, {.period = 0.05, .level = 0.15});
  const std::string text = text_of(v);
  EXPECT_NE(text.find("what these bills could show"), std::string::npos) << text;
  BillPriors vague;
  vague.level = vague.period = 0.9;
  const BillVerdict blind = judge_bills({right, desk.responses()}, nullptr, vague);
  EXPECT_LT(std::abs(blind.nothing - vague.nothing), std::abs(v.nothing - vague.nothing))
      << "bills under vague priors leave what was believed before";
  int visible = 0;
  for (const BillCandidate& c : blind.candidates) visible += std::isfinite(c.visible_from) ? 1 : 0;
  int visible_before = 0;
  for (const BillCandidate& c : v.candidates) visible_before += std::isfinite(c.visible_from) ? 1 : 0;
  EXPECT_LT(visible, visible_before) << text_of(blind);
}

TEST(Bills, ThatAreStrangeAreSomethingElse) {
  const BillDesk desk;
  BillTable strange = desk.bills("", 0, 0, 4);
  strange.kwh(1, 0) *= 1.7;
  strange.kwh(3, 1) *= 0.5;
  const BillVerdict v = judge_bills({strange, desk.responses()}, nullptr);
  EXPECT_GT(v.other, 0.9) << text_of(v);
  EXPECT_EQ(sentence_of(v).rfind("unknown", 0), 0U);
}

TEST(Bills, AreAPictureAndAnObject) {
  const BillDesk desk;
  BillTable some = desk.bills("fan_power", 1, 1, 5);
  some.kwh(2, 1) = std::nan("");
  const BillVerdict v = judge_bills({some, desk.responses()}, nullptr);
  const std::string svg = bills_svg(some, v);
  EXPECT_NE(svg.find("2021-05-01: billed"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  const nlohmann::json j = json_of(v, some);
  EXPECT_TRUE(j["meters"][1]["bills"][2]["billed_kwh"].is_null());
  EXPECT_EQ(j["meters"][0]["bills"].size(), 5U);
  EXPECT_EQ(j["set"].size(), v.set.size());
}

}  // namespace
}  // namespace airside::tools::gap
