// Whitening, the metric and the scores, on data whose answer is known.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tools/gap/inference/selection.hpp"

namespace airside::tools::gap {
namespace {

constexpr double missing_value = std::numeric_limits<double>::quiet_NaN();
constexpr sim::Channels two_rooms{2, 0, 1};  // two rooms, MAU, supply, one power: five columns

std::vector<bool> all(Eigen::Index bins) { return std::vector<bool>(static_cast<std::size_t>(bins), true); }

/// AR(2) in every column, innovations correlated between the first two and twice as large at night.
struct ArSeries {
  static constexpr double phi1 = 0.9, phi2 = -0.2, sd = 0.1, correlation = 0.6;
  Eigen::MatrixXd x;

  ArSeries(Eigen::Index days, unsigned seed) : x(days * bins_per_day, two_rooms.count()) {
    std::mt19937_64 bits(seed);
    std::normal_distribution<double> normal;
    x.setZero();
    for (Eigen::Index t = 2; t < x.rows(); ++t) {
      const double scale = sd * (t % bins_per_day < bins_per_day / 2 ? 2 : 1);
      const double common = normal(bits);
      for (Eigen::Index c = 0; c < x.cols(); ++c) {
        double e = normal(bits);
        if (c < 2) e = std::sqrt(correlation) * common + std::sqrt(1 - correlation) * e;
        x(t, c) = phi1 * x(t - 1, c) + phi2 * x(t - 2, c) + scale * e;
      }
    }
  }
};

/// Rows: time steps, columns: channels.
Eigen::MatrixXd as_table(const Eigen::VectorXd& stacked, Eigen::Index channels) {
  return Eigen::Map<const Eigen::MatrixXd>(stacked.data(), channels, stacked.size() / channels).transpose();
}

TEST(Binned, IsAMeanOfFiveRowsAndMissingWithLessThanThree) {
  sim::ChannelTable table(10, 1);
  table << 1, 2, 3, 4, 5, 1, missing_value, missing_value, missing_value, 2;
  const Eigen::MatrixXd bins = binned(table, {});
  ASSERT_EQ(bins.rows(), 2);
  EXPECT_DOUBLE_EQ(bins(0, 0), 3);
  EXPECT_TRUE(std::isnan(bins(1, 0)));
  table(6, 0) = 3;
  EXPECT_DOUBLE_EQ(binned(table, {})(1, 0), 2);
}

TEST(Binned, HoldsInstantsOfAnHourUntilTheNextAndComparesNothingBetweenThem) {
  sim::Channels channels{1, 0, 1};
  channels.grain.resize(static_cast<std::size_t>(channels.count()));
  channels.grain[0] = {60, true, 0, ""};
  channels.grain[static_cast<std::size_t>(channels.power())] = {60, false, 0, ""};
  sim::ChannelTable table = sim::ChannelTable::Zero(20, channels.count());
  for (Eigen::Index c = 0; c < table.cols(); ++c) table.col(c) = Eigen::VectorXd::LinSpaced(20, 0, 19);
  const Eigen::MatrixXd bins = binned(table, channels);
  EXPECT_EQ(bins.col(0), Eigen::Vector4d(0, 0, 10, 10));
  EXPECT_EQ(bins.col(channels.power()), Eigen::Vector4d(3, 8, 13, 17.5)) << "the row at 0:30 ends the first half hour";
  table(10, 0) = missing_value;
  EXPECT_TRUE(std::isnan(binned(table, channels)(2, 0))) << "what lies between two instants stands for neither";
}

TEST(NoiseModel, MakesInnovationsWhiteOfUnitVarianceAndIndependentAcrossChannels) {
  const ArSeries train(60, 1), other(60, 2);
  const NoiseModel noise = NoiseModel::fit(train.x, two_rooms);
  const Eigen::MatrixXd e = as_table(noise.whiten(other.x, all(other.x.rows()), other.x), other.x.cols());
  const auto n = static_cast<double>(e.rows());
  for (Eigen::Index c = 0; c < e.cols(); ++c) {
    EXPECT_NEAR(e.col(c).squaredNorm() / n, 1, 0.25) << c << ": correlations are shrunk on purpose";
    EXPECT_NEAR(e.col(c).tail(e.rows() - 1).dot(e.col(c).head(e.rows() - 1)) / n, 0, 0.08) << c;
    for (Eigen::Index k = 0; k < c; ++k) EXPECT_NEAR(e.col(c).dot(e.col(k)) / n, 0, 0.2) << c << ' ' << k;
  }
  // The two halves of the day differ by a factor of two in what is put in, and by little in what comes out.
  double night = 0, day = 0;
  for (Eigen::Index t = 0; t < e.rows(); ++t)
    ((t + 2) % bins_per_day < bins_per_day / 2 ? night : day) += e(t, 0) * e(t, 0);
  EXPECT_NEAR(std::sqrt(night / day), 1, 0.15);
}

TEST(NoiseModel, WhatIsMissingOrLeftOutCountsNothingAndSpoilsNothing) {
  const ArSeries series(20, 3);
  const NoiseModel noise = NoiseModel::fit(series.x, two_rooms);
  const Eigen::VectorXd whole = noise.whiten(series.x, all(series.x.rows()), series.x);
  Eigen::MatrixXd holed = series.x;
  holed(100, 2) = missing_value;
  const Eigen::MatrixXd difference = as_table(noise.whiten(holed, all(holed.rows()), holed) - whole, holed.cols());
  for (Eigen::Index t = 0; t < difference.rows(); ++t) {
    const bool touched = t + 2 >= 100 && t + 2 <= 102;  // the value itself and the two that look back at it
    EXPECT_EQ(difference.row(t).cwiseAbs().maxCoeff() > 0, touched) << t;
  }
  EXPECT_TRUE(difference.allFinite());
  auto kept = all(series.x.rows());
  std::fill(kept.begin(), kept.begin() + bins_per_day, false);
  const Eigen::MatrixXd late = as_table(noise.whiten(series.x, kept, series.x), series.x.cols());
  EXPECT_EQ(late.topRows(bins_per_day - 2).cwiseAbs().maxCoeff(), 0);
  EXPECT_GT(late.row(bins_per_day + 5).cwiseAbs().maxCoeff(), 0);
}

TEST(NoiseModel, AChannelThatNeverVariesKeepsTheSensorsResolution) {
  Eigen::MatrixXd x = ArSeries(20, 4).x;
  x.col(0).setZero();
  const NoiseModel noise = NoiseModel::fit(x, two_rooms);
  EXPECT_GT(noise.spread()(0), 0.001);
  EXPECT_LT(noise.spread()(0), 0.05);
  EXPECT_TRUE(noise.whiten(x, all(x.rows()), x).allFinite());
}

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(bits); });
}

