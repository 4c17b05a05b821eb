#pragma once
// Which tests on site a verdict leaves to be done.

#include "tools/gap/explain/experiment.hpp"
#include "tools/gap/verdict/verdict.hpp"

namespace airside::tools::gap {

/// The first finding and what the log cannot tell it from, each at the magnitude that it would have; where that is the
/// finding alone, with the first other one of the ranking. Empty without a finding.
Changes rivals_of(const Verdict& verdict, const Responses& responses);

/// Tests that tell the rivals apart, best first.
/// Errors, cost: as propose_experiments().
std::vector<ExperimentProposal> proposed_tests(const Engine& engine, const Window& window, const Verdict& verdict,
                                               const Responses& responses, int jobs);

/// Whether a verdict leaves anything for a test to decide: ambiguous, or unknown with something found.
bool proposes_tests(const Verdict& verdict);

/// Format: docs/formats.md, `experiments`.
nlohmann::json proposals_json(std::span<const ExperimentProposal> proposals);

}  // namespace airside::tools::gap
