#include <fmt/format.h>

#include "tools/gap/explain/experiment.hpp"
#include "tools/gap/explain/stacked_evidence.hpp"

namespace airside::tools::gap {

namespace {

std::vector<double> ratios_of(const Eigen::MatrixXd& products) {
  const Eigen::Index r = products.rows() - 1;
  std::vector<double> ratios;
  for (Eigen::Index a = 0; a < r; ++a) {
    const double ar = products(a, r), aa = products(a, a);
    ratios.push_back(ar > 0 && aa > 1e-9 ? ar * ar / aa : 0);
  }
  return ratios;
}

}  // namespace

ExperimentOutcome judge_experiment(const Engine& engine, const Window& window, const Window& done,
                                   std::size_t first_row, const ReferenceFit& fit, const Responses& responses,
                                   const Responses& at_done, std::span<const sim::EffectChange> members,
                                   const Changes& fitted_parameters, const Nuisance& nuisance) {
  const Eigen::Index shared = std::ssize(responses.parameters) + fit.structural_scale.size();
  const auto count = static_cast<Eigen::Index>(members.size()) + 1;
  const auto stacked = [&](const Window& w, const Responses& r, const std::vector<bool>& kept) {
    const Eigen::MatrixXd base = binned(engine.simulate(fitted_parameters, w.recording), engine.channels());
    const auto whiten = [&](const Eigen::MatrixXd& x) { return fit.noise.whiten(x, kept, w.measured); };
    std::vector<Eigen::VectorXd> columns;
    for (const sim::EffectChange& m : members) {
      columns.push_back(
          whiten(binned(engine.simulate(with_member(fitted_parameters, m), w.recording), engine.channels()) - base));
    }
    columns.push_back(whiten(w.measured - base - fit.structural(r)));
    const Eigen::MatrixXd j = nuisance_directions(fit, r, kept, w.measured, nuisance);
    Eigen::MatrixXd all(j.rows(), count + j.cols());
    all << columns_of(columns, j.rows()), j;
    return all;
  };
  const StackedEvidence evidence(stacked(window, responses, counted_bins(window.measured.rows())), count, shared);
  const auto kept = bins_from(done.measured.rows(), first_row);
  Eigen::MatrixXd test = stacked(done, at_done, kept);
  const auto directions = directions_of(at_done, fit.structural_scale);
  const Eigen::Index before = test.cols();
  test.conservativeResize(Eigen::NoChange, before + std::ssize(directions));
  for (std::size_t i = 0; i < directions.size(); ++i) {
    test.col(before + static_cast<Eigen::Index>(i)) =
        nuisance.structural_sd * fit.noise.whiten(directions[i], kept, done.measured);
  }
  return {ratios_of(evidence.window_products()), ratios_of(evidence.products_with(test.transpose() * test))};
}

std::string sentence_of(std::span<const ExperimentProposal> proposals) {
  if (proposals.empty()) return "no test was tried: the log is too short";
  const ExperimentProposal& best = proposals.front();
  const std::string temps =
      fmt::format("zones are expected between {:.1f} and {:.1f} degC", best.lowest_room_degc, best.highest_room_degc);
  if (!best.separates) {
    return fmt::format(
        "no test that was tried tells them apart: the best, \"{}\" for {:.0f} h, would with a probability of {:.0f} %; "
        "{}",
        best.text, best.hours, 100 * best.power, temps);
  }
  return fmt::format(
      "to tell them apart: {}; after {:.0f} h the log will say which it is (with {:.0f} % probability "
      "after the whole test, at 5 % error); {}{}",
      best.text, best.hours, 100 * best.power, temps,
      best.comfortable ? "" : ", beyond what people accept: do it when nobody is there");
}

nlohmann::json json_of(const ExperimentProposal& p) {
  return {{"name", p.name},
          {"text", p.text},
          {"hours", p.hours},
          {"power", p.power},
          {"separation", p.separation},
          {"separates", p.separates},
          {"lowest_room_degc", p.lowest_room_degc},
          {"highest_room_degc", p.highest_room_degc},
          {"comfortable", p.comfortable},
          {"upper_bound", p.upper_bound},
          {"hardest", p.hardest}};
}

}  // namespace airside::tools::gap
