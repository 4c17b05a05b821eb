#pragma once
// The printed network alone, without what was found to hold it off its target.

#include "airside/settings.hpp"

namespace airside {

/// Preset `paper-repaired`. Source: docs/results.md, "The printed network, repaired".
constexpr ControllerSettings paper_repaired_settings() {
  ControllerSettings s;
  s.confidence_full = 0.1;  // the schedule has no weight
  s.gamma = 0.0;            // no bootstrapped term, whose bias is an offset of the score
  s.label_vav = -1.0;       // more cool air lowers the room
  s.refine_step_k = 0.01;
  s.batch = 128;
  s.recent_in_batch = 32;
  return s;
}

static_assert(settings_valid(paper_repaired_settings()));

}  // namespace airside
