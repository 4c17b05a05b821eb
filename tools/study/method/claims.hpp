#pragma once
// What the published method is said to show, one by one, and whether the runs of a folder show it.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/study/method/peer_rows.hpp"
#include "tools/study/method/results.hpp"

namespace airside::tools {

enum class ClaimState { reproduced, partly, not_reproduced, not_run, elsewhere };
const char* text_of(ClaimState state);

struct ClaimVerdict {
  int number = 0;
  std::string claim, published;
  ClaimState state = ClaimState::not_run;
  std::string ours;  ///< our figures by the rule of the claim; or where it is measured
};

/// All claims in order. A claim whose runs are missing says so; one of several parts is partly reproduced where some of
/// them hold, and at most so where the claim is also about methods that neither these runs nor `peers` have.
std::vector<ClaimVerdict> judge_claims(const MethodResults& results, const PeerRows& peers = {});

nlohmann::json json_of(const std::vector<ClaimVerdict>& claims);
std::string claims_markdown(const std::vector<ClaimVerdict>& claims);

}  // namespace airside::tools