TEST(Metric, IsTheInverseCovarianceOfNoiseAndParameters) {
  const Eigen::MatrixXd j = random_matrix(40, 6, 5);
  const Eigen::MatrixXd inverse = (Eigen::MatrixXd::Identity(40, 40) + j * j.transpose()).inverse();
  const Metric metric(j);
  const Eigen::VectorXd a = random_matrix(40, 1, 6), b = random_matrix(40, 1, 7);
  EXPECT_NEAR(metric.dot(a, b), a.dot(inverse * b), 1e-10);
  EXPECT_LT((metric.times(a) - inverse * a).cwiseAbs().maxCoeff(), 1e-10);
  // Marginalised, not projected away: what looks like a parameter still counts a little.
  const Eigen::VectorXd along = j.col(2);
  EXPECT_GT(metric.dot(along, along), 0);
  EXPECT_LT(metric.dot(along, along), 1.0 + 1e-12);
  EXPECT_NEAR(metric.squares(b)(0), metric.dot(b, b), 1e-12);
}

struct Scored {
  sim::Effect heat, cool;
  std::vector<Candidate> candidates;
  Eigen::MatrixXd z{200, 4};

  Scored() {
    heat.name = "heat", cool.name = "cool";
    for (const sim::Effect* e : {&heat, &cool}) {
      for (const double sign : {1.0, -1.0}) {
        z.col(std::ssize(candidates)) = sign * random_matrix(200, 1, e == &heat ? 8 : 9);
        candidates.push_back({{e, 0}, sign, {}});
      }
    }
  }

