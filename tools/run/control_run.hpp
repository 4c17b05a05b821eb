#pragma once
// The verbs of the host tools on one room: run the schedule, control, compare. They type-erase the topology: blobs are
// bytes, rows are log rows, the room is a PlantModel. Training has a folder of its own (training/).

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hal/log/log_csv.hpp"
#include "sim/plant_model.hpp"
#include "tools/baselines/baseline.hpp"
#include "tools/run/metrics.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {

using BlobBytes = std::vector<std::byte>;

/// Called with a share 0..1 of the work done.
using OnProgress = std::function<void(double)>;

/// What a run leaves behind.
struct ControlRun {
  std::vector<hal::LogRow> rows;       ///< every 6 min
  std::vector<CycleSample> cycles;     ///< every decision
  std::vector<EnergyRow> energy;       ///< every row
  std::uint64_t rejected_updates = 0;  ///< by the acceptance gate
  std::uint64_t optimiser_steps = 0;   ///< those that the gate refused too
};

/// What the site counts as target and working hours.
MetricsSettings metrics_settings(const Site& site);

/// Metrics of a run with the site's target and working hours.
Metrics metrics_of(const Site& site, const ControlRun& run);

/// The expert's schedule from the plant's present to `until`.
ControlRun run_schedule(const Site& site, sim::PlantModel& plant, CivilTime until, const OnProgress& progress = {});

/// Control by the product's code path with learning on, from the plant's present to `until`.
/// An empty blob: without weights; the objective band runs so, and learns from the history alone.
/// Errors: hal::InputError for a blob that does not fit.
ControlRun run_controller(const Site& site, sim::PlantModel& plant, const BlobBytes& blob,
                          const std::vector<hal::LogRow>& history, CivilTime until, std::uint64_t seed,
                          const OnProgress& progress = {});

/// The same days under another controller.
ControlRun run_baseline(const Site& site, sim::PlantModel& plant, BaselineController& baseline,
                        const std::vector<hal::LogRow>& history, CivilTime until, const OnProgress& progress = {});

/// The same days under a setpoint that `choose` gives each cycle, for floors.
ControlRun run_setpoints(const Site& site, sim::PlantModel& plant, const std::function<double()>& choose,
                         CivilTime until, const OnProgress& progress = {});

/// Reads a blob file whole and checks it against the site.  Errors: hal::InputError naming file and field.
BlobBytes read_blob(const std::string& path, const Site& site);
/// The most bytes that a blob of the site's topology has.
std::size_t most_blob_bytes(const Site& site);

}  // namespace airside::tools
