#pragma once
// Which test on site would tell apart what the log cannot: candidate tests are lived through by the model, and the one
// in which the members of a class differ most, after everything uncertain has been marginalised, is proposed.

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "tools/gap/explain/test_plan.hpp"

namespace airside::tools::gap {

/// A test and what to expect of it, for the two members that it tells apart worst.
struct ExperimentProposal {
  std::string name, text;
  double hours = 0;       ///< from its first command until the expected 2 ln likelihood ratio passes the margin;
                          ///< all of its hours if it never does
  double power = 0;       ///< probability to tell the members apart at 95 %
  double separation = 0;  ///< expected 2 ln likelihood ratio that the whole test adds
  double lowest_room_degc = 0, highest_room_degc = 0;  ///< of all zones, whichever member is true
  bool separates = false;                              ///< separation passes the margin
  bool comfortable = true;                             ///< temperatures stay within the rules' limits
  bool upper_bound = false;                            ///< parameters were not simulated: truly it separates less
  std::string hardest;                                 ///< "infiltration or envelope_u"
};

/// Tests, best first; comfortable ones before others; empty where the window is too short or there are less than two
/// members.
///   The window's and the test's whitened responses of each member are stacked, z = (z_window, z_test); directions of
///   parameters and structure are shared by both, each day's people and what a parameter may be off in another window
///   (structural_sd) are not. In the metric M that marginalises them
///     d_ab^2 = z_a' M z_a - (z_a' M z_b)^2 / z_b' M z_b,
///   the expected 2 ln likelihood ratio if a is true and b is refitted; the test adds d_ab^2 - d_ab^2(window).
///   With u and v the projections on the unit vectors of z_a and z_b, 2 ln ratio = u^2 - v^2 has mean d^2 and, to first
///   order in 1 / |z_a|, variance 4 d^2; if b is true, mean -d^2. A decision that is wrong in 5 % of the cases in which
///   b is true therefore finds a with the probability
///     power = Phi(d - 1.645).
/// Shape: `responses` of the window, as the fit's; `members` at their fitted magnitudes.
/// Errors: as Engine::simulate.
/// Cost: (members + 1) simulations of the window, (members + 1) of days + history_days for each plan, and
/// most_parameters more for each finalist.
std::vector<ExperimentProposal> propose_experiments(const Engine& engine, const Window& window, const ReferenceFit& fit,
                                                    const Responses& responses,
                                                    std::span<const sim::EffectChange> members,
                                                    const Changes& fitted_parameters, int jobs,
                                                    const ExperimentRules& rules = {});

/// Phi(d - 1.645) of separation d^2.
double power_of(double separation);

/// For people: the best test, how sure, how long, how far temperatures go; or that none tells them apart.
std::string sentence_of(std::span<const ExperimentProposal> proposals);
nlohmann::json json_of(const ExperimentProposal& proposal);

/// 2 ln likelihood that each member gains, from the window alone and with the test that was done.
struct ExperimentOutcome {
  std::vector<double> window, both;
};
/// `done`: the log from history_days before the test to its end; `first_row` the test's first command; `at_done`
/// responses there. Fan coils' duties during a test that commands them say nothing of their thermostats: pass NaN.
ExperimentOutcome judge_experiment(const Engine& engine, const Window& window, const Window& done,
                                   std::size_t first_row, const ReferenceFit& fit, const Responses& responses,
                                   const Responses& at_done, std::span<const sim::EffectChange> members,
                                   const Changes& fitted_parameters, const Nuisance& nuisance = {});

}  // namespace airside::tools::gap
