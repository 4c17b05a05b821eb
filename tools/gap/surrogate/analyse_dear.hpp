#pragma once
// The verdict on a case whose model's runs are dear: an RC room ranks, the model itself is run for what is likely.

#include "tools/gap/surrogate/surrogate_engine.hpp"
#include "tools/gap/verdict/workflow.hpp"

namespace airside::tools::gap {

/// Rounds of analyse() with the surrogate. Before each the model is run at the estimate of the reference period, again
/// until what it shows there is what was expected to 0.03 K, and there in the measured window. After each but the last
/// it is run with each of the likeliest effects, as large as they are, in the measured window, and after the first with
/// up to three of those that bend at half and all of their bound. The next round has the model's own answer there.
/// `engine`: the surrogate, or what counts its replays; `responses`: its own in both windows, at the end with what was
/// learned; `look` and `judged`: of the last round.
/// Cost: 30 to 50 runs of the model, and three times analyse() of an RC room.
/// Errors: as Engine::simulate.  Source: docs/gap-workflow.md, "A model whose runs are dear".
Verdict analyse_dear(SurrogateEngine& surrogate, const Engine& engine, const CaseData& data, WindowResponses& responses,
                     const Rules& rules, int jobs, const std::function<void(const Outlook&)>& look = {},
                     const std::function<void(const Analysed&)>& judged = {});

/// The rounds of analyse_dear(), how many effects one learns at most in a finding's place, how often an estimate is
/// usually run before a round, and how many sizes of effects that bend the first round usually asks for.
constexpr int dear_rounds = 3, dear_effects = 8, dear_fits = 5, dear_sizes = 2;

}  // namespace airside::tools::gap
