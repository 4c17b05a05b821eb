#pragma once
// Several stretches of a log as one window: days that were added later, or a test on site, beside the days before.

#include "tools/gap/model/forwarding_engine.hpp"
#include "tools/gap/model/responses.hpp"

namespace airside::tools::gap {

/// Windows one after another. The first day of each later one is not measured: it remembers an unknown start, as the
/// first one's does.  Errors: std::invalid_argument for none.
Window stacked_windows(const std::vector<Window>& windows);

/// Whole days of a recording, with its stretches.
sim::Recording part_of(const sim::Recording& recording, std::size_t first_row, std::size_t rows);

/// The first and the end of the last of its days.
struct Span {
  CivilTime from, to;
};
Span span_of(const sim::Recording& recording);

/// An engine that lives through each stretch of a recording on its own.
class StretchedEngine final : public ForwardingEngine {
 public:
  using ForwardingEngine::ForwardingEngine;
  sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override;
  sim::ChannelTable simulate_differing(std::uint64_t seed, const Changes& changes,
                                       const sim::Recording& recording) const override;
};

}  // namespace airside::tools::gap
