#pragma once
// Whole sets of settings. `paper_settings()` follows the printed method with the decisions of docs/method.md 15;
// `product_settings()` is what the rooms showed to be best (docs/results.md, "Why the default differs from the paper").

#include "airside/memory_size.hpp"
#include "airside/settings.hpp"

namespace airside {

/// The printed method. Source: docs/method.md 15.
constexpr ControllerSettings paper_settings() { return {}; }

/// The product's default: network and room head. Source: docs/results.md, "Why the default differs from the paper".
constexpr ControllerSettings product_settings() {
  ControllerSettings s;
  s.refine_step_k = 0.01;
  s.move_penalty = 0.1;
  s.confidence_scale = 3.0;
  s.confidence_full = 0.9;
  s.confidence_error_k = 0.5;
  s.label_vav = -1.0;
  s.batch = 128;
  s.updates_per_cycle = 2;
  s.recent_in_batch = 32;
  s.gate = 1;
  s.head = 1;
  return s;
}

static_assert(settings_valid(product_settings()));
static_assert(settings_valid(paper_settings()) || paper_settings().batch > max_batch);

}  // namespace airside
