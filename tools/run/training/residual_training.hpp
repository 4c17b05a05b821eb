#pragma once
// Training of the residual network (lib/airside/forecast/residual_forecaster.hpp) on what the room head got wrong in
// simulated rooms.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "airside/forecast/residual_forecaster.hpp"
#include "tools/run/control_run.hpp"

namespace airside::tools {

/// What was seen at a cycle's beginning, and by how much the head's forecast was wrong at its end, K.
struct ResidualSample {
  std::array<float, ResidualFeatures::count> x{};
  float error_k = 0;
};

/// The samples of a run of the product: cycles with regressors whose end was seen too.
std::vector<ResidualSample> residual_samples(const Site& site, const ControlRun& run);

/// Samples as bytes, for a process that hands them to another.
std::string bytes_of(std::span<const ResidualSample> samples);
std::vector<ResidualSample> samples_from(std::string_view bytes);

/// How well errors are predicted. r2 = 1 - sum (e - f)^2 / sum e^2; ratio = mean |e - f| / mean |e|.
struct ResidualScore {
  std::size_t samples = 0;
  double r2 = 0, ratio = 1;
};
ResidualScore score_of(const ResidualNetwork& network, std::span<const ResidualSample> samples);

struct ResidualTraining {
  std::uint64_t seed = 1;
  int epochs = 30;
  int batch = 512;
  double learning_rate = 3e-3;  ///< at its height, a third of the way; it ends at nothing
  double weight_decay = 1e-4;
  double huber_k = 0.02;  ///< errors above count as their size, not as its square: outages must not drown the rest
};

/// Least mean Huber loss by Adam.  Cost: 30 epochs of 10^5 samples take some 25 s on a core.
/// Errors: hal::InputError for less samples than a batch.  Source: docs/method.md 16.6.
ResidualNetwork train_residual(std::span<const ResidualSample> samples, const ResidualTraining& training,
                               const OnProgress& progress = {});

/// Whether a blob that was read carries a residual network.
bool has_residual(const BlobBytes& blob);

/// The blob with another residual network, all else as it was.
BlobBytes with_residual(const Site& site, const BlobBytes& blob, const ResidualNetwork& network,
                        const std::string& provenance);

}  // namespace airside::tools
