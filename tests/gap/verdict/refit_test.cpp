// The search for magnitudes and parameters, on a made-up engine whose answer is known.

#include "tools/gap/inference/refit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace airside::tools::gap {
namespace {

constexpr Eigen::Index engine_bins = 8 * bins_per_day;

Eigen::MatrixXd noise_table(unsigned seed, double sd) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal(0, sd);
  return Eigen::MatrixXd::NullaryExpr(engine_bins, 5, [&] { return normal(bits); });
}

/// Two rooms of which the engine knows what to show.
class MadeUpRooms : public Engine {
 public:
  sim::Channels channels() const override { return {2, 0, 1}; }
  std::array<bool, sim::facades> has_facade() const override { return {}; }
  bool can(const sim::Effect& /*effect*/) const override { return true; }
  std::string description() const override { return "made-up rooms"; }

 protected:
  static sim::ChannelTable rows_of(const Eigen::MatrixXd& shown) {
    sim::ChannelTable rows(engine_bins * rows_per_bin, 5);
    for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = shown.row(i / rows_per_bin);
    return rows;
  }
};

/// Two rooms, in which "heat" and "wall" add their patterns in proportion. As soon as the wall moves, whatever by,
/// thermostats switch at other times.
class SwitchingEngine final : public MadeUpRooms {
 public:
  bool switches = true;
  sim::Effect heat = effect("heat"), wall = effect("wall");
  Eigen::MatrixXd heat_pattern = noise_table(1, 0.1), wall_pattern = noise_table(2, 0.1), chance = noise_table(3, 1);

  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& /*recording*/) const override {
    Eigen::MatrixXd shown = Eigen::MatrixXd::Constant(engine_bins, 5, 25);
    for (const sim::EffectChange& c : changes) {
      const bool by_wall = c.at.effect == &wall;
      shown += c.magnitude * (by_wall ? wall_pattern : heat_pattern);
      if (by_wall && switches && std::abs(c.magnitude) > 1e-9) shown += chance;
    }
    return rows_of(shown);
  }

 private:
  static sim::Effect effect(const char* name) {
    sim::Effect e;
    e.name = name;
    e.low = -10;
    e.high = 10;
    return e;
  }
};

/// A log of the engine with some heat and a little of the wall, and what is known of it.
struct RefitCase {
  SwitchingEngine engine;
  Window window;
  Responses responses;
  ReferenceFit fit;
  std::vector<bool> kept = std::vector<bool>(static_cast<std::size_t>(engine_bins), true);
  Nuisance nuisance;

  explicit RefitCase(bool switches) {
    engine.switches = switches;
    window.measured = Eigen::MatrixXd::Constant(engine_bins, 5, 25) + 2 * engine.heat_pattern +
                      0.5 * engine.wall_pattern + noise_table(4, 0.05);
    responses.base = Eigen::MatrixXd::Constant(engine_bins, 5, 25);
    responses.parameters = {{{&engine.wall, 0}, 1, engine.wall_pattern}};
    responses.candidates = {{{&engine.heat, 0}, 1, engine.heat_pattern}, {{&engine.heat, 0}, -1, -engine.heat_pattern}};
    fit.estimate = Eigen::VectorXd::Zero(1);
    fit.covariance = Eigen::MatrixXd::Identity(1, 1);
    fit.noise = NoiseModel::fit(noise_table(5, 0.05), engine.channels());
    fit.parameters = responses.parameters;
  }

  Refit heat_added() const {
    const Refitter refitter(engine, window, responses, fit, nuisance, kept, 1, Refitter::Start::twin);
    const Refit none = refitter.at({}, Eigen::VectorXd::Zero(1), refitter.tangent());
    return refitter.add(none, {0, 0, 2, 1}, refitter.tangent());
  }
};

TEST(Refit, MovesMagnitudesAndParametersTogetherWhereNothingSwitches) {
  const Refit found = RefitCase(false).heat_added();
  EXPECT_NEAR(found.chosen[0].steps, 2, 0.1);
  EXPECT_NEAR(found.moved(0), 0.5, 0.1);
}

