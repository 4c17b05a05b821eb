#pragma once
// A source room's weights made to fit another room, from some days of its log.

#include <cstdint>
#include <string>
#include <vector>

#include "tools/run/control_run.hpp"

namespace airside::tools {

struct FineTuneOptions {
  int steps = 3000;  ///< optimiser steps (docs/method.md 8, open point 12)
  std::uint64_t seed = 1;
  std::string provenance;
};

/// Transfer (docs/method.md 8): the source's scaler and weights, fine-tuned on the target's logged schedule days; the
/// room head starts from the source's gain and is fitted to the same rows. An empty `source` trains from scratch.
/// Errors: hal::InputError for a blob that does not fit, or a log without a single transition.
BlobBytes fine_tune(const Site& site, const BlobBytes& source, const std::vector<hal::LogRow>& rows,
                    const FineTuneOptions& options, const OnProgress& progress = {});

}  // namespace airside::tools
