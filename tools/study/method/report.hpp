#pragma once
// The studies of the published method as one page: its tables III to VII and figures 7 to 13 with ours beside them, and
// a verdict on each claim.

#include <string>
#include <vector>

#include "tools/report/charts/report_input.hpp"
#include "tools/study/method/claims.hpp"
#include "tools/study/method/peer_rows.hpp"
#include "tools/study/method/results.hpp"

namespace airside::tools {

/// What the page shows. A figure or table of which no run is there is left out.
ReportInput method_report(const MethodStudy& study, const MethodResults& results, const PeerRows& peers,
                          const std::vector<ClaimVerdict>& claims, const std::string& command);

}  // namespace airside::tools
