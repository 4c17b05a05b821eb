#pragma once
// What a power cut may leave of the box folder of a real airsided, from its write log: an adversary's disk under POSIX.
//   File content is durable after fsync or fdatasync of the file, a name after fsync of its folder; nothing before is.
//   Whatever has been written since may be there or not in sectors of 512 bytes, in any combination and order; one
//   sector may be torn at any byte; a file may have grown without its content (zeros); names that were made, renamed or
//   removed since the folder's fsync are any subset of what was done, in order; a rename is whole or not there.
// Each state is handed to the daemon's own loading code, on a memory file system: DurableStore::open and load,
// RowLog::open and resume, StateCopy::load, and what the inbox holds.

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "airside/splitmix64.hpp"
#include "hal/storage/durable_store.hpp"
#include "power_loss/io_record.hpp"

namespace airside::power_loss {

using Bytes = std::vector<std::byte>;

/// The record of one or more processes one after the other.
struct Trace {
  struct Op {
    IoKind kind = IoKind::start;
    std::string name, to;  ///< to: of a rename
    std::uint64_t inode = 0, offset = 0;
    std::span<const std::byte> payload;
  };
  Bytes file;
  std::vector<Op> ops;

  /// Errors: runtime_error for a file that is no record.
  static std::shared_ptr<const Trace> read(const std::string& path);
};

/// Sizes of the scripted writer's state (script_writer.cpp): a process that commits and logs as the daemon does, with
/// records of a few sectors, so that far more of what may become of them can be tried.
inline hal::StoreLayout script_layout() {
  return {.learning_bytes = 3000,
          .row_bytes = 900,
          .transition_bytes = 40,
          .ring_capacity = 20,
          .spare_slots = 8,
          .meaning = 34};
}

/// How much to do. A state is counted once, by the content and names of all files that are loaded.
struct CutOptions {
  std::uint64_t states = 100'000;                 ///< distinct ones wanted; the exhaustive parts are done in any case
  std::uint64_t most_states = ~std::uint64_t{0};  ///< of the exhaustive parts too
  std::uint64_t seed = 1;
  int jobs = 1;
  bool scripted = false;                            ///< the trace is the scripted writer's
  int stride = 1;                                   ///< only every stride-th row's crash points, for short runs
  std::uint64_t most_of_point = ~std::uint64_t{0};  ///< states of a crash point in the exhaustive part, for short runs
  double seconds = 1e9;                             ///< stop sampling after so long
  std::uint64_t samples = 64;                       ///< of a crash point in one round of sampling
  bool until_found = false;                         ///< stop at the first finding
};

struct CutCounts {
  std::uint64_t crash_points = 0;
  std::uint64_t made = 0;            ///< states made, those that had been seen before included
  std::uint64_t distinct = 0;        ///< of the whole box
  std::uint64_t distinct_store = 0;  ///< of slots and journal alone: so many times DurableStore::load() ran
  std::uint64_t old_generation = 0, new_generation = 0, before_first = 0;
  std::uint64_t logs = 0, copies = 0;  ///< times that RowLog and StateCopy ran
  std::uint64_t exhaustive = 0;        ///< distinct ones when the exhaustive parts were done
  double seconds = 0;
  std::vector<std::string> findings;  ///< the first few
  std::uint64_t all_findings = 0;
};

/// Cuts the power everywhere in `trace` and loads what is left. Errors: runtime_error for a trace that is not whole.
CutCounts cut_power(const Trace& trace, const CutOptions& options);

}  // namespace airside::power_loss
