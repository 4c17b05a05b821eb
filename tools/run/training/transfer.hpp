#pragma once
// A source room's weights made to fit another room, from some days of its log.

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "tools/run/control_run.hpp"

namespace airside::tools {

struct FineTuneOptions {
  int steps = 3000;  ///< optimiser steps (docs/method.md 8, open point 12)
  std::uint64_t seed = 1;
  std::string provenance;
};

/// Fine-tuning (docs/method.md 8): the source's scaler and weights, fine-tuned on the target's logged schedule days;
/// the room head starts from the source's gain and is fitted to the same rows. An empty `source` trains from scratch.
/// Errors: hal::InputError for a blob that does not fit, or a log without a single transition.
BlobBytes fine_tune(const Site& site, const BlobBytes& source, std::span<const hal::LogRow> rows,
                    const FineTuneOptions& options, const OnProgress& progress = {});

/// How far the forecasts of a blob's room head, one cycle ahead, are from a room's log, root mean square, K; the head
/// learns on as it does on the box. NaN where the log has no forecast: its rows never follow each other for two cycles.
/// Errors: hal::InputError for a blob that does not fit.
double forecast_error_k(const Site& site, const BlobBytes& blob, std::span<const hal::LogRow> rows);

/// What a transfer has chosen, and the errors on the held-back rows that chose: of the room head's forecast one cycle
/// ahead, root mean square, K; NaN where nothing was compared.
struct Transferred {
  BlobBytes blob;
  bool source_kept = false;  ///< the blob holds the source's weights as they were
  double source_error_k = std::numeric_limits<double>::quiet_NaN();
  double tuned_error_k = std::numeric_limits<double>::quiet_NaN();
};

/// The source's weights fine-tuned on all rows, or as they are where fine-tuning would not help: both foretell the last
/// day of the log (of less than three days: its last third), fine-tuned on the rows before, the head learning on as it
/// does on the box; the smaller error wins. Without a source, or where no room head controls, this is fine_tune().
/// Errors: as fine_tune().  Cost: twice that of fine_tune().
Transferred transfer(const Site& site, const BlobBytes& source, const std::vector<hal::LogRow>& rows,
                     const FineTuneOptions& options, const OnProgress& progress = {});

}  // namespace airside::tools
