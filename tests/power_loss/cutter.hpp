#pragma once
// Follows a write log and makes what a power cut may leave at each of its calls (cutter.cpp), and hands that to the
// daemon's own loading code (cut_judge.cpp). One for each thread.

#include <atomic>
#include <chrono>
#include <cstring>
#include <mutex>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>

#include "hal/log/row_log.hpp"
#include "power_loss/box_row.hpp"
#include "power_loss/cut_files.hpp"
#include "support/test_folder.hpp"

namespace airside::power_loss {

inline constexpr CivilTime script_begin{1625097600};

inline RowFacts facts_of(std::span<const std::byte> row, bool scripted) {
  if (scripted) {
    std::int64_t step = 0;
    std::memcpy(&step, row.data(), sizeof step);
    RowFacts facts;
    facts.row_time = {script_begin.seconds + step * row_s};
    return facts;
  }
  return facts_of_box_row(row);
}

/// A whole generation as the processes wrote it.
struct Generation {
  hal::RecordHeader header;
  std::span<const std::byte> row, learning;
  RowFacts record;
};

/// What the recorded operations mean, as far as they have been followed.
struct Meaning {
  std::map<std::uint64_t, Generation> rows;  ///< row records by generation, the last one written
  std::map<std::uint64_t, std::span<const std::byte>> learning;
  std::map<std::uint64_t, hal::RecordHeader> learning_header;
  std::map<std::uint64_t, std::vector<std::span<const std::byte>>> replay;  ///< by epoch and number
  std::uint64_t newest_epoch = 0;                                           ///< that a record names
  std::uint64_t committed = 0;               ///< generation of the newest row record that was synced
  std::vector<std::uint64_t> in_flight;      ///< begun since
  std::map<Inode, std::uint64_t> row_in;     ///< generation that was last written whole to a row slot
  std::map<Inode, hal::RecordHeader> front;  ///< last header written to a slot
  struct Push {
    std::uint32_t crc = 0;
    bool durable = false;
  };
  std::vector<Push> pushes;
  bool wants_rollback = false;  ///< a durable wish that no synced generation has done
};

/// What the daemon's loading code made of one image of slots and journal.
struct Loaded {
  bool some = false;
  std::uint64_t generation = 0;
  hal::LogPosition log;
  RowFacts record;
  std::string finding;
};

/// Set of 64-bit hashes for several threads.
class SeenStates {
 public:
  explicit SeenStates(std::uint64_t most) {
    std::size_t size = 1 << 20;
    while (size < most * 2) size *= 2;
    slots_ = std::vector<std::atomic<std::uint64_t>>(size);
  }
  bool insert(std::uint64_t hash) {
    if (hash == 0) hash = 1;
    for (std::size_t at = hash & (slots_.size() - 1);; at = (at + 1) & (slots_.size() - 1)) {
      std::uint64_t there = slots_[at].load(std::memory_order_relaxed);
      if (there == hash) return false;
      if (there == 0 && slots_[at].compare_exchange_strong(there, hash)) {
        ++count_;
        return true;
      }
      if (there == hash) return false;
    }
  }
  std::uint64_t count() const { return count_; }
  bool full() const { return count_ * 10 > slots_.size() * 8; }

 private:
  std::vector<std::atomic<std::uint64_t>> slots_;
  std::atomic<std::uint64_t> count_{0};
};

/// What the threads share.
struct Shared {
  const Trace& trace;
  const CutOptions& options;
  SeenStates seen, seen_store;
  CutCounts counts;
  std::atomic<bool> found{false};
  std::mutex mutex;
  std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
  Shared(const Trace& t, const CutOptions& o)
      : trace(t), options(o), seen(o.states * 5 / 4 + 1'000'000), seen_store(o.states * 5 / 4 + 1'000'000) {}
  bool ends() const { return seconds() > options.seconds || (options.until_found && found); }
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(); }
};

/// One thread's way through the write log, and its disk.
class Cutter {
 public:
  Cutter(Shared& shared, int job);
  ~Cutter();
  Cutter(const Cutter&) = delete;
  Cutter& operator=(const Cutter&) = delete;

