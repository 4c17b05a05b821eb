#include "tools/study/method/claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "tools/study/method/tables.hpp"
#include "tools/study/table.hpp"

namespace airside::tools {

namespace {

/// Parts of a claim, as they are found.
class Judgement {
 public:
  explicit Judgement(const MethodResults& results) : results_(results) {}

  /// A figure's mean over rooms and seeds; where there is no run the claim cannot be judged.
  double mean(const std::string& row, const std::string& key, const std::string& room = "") {
    const Spread s = results_.spread(row, key, room);
    if (s.count == 0) missing_ = true;
    return s.mean;
  }
  void part(bool holds, const std::string& text) {
    (holds ? held_ : failed_) += 1;
    text_ += (text_.empty() ? "" : "; ") + text;
  }
  /// `a` below `b`, or above it.
  void below(const std::string& what, double a, double b) {
    part(a < b, fmt::format("{} {:.3f} and {:.3f}", what, a, b));
  }
  void above(const std::string& what, double a, double b) {
    part(a > b, fmt::format("{} {:.3f} and {:.3f}", what, a, b));
  }

  const MethodResults& results() const { return results_; }
  ClaimState state() const {
    if (missing_) return ClaimState::not_run;
    if (failed_ == 0) return ClaimState::reproduced;
    return held_ == 0 ? ClaimState::not_reproduced : ClaimState::partly;
  }
  std::string text() const { return missing_ ? "" : text_; }

