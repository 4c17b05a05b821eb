// The score of every candidate, the choice among them, and twenty steps of the confidence, against the reference.

#include "airside/forecast/scores.hpp"
#include "airside/network/forward.hpp"
#include "airside/network/scaler.hpp"
#include "airside/presets.hpp"
#include "airside/supervision/confidence.hpp"
#include "golden/golden_files.hpp"

namespace airside::golden {
namespace {

using L = Layout<FiveZone>;

ControllerSettings settings_of_config() {
  const json& c = meta().at("config");
  ControllerSettings s = paper_settings();
  s.score_alpha = c.at("score_alpha");
  s.score_beta = c.at("score_beta");
  s.gamma = c.at("gamma");
  s.confidence_smoothing = c.at("conf_beta");
  s.confidence_scale = c.at("conf_sigma");
  s.confidence_initial = c.at("conf0");
  return s;
}

double mean_of(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x;
  return sum / static_cast<double>(v.size());
}

TEST(GoldenScores, EveryCandidateAndTheChoiceAreTheReferences) {
  const json golden = read_json("scores.json");
  Scaler<FiveZone> scaler;
  for (int i = 0; i < L::inputs; ++i) {
    scaler.mean(i) = golden.at("scaler_mean").at(static_cast<std::size_t>(i));
    scaler.scale(i) = golden.at("scaler_scale").at(static_cast<std::size_t>(i));
  }
  const auto weights = weights_of<double>("weights");
  auto scratch = make_scratch<double>();
  auto packed = std::make_unique<PackedWeights<FiveZone, double>>();
  pack(weights, scratch->kernels, *packed);
  ControllerSettings s = settings_of_config();
  double worst = 0;
  std::size_t candidates = 0;
  for (const json& c : golden.at("cases")) {
    s.target_degc = c.at("t_exp");
    const auto actions = c.at("actions").get<std::vector<double>>();
    Reading<FiveZone>::Vector state;
    for (int i = 0; i < L::signals; ++i) {
      state(i) = i < L::rooms ? c.at("s_raw").at(static_cast<std::size_t>(i)).get<double>()
                              : c.at("e_raw").at(static_cast<std::size_t>(i - L::rooms)).get<double>();
    }
    const auto scaled = scaler.signals<double>(state);
    std::vector<double> setpoints;
    for (const double a : actions) setpoints.push_back(scaler.setpoint<double>(a));
    std::vector<RoomForecast<FiveZone, double>> out(actions.size());
    forecast_candidates<FiveZone, double>(*packed, std::span<const double, L::signals>(scaled.data(), L::signals),
                                          setpoints, *scratch, out);
    std::vector<double> scores;
    for (std::size_t k = 0; k < actions.size(); ++k) {
      double long_term = 0;
      for (std::size_t r = 0; r < static_cast<std::size_t>(L::rooms); ++r) {
        const double short_degc = scaler.room_mean() + scaler.room_scale() * out[k].short_term[r];
        const double deviation_k = scaler.room_scale() * out[k].deviation[r];
        worst = std::max(
            {worst, error_of(short_degc, c.at("short")[k][r]), error_of(deviation_k, c.at("deviation")[k][r])});
        long_term += (short_degc + deviation_k) / L::rooms;
      }
      EXPECT_NEAR(long_term, mean_of(c.at("long")[k].get<std::vector<double>>()), 1e-12);
      scores.push_back(setpoint_score(s, state.head<L::rooms>().mean(), long_term, 0.0));
      worst = std::max(worst, error_of(scores.back(), c.at("score")[k]));
      ++candidates;
    }
    const int best = best_candidate(s, scores, actions, actions.front());
    EXPECT_EQ(best, c.at("best").get<int>());
    EXPECT_EQ(actions[static_cast<std::size_t>(best)], c.at("a_highest").get<double>());
    EXPECT_GT(c.at("runner_up_gap").get<double>(), s.tie_degc)
        << "a tie would make the choice depend on the last setpoint";
  }
  EXPECT_GE(candidates, 100U);
  EXPECT_LT(worst, 1e-12);
}

TEST(GoldenConfidence, TwentyStepsAndTheFusedSetpointAreTheReferences) {
  const json golden = read_json("confidence.json");
  ControllerSettings s = settings_of_config();
  s.confidence_smoothing = golden.at("beta");
  s.confidence_scale = golden.at("sigma");
  double confidence = golden.at("alpha0");
  const auto loss = golden.at("loss").get<std::vector<double>>();
  ASSERT_GE(loss.size(), 20U);
  for (std::size_t i = 0; i < loss.size(); ++i) {
    confidence = confidence_step(s, confidence, loss[i]);
    EXPECT_NEAR(confidence, golden.at("alpha")[i].get<double>(), 1e-12);
    EXPECT_NEAR(fuse(confidence, golden.at("a_highest"), golden.at("a_expert")), golden.at("fused")[i].get<double>(),
                1e-12);
  }
}

}  // namespace
}  // namespace airside::golden