  /// Follows the whole trace; at this thread's crash points all that `round` asks for is made. Round 0: the exhaustive
  /// part; further ones: samples.
  void follow(int round);
  bool enough() const;
  void give_counts();

 private:
  struct File {
    Content durable, work;  ///< equal between states, as is the file of the pool
    Content now;            ///< as the process sees it; only of what is not large
    std::string first_name;
    std::vector<Cell> pending;
    bool loaded = true;
  };

  void start_over();

  // ---- following the trace

  void take(const Trace::Op& op);

  /// A sync that returned: all that was not dropped is durable, and so is every dropped byte that was written again.
  static void confirm(File& file);

  File& file_of(const Trace::Op& op);

  static std::uint64_t size_now(const File& file);
  static std::uint64_t size_after(std::uint64_t size, const Cell& cell);
  static void put(Content& content, const Cell& cell, std::size_t bytes = ~std::size_t{0});

  /// Brings `work` and the pool's file to `durable`.
  void settle(Inode inode, File& file);
  static void write_pool(int fd, const Content& content, std::size_t from, std::size_t to);

  void note_write(const Trace::Op& op, const File& file);

  void note_sync(Inode inode);

  void note_push(const Trace::Op& op);

  // ---- the states of one crash point

  void cut_here(const Trace::Op& op);

  void sample(std::size_t n, std::size_t d);

  /// One state: these cells, the one at `torn` only up to `bytes`, and these changes of names.
  void make_state(const std::vector<bool>& chosen, const std::vector<bool>& names, std::size_t torn, std::size_t bytes);

  /// Takes a file's chosen cells back, and what the loading code did to it.
  void unwind(Inode inode);
  void settle_from_disk(Inode inode, File& file);

  /// Puts the state on the disk, loads it, judges it, and takes the loading code's changes back.
  void look(const Names& wanted, std::uint64_t store, std::uint64_t box);

  void show(Inode inode, const File& file);

  void link_names(const Names& wanted);
  /// What stands in the box now; files that the loading code made go.
  void read_names();

  // ---- the daemon's own loading code

  Loaded load_store();

  /// Before any row record was written: the learning record with its own copy of the row is the new generation.
  Loaded first_learning(const hal::LoadedState& loaded, Loaded result) const;

  std::string judge(const Loaded& loaded, const Names& wanted, std::uint64_t box);

  std::string judge_log(const Loaded& loaded, const Names& wanted, std::uint64_t box);
  std::string judge_log_now(const Loaded& loaded, const Names& wanted, std::uint64_t box);
  /// The trial append changed bytes behind the back of `work`.
  void spoil(const Names& wanted, const std::string& name);
  static std::pair<std::int64_t, std::uint32_t> position_of(const std::string& path);
  bool is_pending_unlink(const std::string& path) const;

  std::string judge_weights(const Loaded& loaded, const Names& wanted);

  void report(const std::string& finding);

  static constexpr std::size_t none_torn = ~std::size_t{0};
  static constexpr std::size_t max_files = 3;
  const hal::StoreLayout layout_;
  const hal::TopologyCounts counts_of_log_;
  const hal::RowLogLimits limits_{static_cast<int>(max_files), 100'000};
  Shared& shared_;
  int job_, round_ = 0;
  hal::TestFolder folder_;
  SplitMix64 random_;
  std::string state_dir_, log_dir_;
  int pool_ = -1, box_ = -1;
  std::map<Inode, File> files_;
  std::map<Inode, int> fd_;
  Names durable_names_, actual_;
  std::vector<const Trace::Op*> pending_names_;
  Meaning meaning_;
  std::vector<Cell> cells_;
  std::vector<Inode> touched_;
  std::unordered_map<std::uint64_t, Loaded> results_;  ///< of store images, within one crash point's meaning
  std::set<std::uint64_t> whole_copies_, good_counters_;
  std::unordered_set<std::uint64_t> good_logs_;
  bool looked_at_log_ = false;
  Bytes learning_, row_, replay_, copy_;
  CutCounts counts_;
  std::size_t crash_point_ = 0;
  bool excused_ = false;  ///< a kill or a failure since the last row record
  bool matters_ = false, rare_ = false, on_disk_ = false;
};

}  // namespace airside::power_loss