TEST(Refit, FindsAnEffectAloneWhereMovedParametersMakeThermostatsSwitch) {
  const Refit found = RefitCase(true).heat_added();
  EXPECT_NEAR(found.chosen[0].steps, 2, 0.2) << "chance must not hide the effect";
  EXPECT_EQ(found.moved(0), 0);
}

/// People who come late: each quarter of an hour shows in other bins, so that a little lateness looks like nothing of
/// much.
class LateEngine final : public MadeUpRooms {
 public:
  static constexpr double step_h = 0.25;
  sim::Effect late, wall;
  std::vector<Eigen::MatrixXd> shown_at;  // by quarters of an hour from -3 h on

  LateEngine() {
    late.name = "late";
    late.low = -3;
    late.high = 3;
    wall.name = "wall";
    wall.low = -10;
    wall.high = 10;
    for (unsigned i = 0; i <= 24; ++i) shown_at.push_back(i == 12 ? Eigen::MatrixXd::Zero(engine_bins, 5) : table(i));
  }
  static Eigen::MatrixXd table(unsigned i) { return noise_table(100 + i, 0.2); }
  Eigen::MatrixXd lateness(double hours) const {
    const double at = (hours + 3) / step_h;
    const auto below = std::min<std::size_t>(static_cast<std::size_t>(at), shown_at.size() - 2);
    const double share = at - static_cast<double>(below);
    return (1 - share) * shown_at[below] + share * shown_at[below + 1];
  }
  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& /*recording*/) const override {
    Eigen::MatrixXd shown = Eigen::MatrixXd::Constant(engine_bins, 5, 25);
    for (const sim::EffectChange& c : changes) {
      if (c.at.effect == &late) shown += lateness(c.magnitude);
    }
    return rows_of(shown);
  }
  bool spares_runs() const override { return spares; }
  bool spares = false;
};

TEST(Refit, LooksForALargeEffectWhereASmallOneShowsNothingOfIt) {
  LateEngine engine;
  Window window;
  window.measured = Eigen::MatrixXd::Constant(engine_bins, 5, 25) + engine.lateness(2.25) + noise_table(4, 0.05);
  Responses responses;
  responses.base = Eigen::MatrixXd::Constant(engine_bins, 5, 25);
  responses.parameters = {{{&engine.wall, 0}, 1, Eigen::MatrixXd::Zero(engine_bins, 5)}};
  responses.candidates = {{{&engine.late, 0}, 0.75, engine.lateness(0.75)},
                          {{&engine.late, 0}, -0.75, engine.lateness(-0.75)}};
  ReferenceFit fit;
  fit.estimate = Eigen::VectorXd::Zero(1);
  fit.covariance = Eigen::MatrixXd::Identity(1, 1);
  fit.noise = NoiseModel::fit(noise_table(5, 0.05), engine.channels());
  fit.parameters = responses.parameters;
  const std::vector<bool> kept(static_cast<std::size_t>(engine_bins), true);
  const Refitter refitter(engine, window, responses, fit, {}, kept, 2, Refitter::Start::twin);
  const Refit none = refitter.at({}, Eigen::VectorXd::Zero(1), refitter.tangent());

  const Refit near = refitter.add(none, {0, 0, 1, 1}, refitter.tangent());
  EXPECT_LT(none.cost - near.cost, 0.1 * none.cost) << "from its probe it is not found";
  const std::vector<Refit> far = refitter.far(none, 4, [](std::size_t) { return true; });
  ASSERT_FALSE(far.empty());
  EXPECT_LT(far[0].cost, 0.2 * none.cost);
  EXPECT_EQ(refitter.magnitude(far[0].chosen.back()), 2.25);
  EXPECT_TRUE(refitter.far(none, 4, [](std::size_t) { return false; }).empty()) << "chosen already";
  engine.spares = true;
  EXPECT_TRUE(refitter.far(none, 4, [](std::size_t) { return true; }).empty()) << "runs are dear";
}

}  // namespace
}  // namespace airside::tools::gap