 private:
  const MethodResults& results_;
  bool missing_ = false;
  int held_ = 0, failed_ = 0;
  std::string text_;
};

/// Rank correlation of n figures without ties with 1 .. n.
double rank_correlation(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  double squares = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto rank = std::ranges::count_if(values, [&](double v) { return v < values[i]; });
    squares += std::pow(static_cast<double>(rank) - static_cast<double>(i), 2);
  }
  return 1 - 6 * squares / (n * (n * n - 1));
}

constexpr std::array<const char*, 4> by_gamma = {"a1.00-b0.90-g0.10", "a1.00-b0.90-g0.25", "paper",
                                                 "a1.00-b0.90-g0.75"};
constexpr std::array<const char*, 3> holding = {"a0.50-b0.90-g0.25", "a0.75-b0.90-g0.25", "a1.00-b1.10-g0.25"};
constexpr std::array<const char*, 8> correcting = {"a1.00-b0.90-g0.25",
                                                   "a1.10-b0.90-g0.25",
                                                   "a1.50-b0.90-g0.25",
                                                   "a1.00-b0.50-g0.25",
                                                   "a1.00-b0.75-g0.25",
                                                   "a1.00-b0.90-g0.10",
                                                   "paper",
                                                   "a1.00-b0.90-g0.75"};

void physics(Judgement& j) {
  j.below("wrong signs with and without", j.mean("physics", "with_violation_share"),
          j.mean("physics", "without_violation_share"));
  j.below("error K", j.mean("physics", "with_mae_k"), j.mean("physics", "without_mae_k"));
}

void comparison(Judgement& j) {
  const double ours = j.mean("paper", "dae_degc");
  j.below("DAE and PID's", ours, j.mean("pid", "dae_degc"));
  j.below("DAE and the schedule's", ours, j.mean("expert", "dae_degc"));
  j.above("the schedule's DAE and 1 °C", j.mean("expert", "dae_degc"), 1);
}

void holds_where_beta_is_larger(Judgement& j) {
  double least = HUGE_VAL, most = 0;
  for (const char* row : holding) least = std::min(least, j.mean(row, "dae_degc"));
  for (const char* row : correcting) most = std::max(most, j.mean(row, "dae_degc"));
  j.part(least >= 3 * most, fmt::format("least DAE of a_s < b_s {:.3f}, largest of a_s > b_s {:.3f}", least, most));
}

void gamma_trades(Judgement& j) {
  std::vector<double> darv, dae;
  for (const std::uint64_t seed : j.results().seeds_of("paper")) {
    const MethodResults one = j.results().of_seed(seed);
    if (!std::ranges::all_of(by_gamma, [&one](const char* row) { return one.has(row); })) continue;
    std::vector<double> unrest, error;
    for (const char* row : by_gamma) {
      unrest.push_back(one.mean(row, "darv_degc"));
      error.push_back(one.mean(row, "dae_degc"));
    }
    darv.push_back(rank_correlation(unrest));
    dae.push_back(rank_correlation(error));
  }
  if (darv.empty()) (void)j.mean("", "");
  j.part(spread_of(darv).mean < 0, fmt::format("rank correlation of g with DARV {:.2f}", spread_of(darv).mean));
  j.part(spread_of(dae).mean >= 0, fmt::format("with DAE {:.2f}", spread_of(dae).mean));
}

void without_physics(Judgement& j) {
  for (const char* key : {"dae_degc", "me_degc"})
    j.above(key == std::string_view("dae_degc") ? "DAE without and with" : "ME", j.mean("without-physics", key),
            j.mean("paper", key));
}

void without_branch(Judgement& j) {
  j.above("DARV without and with", j.mean("without-tdb", "darv_degc"), j.mean("paper", "darv_degc"));
}

void without_online(Judgement& j) {
  for (const auto& [key, name] : {std::pair{"me_degc", "ME"}, {"dae_degc", "DAE"}, {"darv_degc", "DARV"}}) {
    const double without = j.mean("without-online", key), with = j.mean("paper", key);
    j.part(without >= 2 * with, fmt::format("{} without {:.3f}, with {:.3f}", name, without, with));
  }
}

void confidence(Judgement& j) {
  j.below("ME with and without", j.mean("paper", "me_degc"), j.mean("without-confidence", "me_degc"));
  j.below("day 1", j.mean("paper", "day1_dae_degc"), j.mean("without-confidence", "day1_dae_degc"));
}

void dynamic_first(Judgement& j) {
  for (const char* room : {"701-real", "702-real"}) {
    const double dynamic = j.mean("offline", "dynamic_mean_k", room), fixed = j.mean("offline", "static_mean_k", room),
                 none = j.mean("offline", "scratch_mean_k", room);
    j.part(dynamic < fixed && fixed < none,
           fmt::format("{}: dynamic {:.3f}, static {:.3f}, scratch {:.3f} K", room, dynamic, fixed, none));
  }
}

void winter_is_harder(Judgement& j) {
  for (const char* room : {"701-real", "702-real"}) {
    j.above(fmt::format("{}: winter and summer", room), j.mean("offline", "dynamic_winter_k", room),
            j.mean("offline", "dynamic_summer_k", room));
  }
}

void two_weeks(Judgement& j) {
  for (const auto& [key, name] : {std::pair{"dae_degc", "DAE and PID's"}, {"darv_degc", "DARV"}, {"cdh_degch", "CDH"}})
    j.below(name, j.mean("paper", key), j.mean("pid", key));
}

void adapts_in_the_twin(Judgement& j) {
  j.below("DAE of day 14 and day 1", j.mean("source-dynamic", "day14_dae_degc"),
          j.mean("source-dynamic", "day1_dae_degc"));
  j.above("move 17-21 h and 10-14 h, K", j.mean("source-dynamic", "evening_move_k"),
          j.mean("source-dynamic", "midday_move_k"));
}

void covers_more(Judgement& j) {
  j.above("entropy of setpoints, dynamic and static, bit", j.mean("source-dynamic", "entropy_bit"),
          j.mean("source-static", "entropy_bit"));
  j.above("share near target", j.mean("source-dynamic", "near_target_share"),
          j.mean("source-static", "near_target_share"));
}

void beats_scratch(Judgement& j) {
  for (const auto& [key, name] : {std::pair{"first3_dae_degc", "first 3 days, transferred and scratch"},
                                  {"dae_degc", "14 days"},
                                  {"daily_sd_degc", "sd of days"}})
    j.below(name, j.mean("dynamic-5", key), j.mean("scratch-5", key));
}

void saves_area(Judgement& j) {
  for (const char* room : {"701-real", "702-real"}) {
    const double share = j.mean("dynamic-5", "saving_days_share", room);
    j.part(share >= 13.0 / 14, fmt::format("{}: {:.0f} % of the days", room, 100 * share));
  }
}

void room_to_room(Judgement& j) {
  for (const char* room : {"401-real", "402-real"}) {
    const double day7 = j.mean("room-to-room", "day7_dae_degc", room);
    j.part(day7 < 0.15, fmt::format("{}: DAE of day 7 {:.3f}", room, day7));
  }
}

void needs_less_data(Judgement& j) {
  for (const int days : {1, 3, 5}) {
    j.below(fmt::format("{} days, transferred and scratch", days), j.mean(fmt::format("dynamic-{}", days), "dae_degc"),
            j.mean(fmt::format("scratch-{}", days), "dae_degc"));
  }
}

void best_cycle(Judgement& j) {
  constexpr std::array<const char*, 4> by_length = {"paper-6", "paper-12", "paper", "paper-24"};
  j.above("DAE of 24 and 18 min", j.mean("paper-24", "dae_degc"), j.mean("paper", "dae_degc"));
  for (const char* row : {"paper-6", "paper-12"})
    j.above(fmt::format("DARV of {} and 18 min", row), j.mean(row, "darv_degc"), j.mean("paper", "darv_degc"));
  std::vector<double> errors;
  for (const char* row : by_length) errors.push_back(j.mean(row, "forecast_mae_k"));
  j.part(std::ranges::is_sorted(errors),
         fmt::format("error of one cycle, 6 to 24 min, {:.3f} K", fmt::join(errors, ", ")));
}

struct Claim {
  int number;
  const char* claim;
  const char* published;
  void (*judge)(Judgement&);  ///< none: `where`
  const char* where = "";     ///< it is measured; beside a rule: what the runs lack of the claim
};

constexpr auto all_claims = std::to_array<Claim>({
    {1, "a learned environment errs little, its slopes have the right sign", "0.0347 °C", nullptr,
     "tools/learn_environment prints it"},
    {2, "D' converges to the long-term deviation", "", nullptr, "tests/gradient/closed_form_test.cpp"},
    {3, "physics losses lower wrong signs and error after biased data", "DAE 0.0961 without, 0.0613 with", physics},
    {4, "lowest DAE of all methods", "0.03222; OSLN 0.17189; expert above 1", comparison,
     "OSLN and DDQN are not among these runs: tools/gym/method_peers"},
    {5, "a_s < b_s holds the temperature where it is", "DAE 0.28 to 0.34 beside about 0.056",
     holds_where_beta_is_larger},
    {6, "a larger g is calmer and less exact", "DARV 0.4041 to 0.2650, DAE 0.0546 to 0.0774", gamma_trades},
    {7, "without physics losses DAE and ME rise", "DAE 0.0961, 0.0613; ME 0.2656, 0.2322", without_physics},
    {8, "without the long-term branch DARV rises", "0.4110, 0.3562", without_branch},
    {9, "without online learning all get twice as large or more", "ME 0.6778, DAE 0.2978, DARV 0.9602", without_online},
    {10, "confidence lowers ME, above all on day 1", "0.2322 with, 0.3691 without", confidence},
    {11, "lower error than FATDM and DAF", "0.140, 0.177; others 0.555 to 0.740", nullptr,
     "tools/gym/method_peers runs those methods"},
    {12, "dynamic pretraining errs less than static, static less than none", "701: 0.140, 0.306, 0.405", dynamic_first},
    {13, "winter is harder than summer", "701: 0.202, 0.078; 702: 0.298, 0.056", winter_is_harder},
    {14, "18 min is the best cycle", "DAE 0.07; 24 min 0.10", best_cycle},
    {15, "lowest DAE and DARV in two weeks, CDH below PID's", "CDH 335.9, PID 342.5", two_weeks,
     "OSLN and DDQN are not among these runs: tools/gym/method_peers"},
    {16, "the network is better and faster than LSTM and Transformer", "DAE 0.03222, 0.6069", nullptr,
     "tools/gym/method_peers runs those networks"},
    {17, "the agent adapts in the twin; setpoints move most at 17-21 h", "", adapts_in_the_twin},
    {18, "dynamic pretraining covers more setpoints, nearer to the target", "", covers_more},
    {19, "twin and building are 0.4 to 1.6 K apart, the perimeter more", "0.4 to 1.6 K", nullptr,
     "tests/rc_plant/facts_test.cpp"},
    {20, "transferred weights beat scratch in the first days, in 14 days, and vary less", "", beats_scratch},
    {21, "setpoints above 20.5 °C save area on 13 of 14 days", "", saves_area},
    {22, "room to room: DAE below 0.15 °C within a week", "below 0.15", room_to_room},
    {23, "set-up in a week instead of six months", "", nullptr, "cannot be measured in simulation"},
    {24, "transfer needs less data: better at 1, 3 and 5 days", "", needs_less_data},
});

/// What the peers' own conditions say of a claim. Returns whether each of them could be judged.
bool add_conditions(Judgement& j, const PeerRows& peers, int claim) {
  bool any = false, all = true;
  for (const PeerCondition& c : peers.conditions) {
    if (c.claim != claim) continue;
    any = true;
    all = all && c.holds.has_value();
    if (c.holds) j.part(*c.holds, fmt::format("{}: {}", c.condition, *c.holds ? "yes" : "no"));
  }
  return any && all;
}

/// Verdict on one claim from runs and peers.
ClaimVerdict verdict_on(const Claim& claim, const MethodResults& results, const PeerRows& peers) {
  ClaimVerdict v{claim.number, claim.claim, claim.published, ClaimState::elsewhere, claim.where};
  Judgement judgement(results);
  if (claim.judge != nullptr) claim.judge(judgement);
  const bool is_whole = add_conditions(judgement, peers, claim.number);
  if (claim.judge == nullptr && judgement.text().empty()) return v;
  v.state = judgement.state();
  const bool lacks_some = !v.ours.empty() && !is_whole;
  if (lacks_some && v.state == ClaimState::reproduced) v.state = ClaimState::partly;
  if (is_whole) v.ours.clear();
  const bool both = !judgement.text().empty() && !v.ours.empty();
  v.ours = judgement.text() + (both ? "; " : "") + v.ours;
  return v;
}

}  // namespace

