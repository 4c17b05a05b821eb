#pragma once
// Cycles from which a residual network learns, kept in a file: runs on several plants, or under earlier networks, are
// simulated once and learned from together.

#include <string>
#include <vector>

#include "tools/run/training/residual_training.hpp"

namespace airside::tools {

/// What a network learns from, and what it is tried on: other rooms, days and seeds.
struct ResidualCycles {
  std::vector<ResidualSample> learned, tried;
  int cycle_min = 0;  ///< length of each

  void add(const ResidualCycles& more);
};

/// Shape: 32 bytes of header ("airside cycles 1", counts of regressors, minutes of a cycle, learned and tried cycles),
/// then 19 float a cycle, little-endian.  Errors: hal::InputError for a place that cannot be written; what was there
/// stays.
void write_cycles(const std::string& path, const ResidualCycles& cycles);

/// Errors: hal::InputError for a file that is missing, no such file, of other regressors, cut short or not finite.
ResidualCycles read_cycles(const std::string& path);

/// Its numbers as lines of C++ literals with all their bits, as tools/run/training/built_in_residual.inc has them.
/// Errors: hal::InputError for a place that cannot be written; what was there stays.
void write_residual_text(const std::string& path, const ResidualNetwork& network);

}  // namespace airside::tools