  std::vector<Score> scores(const Eigen::VectorXd& residual, const std::vector<std::size_t>& chosen = {},
                            const Eigen::MatrixXd& j = Eigen::MatrixXd::Zero(200, 1)) const {
    const CandidateEvidence evidence(candidates, std::make_shared<const Eigen::MatrixXd>(z), Metric(j));
    return Selection(evidence, chosen).scores(residual);
  }
};

TEST(Scores, FindTheEffectItsSizeAndItsGain) {
  const Scored s;
  const Eigen::VectorXd residual = 0.7 * s.z.col(3) + 0.01 * random_matrix(200, 1, 10);
  const auto scores = s.scores(residual);
  ASSERT_EQ(scores.size(), 2U) << "one a place, the better of its two directions";
  EXPECT_EQ(scores[0].candidate, 3U);
  EXPECT_NEAR(scores[0].steps, 0.7, 0.01);
  EXPECT_NEAR(scores[0].steps_sd, 1 / s.z.col(3).norm(), 1e-9);
  EXPECT_NEAR(scores[0].log_likelihood_ratio, 0.49 * s.z.col(3).squaredNorm(), 3);
  EXPECT_LT(scores[1].log_likelihood_ratio, 0.1 * scores[0].log_likelihood_ratio);
}

TEST(Scores, NothingIsGainedTheWrongWay) {
  Scored s;
  s.candidates.resize(1);  // an effect with one physical sign
  s.z.conservativeResize(Eigen::NoChange, 1);
  const auto scores = s.scores(-s.z.col(0));
  ASSERT_EQ(scores.size(), 1U);
  EXPECT_EQ(scores[0].log_likelihood_ratio, 0);
}

TEST(Scores, AParameterThatCouldHaveDoneItTakesTheGainAway) {
  const Scored s;
  const Eigen::VectorXd residual = s.z.col(0);
  const double open = s.scores(residual)[0].log_likelihood_ratio,
               shared = s.scores(residual, {}, s.z.col(0))[0].log_likelihood_ratio;
  EXPECT_GT(open, 100);
  EXPECT_LT(shared, 1.1);
}

TEST(Selection, IsTheMetricInWhichChosenMagnitudesAreFree) {
  const Scored s;
  const Eigen::MatrixXd j = random_matrix(200, 5, 11);
  const CandidateEvidence evidence(s.candidates, std::make_shared<const Eigen::MatrixXd>(s.z), Metric(j));
  const Selection selection(evidence, {0});
  Eigen::MatrixXd free(200, 6);
  free << j, 1e5 * s.z.col(0);
  const Metric expected(free);
  const Eigen::VectorXd v = random_matrix(200, 1, 12);
  EXPECT_LT((selection.times(v) - expected.times(v)).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_NEAR(selection.dot(2, 2), expected.dot(s.z.col(2), s.z.col(2)), 1e-5);
  EXPECT_NEAR(selection.cosine(2, 3), -1, 1e-9);
  const Eigen::VectorXd chosen = 3 * s.z.col(0) + 0.5 * s.z.col(2);
  const auto scores = selection.scores(chosen);
  EXPECT_EQ(scores[0].candidate, 2U) << "what is chosen already explains the larger part";
  EXPECT_NEAR(scores[0].steps, 0.5, 1e-6);
}

}  // namespace
}  // namespace airside::tools::gap