const char* text_of(ClaimState state) {
  switch (state) {
    case ClaimState::reproduced: return "reproduced";
    case ClaimState::partly: return "partly";
    case ClaimState::not_reproduced: return "not reproduced";
    case ClaimState::not_run: return "not run";
    case ClaimState::elsewhere: break;
  }
  return "not by these runs";
}

std::vector<ClaimVerdict> judge_claims(const MethodResults& results, const PeerRows& peers) {
  std::vector<ClaimVerdict> list;
  for (const Claim& claim : all_claims) list.push_back(verdict_on(claim, results, peers));
  return list;
}

nlohmann::json json_of(const std::vector<ClaimVerdict>& verdicts) {
  nlohmann::json list = nlohmann::json::array();
  for (const ClaimVerdict& v : verdicts) {
    list.push_back({{"number", v.number},
                    {"claim", v.claim},
                    {"published", v.published},
                    {"verdict", text_of(v.state)},
                    {"ours", v.ours}});
  }
  return list;
}

std::string claims_markdown(const std::vector<ClaimVerdict>& verdicts) {
  std::vector<std::vector<std::string>> lines = {{"", "claim", "published", "verdict", "ours"}};
  for (const ClaimVerdict& v : verdicts)
    lines.push_back({std::to_string(v.number), v.claim, v.published, text_of(v.state), v.ours});
  return "### Claims\n\n" + markdown_of(lines);
}

}  // namespace airside::tools
