#include "tools/gap/bills/bill_verdict.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "tools/gap/inference/posterior.hpp"
#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools::gap {

namespace {

constexpr double least_information = 0.01;  // of a probe, in units of the prior's

/// One bill that is known.
struct Entry {
  const BillEvidence* of = nullptr;
  Eigen::Index period = 0, meter = 0;
  double sd = 1;
  double at(const Eigen::MatrixXd& kwh) const { return kwh(period, meter); }
};

/// All bills in one row, scaled by their noise, and what their errors have in common.
class BillModel {
 public:
  BillModel(const BillEvidence& measured, const BillEvidence* reference, const BillPriors& priors) : priors_(priors) {
    add(measured);
    count_measured_ = std::ssize(entries_);
    if (reference != nullptr) add(*reference);
    const auto n = std::ssize(entries_);
    residual_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Entry& e = entries_[static_cast<std::size_t>(i)];
      residual_(i) = (e.at(e.of->bills.kwh) - e.at(e.of->responses.base)) / e.sd;
    }
    covariance_ = Eigen::MatrixXd::Identity(n, n);
    for (std::size_t p = 0; p < measured.responses.parameters.size(); ++p)
      add_common([p](const Entry& e) { return e.at(e.of->responses.parameters[p].kwh); });
    for (Eigen::Index m = 0; m < measured.bills.kwh.cols(); ++m) {
      add_common([m, &priors](const Entry& e) { return e.meter == m ? priors.level * e.at(e.of->responses.base) : 0; });
    }
    inner_.compute(covariance_);
  }

  /// ln odds of an effect of this direction against nothing, before priors; its magnitude in steps.
  struct Answer {
    double log_odds = 0, steps = 0, sd = 1, information = 0;
  };
  Answer answer(const BillResponses::Direction& direction) const {
    Eigen::VectorXd z = Eigen::VectorXd::Zero(residual_.size());
    for (Eigen::Index i = 0; i < count_measured_; ++i) {
      const Entry& e = entries_[static_cast<std::size_t>(i)];
      z(i) = e.at(direction.kwh) / e.sd;
    }
    const Eigen::VectorXd weighted = inner_.solve(z);
    Answer a;
    a.information = weighted.dot(z);
    const double variance = 1 / (a.information + 1), mean = variance * weighted.dot(residual_);
    a.sd = std::sqrt(variance);
    const double one_sided = std::max(1e-300, std::erfc(-mean / a.sd / std::sqrt(2.0)));
    a.log_odds = std::log(one_sided) + std::log(a.sd) + mean * mean / variance / 2;
    a.steps = std::max(0.0, mean);
    return a;
  }

  /// ln odds of every measured bill being off by a share of its own, against nothing.
  double log_odds_of_other() const {
    Eigen::MatrixXd wider = covariance_;
    for (Eigen::Index i = 0; i < count_measured_; ++i) {
      const Entry& e = entries_[static_cast<std::size_t>(i)];
      wider(i, i) += std::pow(priors_.strange * e.at(e.of->responses.base) / e.sd, 2);
    }
    return log_density(Eigen::LDLT<Eigen::MatrixXd>(wider)) - log_density(inner_);
  }

 private:
  void add(const BillEvidence& evidence) {
    constexpr double least_share = 0.01;  // of the meter's mean: a month without heating has no noise of its own
    const Eigen::MatrixXd& base = evidence.responses.base;
    for (Eigen::Index m = 0; m < base.cols(); ++m) {
      const double least = std::max(1e-3, least_share * base.col(m).cwiseAbs().mean());
      for (Eigen::Index p = 0; p < base.rows(); ++p) {
        if (!std::isfinite(evidence.bills.kwh(p, m))) continue;
        entries_.push_back({&evidence, p, m, std::hypot(priors_.period * base(p, m), least)});
      }
    }
  }

  template <typename Kwh>
  void add_common(const Kwh& kwh) {
    Eigen::VectorXd column(std::ssize(entries_));
    for (Eigen::Index i = 0; i < column.size(); ++i) {
      const Entry& e = entries_[static_cast<std::size_t>(i)];
      column(i) = kwh(e) / e.sd;
    }
    covariance_ += column * column.transpose();
  }

  double log_density(const Eigen::LDLT<Eigen::MatrixXd>& of) const {
    return -(residual_.dot(of.solve(residual_)) + of.vectorD().array().log().sum()) / 2;
  }

  BillPriors priors_;
  std::vector<Entry> entries_;
  Eigen::Index count_measured_ = 0;
  Eigen::VectorXd residual_;
  Eigen::MatrixXd covariance_;
  Eigen::LDLT<Eigen::MatrixXd> inner_;
};

/// ln prior of each place: effects share evenly, and an effect's places share evenly.
std::map<std::string, double> log_priors(const BillResponses& responses, const BillPriors& priors) {
  std::map<std::string, std::set<std::string>> places;
  for (const BillResponses::Direction& d : responses.candidates) places[d.at.effect->name].insert(d.at.id());
  std::map<std::string, double> all;
  const double share =
      (1 - priors.nothing - priors.other) / static_cast<double>(std::max<std::size_t>(1, places.size()));
  for (const auto& [effect, ids] : places) {
    for (const std::string& id : ids) all[id] = std::log(share / static_cast<double>(ids.size()));
  }
  return all;
}

/// Steps whose expected odds against nothing make a name; infinite where the bills do not show the effect.
double steps_to_name(double information, double log_prior, const BillPriors& priors) {
  if (!(information > 0)) return std::numeric_limits<double>::infinity();
  const double wanted = std::log(priors.name / (1 - priors.name)) + std::log(priors.nothing) - log_prior;
  const double exponent = wanted + std::log(information + 1) / 2 - std::log(2.0);
  return std::sqrt(2 * std::max(0.0, exponent) * (information + 1)) / information;
}

