#pragma once
// What a right model scores on days it was not fitted to: the only nulls that have this building's own structure.

#include <vector>

#include "tools/gap/inference/selection.hpp"

namespace airside::tools::gap {

/// Blocks of the reference period, each scored by a model that was fitted to the others.
struct NullBlocks {
  Nuisance nuisance;  ///< sizes under which the blocks are most probable
  int block_days = 0;
  int blocks = 0;
  std::vector<double> log_likelihood_ratio;  ///< one a candidate: the largest of all blocks; 2 ln likelihood
  double best_log_likelihood_ratio = 0;      ///< the largest of all candidates
  double residual_ratio = 1;  ///< largest mean square of a block's whitened residual, over that of the whole fit
};

/// Where there is no reference period: no blocks, priors as they are.
NullBlocks no_null_blocks(const Responses& responses);

/// Every block in turn is left out, the linearised fit is repeated on the others, and all candidates are scored on the
/// block as if it were the measured period. Nothing is missing there, so every gain is noise or structure.
///   d_b = (J_o' J_o + I)^-1 (J_o' r_o - e), r_b' = r_b - J_b d_b; o: the other blocks, e: the estimate
/// Sizes of nuisances are those of a grid, one after the other, that make the blocks most probable:
///   ln p = -1/2 sum_b (r_b' M_b r_b + ln det M_b^-1)
/// Cost: no simulation; scores of all candidates once a block, a metric of each block for every size tried.  Source:
/// docs/gap-workflow.md, "3. Reference period".
NullBlocks null_blocks(const ReferenceFit& fit, const Responses& responses, const Window& window, int block_days = 4);

}  // namespace airside::tools::gap
