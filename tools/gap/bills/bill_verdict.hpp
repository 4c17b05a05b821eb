#pragma once
// What bills alone tell of a model: which effect is missing, how probable each is, and beforehand which could be seen
// at all. Whatever is not known is a stated prior; nothing is learned from cases.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/gap/bills/bill_table.hpp"
#include "tools/gap/model/responses.hpp"

namespace airside::tools::gap {

/// Standard deviations, shares of what the model uses in the period.
struct BillPriors {
  double period = 0.05;  ///< of one bill: people, weather that is not the file's, reading dates
  double level = 0.15;   ///< of a meter in all bills, which no parameter has
  double strange = 0.3;  ///< of one bill, were something else missing
  double nothing = 0.5;  ///< probability that nothing is missing
  double other = 0.1;    ///< and that something else is
  double name = 0.95;    ///< a name is more probable than this
  double set = 0.9;      ///< that the smallest set holds
};

struct BillCandidate {
  sim::EffectAt at;
  double probability = 0;
  double magnitude = 0, sd = 0;  ///< were it the truth; the prior is as wide as the effect's probes
  double kwh_per_day = 0;        ///< over all meters, of this magnitude
  double visible_from = 0;       ///< magnitude that would be named on average; NaN: none within its bounds
};

struct BillMeterFit {
  std::string meter;
  double measured_kwh = 0, simulated_kwh = 0;
  double nmbe_percent = 0, cv_rmse_percent = 0;  ///< of the model as it is, ASHRAE Guideline 14
};

struct BillVerdict {
  std::vector<BillCandidate> candidates;  ///< best first
  std::vector<sim::EffectAt> invisible;   ///< that no bill shows: they are not asked about
  double nothing = 0, other = 0;
  std::vector<std::string> set;  ///< ids, "nothing", "other": the fewest that hold BillPriors::set
  bool named = false;            ///< the first candidate
  std::vector<BillMeterFit> meters;
  Eigen::MatrixXd simulated_kwh;  ///< of the measured bills, the model as it is; periods x meters
};

/// Energy of each meter in each period by simulations of the model as it is, its parameters and the candidates' probes.
struct BillResponses {
  struct Direction {
    sim::EffectAt at;
    double step = 0;      ///< of the magnitude
    Eigen::MatrixXd kwh;  ///< by which the step changes the bills
  };
  Eigen::MatrixXd base;
  std::vector<Direction> parameters;  ///< a step of one prior standard deviation
  std::vector<Direction> candidates;  ///< two a place
};

/// How many simulations bill_responses() asks for.
std::size_t bill_runs(const Library& library, const BillTable& bills);

/// Shape: as the tables' kwh. `meters`: power channels, in the tables' order.
/// The first sim::lead_days of a year are not simulated but taken as the mean of their period's others.
/// Errors: as Engine::simulate().  Cost: bill_runs() simulations of the bills' days on `jobs` threads.
BillResponses bill_responses(const Engine& engine, const Library& library, const BillTable& bills,
                             const std::vector<int>& meters, std::shared_ptr<const sim::Weather> station, int jobs,
                             const std::function<void()>& done = {});

/// Bills and what the model says of them; kept by reference.
struct BillEvidence {
  const BillTable& bills;
  const BillResponses& responses;
};

/// With y bills less the model's, J its parameters' responses and each meter's level, E the periods' noise, z_k the
/// response to one unit of effect k in the measured bills alone:
///   y ~ N(z_k m, E + J J'),  m ~ N(0, step_k^2) of one sign,  P(k) ~ prior_k p(y | k)
/// `reference`: bills of a time in which nothing was missing, with their responses; nullptr: none. Both share
/// parameters and levels.
/// Source: docs/gap-workflow.md, "Bills alone".
BillVerdict judge_bills(const BillEvidence& measured, const BillEvidence* reference, const BillPriors& priors = {});

/// One sentence.
std::string sentence_of(const BillVerdict& verdict);

}  // namespace airside::tools::gap