double energy_per_day(const BillTable& bills, const Eigen::MatrixXd& kwh) {
  double days = 0;
  for (const BillPeriod& p : bills.periods) days += p.days();
  return kwh.sum() / std::max(1.0, days);
}

std::vector<BillMeterFit> meter_fits(const BillTable& bills, const Eigen::MatrixXd& base) {
  std::vector<BillMeterFit> fits;
  for (Eigen::Index m = 0; m < base.cols(); ++m) {
    BillMeterFit fit{bills.meters[static_cast<std::size_t>(m)]};
    double errors = 0, squares = 0;
    int n = 0;
    for (Eigen::Index p = 0; p < base.rows(); ++p) {
      if (!std::isfinite(bills.kwh(p, m))) continue;
      const double error = bills.kwh(p, m) - base(p, m);
      fit.measured_kwh += bills.kwh(p, m);
      fit.simulated_kwh += base(p, m);
      errors += error;
      squares += error * error;
      ++n;
    }
    if (n > 1 && fit.measured_kwh > 0) {
      const double mean = fit.measured_kwh / n;
      fit.nmbe_percent = 100 * errors / (n - 1) / mean;
      fit.cv_rmse_percent = 100 * std::sqrt(squares / (n - 1)) / mean;
    }
    fits.push_back(std::move(fit));
  }
  return fits;
}

}  // namespace

BillVerdict judge_bills(const BillEvidence& measured, const BillEvidence* reference, const BillPriors& priors) {
  const BillModel model(measured, reference, priors);
  const auto prior = log_priors(measured.responses, priors);
  BillVerdict v;
  v.simulated_kwh = measured.responses.base;
  v.meters = meter_fits(measured.bills, measured.responses.base);
  std::vector<double> scores;
  const auto& directions = measured.responses.candidates;
  for (std::size_t k = 0; k + 1 < directions.size(); k += 2) {
    const std::array<BillModel::Answer, 2> answers{model.answer(directions[k]), model.answer(directions[k + 1])};
    if (std::max(answers[0].information, answers[1].information) < least_information) {
      v.invisible.push_back(directions[k].at);
      continue;
    }
    const std::size_t better = answers[1].log_odds > answers[0].log_odds ? 1 : 0;
    const BillModel::Answer& a = answers[better];
    const BillResponses::Direction& d = directions[k + better];
    const sim::Effect& effect = *d.at.effect;
    BillCandidate c;
    c.at = d.at;
    c.magnitude = std::clamp(effect.null_value + a.steps * d.step, effect.low, effect.high);
    c.sd = a.sd * std::abs(d.step);
    c.kwh_per_day = a.steps * energy_per_day(measured.bills, d.kwh);
    c.visible_from = std::numeric_limits<double>::quiet_NaN();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t side = 0; side < 2; ++side) {
      const double steps = steps_to_name(answers[side].information, prior.at(d.at.id()), priors);
      const double size = effect.null_value + steps * directions[k + side].step;
      if (steps < least && size >= effect.low && size <= effect.high) c.visible_from = size;
      least = std::min(least, steps);
    }
    const double odds =
        std::log((std::exp(answers[0].log_odds - a.log_odds) + std::exp(answers[1].log_odds - a.log_odds)) / 2);
    scores.push_back(prior.at(d.at.id()) + a.log_odds + odds);
    v.candidates.push_back(c);
  }
  const double nothing = std::log(priors.nothing), other = std::log(priors.other) + model.log_odds_of_other();
  double most = std::max(nothing, other);
  for (const double s : scores) most = std::max(most, s);
  double sum = std::exp(nothing - most) + std::exp(other - most);
  for (const double s : scores) sum += std::exp(s - most);
  v.nothing = std::exp(nothing - most) / sum;
  v.other = std::exp(other - most) / sum;
  for (std::size_t k = 0; k < scores.size(); ++k) v.candidates[k].probability = std::exp(scores[k] - most) / sum;
  std::stable_sort(v.candidates.begin(), v.candidates.end(),
                   [](const BillCandidate& a, const BillCandidate& b) { return a.probability > b.probability; });
  std::vector<std::pair<std::string, double>> all{{"nothing", v.nothing}, {"other", v.other}};
  for (const BillCandidate& c : v.candidates) all.emplace_back(c.at.id(), c.probability);
  v.set = smallest_set(std::move(all), priors.set);
  v.named = !v.candidates.empty() && v.candidates.front().probability > priors.name;
  return v;
}

std::string sentence_of(const BillVerdict& v) {
  const auto size = [](const BillCandidate& c) {
    return fmt::format("{}: {:.3g} ± {:.2g}{}, {:+.3g} kWh a day", c.at.text(), c.magnitude, 1.96 * c.sd,
                       unit_suffix(*c.at.effect), c.kwh_per_day);
  };
  if (v.named) return "named: " + size(v.candidates.front());
  const double likeliest = v.candidates.empty() ? 0 : v.candidates.front().probability;
  if (v.nothing >= std::max(v.other, likeliest))
    return fmt::format("nothing that these bills could show ({:.0f} %)", 100 * v.nothing);
  if (v.other > likeliest) return fmt::format("unknown: no effect explains the bills ({:.0f} %)", 100 * v.other);
  return fmt::format("ambiguous: perhaps {} ({:.0f} %)", size(v.candidates.front()), 100 * likeliest);
}

}  // namespace airside::tools::gap
