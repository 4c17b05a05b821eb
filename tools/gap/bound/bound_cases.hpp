#pragma once
// Sealed cases as a table to learn from: what a log shows beyond the model, in place of the log. No part of the
// workflow reads it; docs/gap-bound.md says what it is for.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/gap/blind/blind_draw.hpp"
#include "tools/gap/model/engine.hpp"
#include "tools/gap/model/responses.hpp"

namespace airside::tools::gap {

/// Drawings of the blind generator, one a seed: each has five stretches of weather of its own, and each of its cases a
/// room, people and noise of its own.
struct BoundPlan {
  std::uint64_t first_seed = 1;
  int drawings = 1;
  int cases = 50;  ///< single effects of a drawing
  std::string twin = "301";
  int days = 14;
  int jobs = 1;
  bool rough = false;  ///< sizes by the generator's table of noise
};

/// What a table of one window holds: channels of the residual, then what the room lived through.
struct BoundColumns {
  std::vector<std::string> names;
  std::vector<double> units_per_step;  ///< of the integers in a file
};
BoundColumns bound_columns(const sim::Channels& channels);

/// Measured less the nominal twin's replay of the recorded commands, and what was commanded and the weather beside it;
/// half-hour means.  Shape: bins x bound_columns().  NaN: missing.  Errors: as Engine::simulate.  Cost: one run.
Eigen::MatrixXd bound_table(const Engine& engine, const Window& window);

/// A table as 16-bit steps, column by column; -32768: missing; what is out of range stands at its end.
std::vector<std::int16_t> steps_of(const Eigen::MatrixXd& table, const BoundColumns& columns);

/// Noise by which sizes are found, one for all drawings: BlindSetup::noise of the first seed.
/// Errors: hal::InputError if nothing can be written below `folder`.  Cost: 200 s of one core.
std::map<bool, Eigen::VectorXd> bound_noise(const BoundPlan& plan, const std::vector<sim::Effect>& effects,
                                            const std::filesystem::path& folder, const std::function<void()>& done);

/// Writes SEED.bin and SEED.json into `folder` for every drawing that is not there yet: of each case the reference
/// period, the measured one, and the same days of the same room with nothing hidden in it.
/// Format: docs/formats.md, "Tables of the gap bound".
/// Errors: hal::InputError if they cannot be written.  Cost: 0.3 s a case and 1 s a drawing, on one core.
/// Returns how many drawings were made.
int make_bound_tables(const BoundPlan& plan, const std::map<bool, Eigen::VectorXd>& noise,
                      const std::vector<sim::Effect>& effects, const std::filesystem::path& folder,
                      const std::function<void()>& done = {});

/// The same of sealed cases that are there, as NAME.bin and NAME.json, without the days with nothing hidden.
/// Errors: hal::InputError of files that are missing or wrong.  Cost: as load_case() and two runs a case.
void make_bound_tables_of(const std::filesystem::path& cases, const std::filesystem::path& key,
                          const std::filesystem::path& folder, const std::string& name, int jobs,
                          const std::function<void()>& done = {});

}  // namespace airside::tools::gap
