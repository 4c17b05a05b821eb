#pragma once
// Verdicts as files: what `airside gap --json` prints and `airside gap score` reads.  Format: FORMATS.md.

#include <nlohmann/json.hpp>

#include "tools/gap/workflow.hpp"

namespace airside::tools::gap {

/// Units are in the names; ids as EffectAt::id().
nlohmann::json json_of(const Verdict& verdict, const std::string& name, const Responses& responses,
                       const sim::Channels& channels);

/// One sentence a finding, for people: "flow of box 3 is not what its controller believes: 0.71 +- 0.02 (gain 812
/// ...)".
std::string sentence_of(const Finding& finding);

}  // namespace airside::tools::gap
