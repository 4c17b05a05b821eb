#include "power_loss/power_cut.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <thread>
#include <unordered_map>
#include <unordered_set>

#include "airside/crc32c.hpp"
#include "hal/civil_text.hpp"
#include "hal/folder_names.hpp"
#include "hal/row_log.hpp"
#include "hal/state_copy.hpp"
#include "power_loss/box_row.hpp"
#include "power_loss/test_folder.hpp"

namespace airside::power_loss {
namespace {

using Topology_ = FiveZone;
using Inode = std::uint64_t;

constexpr std::size_t sector = 512;

std::uint64_t mixed(std::uint64_t h, std::uint64_t word) {
  h = (h ^ word) * 0x9E3779B97F4A7C15u;
  return h ^ (h >> 29);
}

std::uint64_t hash_of(const std::string& text) { return hal::digest64(std::as_bytes(std::span(text))); }

bool is_loaded(const std::string& name) {
  for (const char* prefix : {"state/row.", "state/learning.", "state/replay.", "state/previous", "log/", "inbox/"}) {
    if (name.starts_with(prefix)) return true;
  }
  return false;
}
bool is_store(const std::string& name) {
  return name.compare(0, 10, "state/row.") == 0 || name.compare(0, 15, "state/learning.") == 0 ||
         name.compare(0, 13, "state/replay.") == 0;
}
std::string folder_of(const std::string& name) { return name.substr(0, name.rfind('/')); }

/// A file's bytes with a hash over its sectors that follows changes without being made anew.
struct Content {
  Bytes bytes;
  std::vector<std::uint64_t> hash;  ///< a sector
  std::uint64_t sum = 0;

  std::uint64_t hash_of_sector(std::size_t i) const {
    const std::size_t from = i * sector, to = std::min(bytes.size(), from + sector);
    return mixed(hal::digest64(std::span(bytes).subspan(from, to - from)), i + 1);
  }
  void rehash(std::size_t from, std::size_t to) {
    const std::size_t count = (bytes.size() + sector - 1) / sector;
    for (std::size_t i = count; i < hash.size(); ++i) sum -= hash[i];
    hash.resize(count, 0);
    for (std::size_t i = from / sector; i < count && i * sector < to; ++i) {
      sum -= hash[i];
      hash[i] = hash_of_sector(i);
      sum += hash[i];
    }
  }
  /// Of sector i where it is full and zero.
  static std::uint64_t hash_of_zeros(std::size_t i) {
    static const std::uint64_t zeros = hal::digest64(std::array<std::byte, sector>{});
    return mixed(zeros, i + 1);
  }
  void resize(std::size_t size) {
    const std::size_t old = bytes.size();
    bytes.resize(size);
    if (size <= old) return rehash(size / sector * sector, size);
    const std::size_t first = (old + sector - 1) / sector, last = size / sector;
    rehash(old / sector * sector, std::min(size, first * sector));
    for (std::size_t i = first; i < last; ++i) {
      hash[i] = hash_of_zeros(i);
      sum += hash[i];
    }
    rehash(last * sector, size);
  }
  void write(std::uint64_t offset, std::span<const std::byte> from) {
    const auto at = static_cast<std::size_t>(offset);
    if (bytes.size() < at + from.size()) resize(at + from.size());
    std::copy(from.begin(), from.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
    rehash(at / sector * sector, at + from.size());
  }
  std::uint64_t digest() const { return mixed(sum, bytes.size()); }
};

/// A part of an operation that reaches the medium as one: a piece of a sector, a new size.
struct Cell {
  Inode inode = 0;
  std::uint64_t offset = 0;          ///< of the bytes; the new size
  std::span<const std::byte> bytes;  ///< none: a size
  bool grows = false;                ///< a size that is only a lower bound
  bool dropped = false;              ///< a sync failed after it: later ones confirm nothing
};

using Names = std::map<std::string, Inode>;

void change(Names& names, const Trace::Op& op) {
  if (op.kind == IoKind::create) names[op.name] = op.inode;
  if (op.kind == IoKind::unlink) names.erase(op.name);
  if (op.kind == IoKind::rename) {
    const auto found = names.find(op.name);
    if (found == names.end()) return;  // its creation did not reach the medium: neither did this
    const Inode inode = found->second;
    names.erase(found);
    names[op.to] = inode;
  }
}

constexpr CivilTime script_begin{1625097600};

RowFacts facts_of(std::span<const std::byte> row, bool scripted) {
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
  std::mutex mutex;
  std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
  Shared(const Trace& t, const CutOptions& o)
      : trace(t), options(o), seen(o.states * 5 / 4 + 1'000'000), seen_store(o.states * 5 / 4 + 1'000'000) {}
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(); }
};

class Cutter {
 public:
  Cutter(Shared& shared, int job)
      : layout_(shared.options.scripted ? script_layout() : box_layout()),
        counts_of_log_(shared.options.scripted ? hal::counts_of<ThreeVav>() : hal::counts_of<Topology_>()),
        shared_(shared),
        job_(job),
        folder_("cut" + std::to_string(job)),
        random_(shared.options.seed * 1000 + static_cast<std::uint64_t>(job)),
        state_dir_(folder_.file("box/state").string()),
        log_dir_(folder_.file("box/log").string()),
        learning_(layout_.learning_bytes),
        row_(layout_.row_bytes),
        replay_(layout_.transition_bytes * layout_.ring_capacity),
        copy_(layout_.learning_bytes) {
    for (const char* part : {"pool", "box", "box/state", "box/log", "box/inbox"}) {
      std::filesystem::create_directory(folder_.file(part));
    }
    pool_ = ::open(folder_.file("pool").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    box_ = ::open(folder_.file("box").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  }
  ~Cutter() {
    for (const auto& [inode, fd] : fd_) ::close(fd);
    ::close(pool_);
    ::close(box_);
  }
  Cutter(const Cutter&) = delete;
  Cutter& operator=(const Cutter&) = delete;

  /// Follows the whole trace; at this thread's crash points all that `round` asks for is made. Round 0: the exhaustive
  /// part; further ones: samples.
  void follow(int round) {
    round_ = round;
    start_over();
    std::uint64_t rows_seen = 0;
    for (std::size_t k = 0; k < shared_.trace.ops.size(); ++k) {
      const Trace::Op& op = shared_.trace.ops[k];
      take(op);
      if (shared_.seen.full() || enough()) return;
      if (!matters_) continue;
      rows_seen = meaning_.rows.empty() ? 0 : meaning_.rows.rbegin()->first;
      if (rows_seen % static_cast<std::uint64_t>(shared_.options.stride) != 0 && !rare_) continue;
      if (static_cast<int>(k % static_cast<std::size_t>(shared_.options.jobs)) != job_) continue;
      if (round == 0) ++counts_.crash_points;
      crash_point_ = k;
      cut_here(op);
    }
  }
  bool enough() const {
    const std::uint64_t distinct = shared_.seen.count();
    if (distinct >= shared_.options.most_states || shared_.seconds() > shared_.options.seconds) return true;
    return round_ > 0 && distinct >= shared_.options.states;
  }
  void give_counts() {
    const std::scoped_lock lock(shared_.mutex);
    CutCounts& all = shared_.counts;
    all.crash_points += counts_.crash_points;
    all.made += counts_.made;
    all.old_generation += counts_.old_generation;
    all.new_generation += counts_.new_generation;
    all.before_first += counts_.before_first;
    all.logs += counts_.logs;
    all.copies += counts_.copies;
    counts_ = {};
  }

 private:
  struct File {
    Content durable, work;  ///< equal between states, as is the file of the pool
    Content now;            ///< as the process sees it; only of what is not large
    std::string first_name;
    std::vector<Cell> pending;
    bool loaded = true;
  };

  void start_over() {
    for (const auto& [inode, fd] : fd_) {
      ::close(fd);
      ::unlinkat(pool_, std::to_string(inode).c_str(), 0);
    }
    for (const auto& [name, inode] : actual_) ::unlinkat(box_, name.c_str(), 0);
    fd_.clear();
    files_.clear();
    durable_names_.clear();
    actual_.clear();
    pending_names_.clear();
    meaning_ = {};
    results_.clear();
  }

  // ---- following the trace

  void take(const Trace::Op& op) {
    matters_ = false;
    rare_ = false;
    switch (op.kind) {
      case IoKind::start: excused_ = true; return;
      case IoKind::create: {
        File& file = files_[op.inode];
        file.first_name = op.name;
        file.loaded = is_loaded(op.name);
        if (!file.loaded) return;
        pending_names_.push_back(&op);
        const int fd = ::openat(pool_, std::to_string(op.inode).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
        if (fd < 0) throw std::runtime_error("cannot make a file of the pool");
        fd_[op.inode] = fd;
        rare_ = matters_ = true;
        break;
      }
      case IoKind::rename:
      case IoKind::unlink:
        if (!is_loaded(op.name)) return;
        pending_names_.push_back(&op);
        rare_ = matters_ = true;
        if (op.kind == IoKind::rename && op.to.ends_with(".blob")) note_push(op);
        break;
      case IoKind::sync_dir: {
        std::erase_if(pending_names_, [&](const Trace::Op* pending) {
          if (folder_of(pending->name) != op.name) return false;
          change(durable_names_, *pending);
          return true;
        });
        if (op.name == "state") {
          // From here on a file has the space that it was given; the states before have it in part.
          for (auto& [inode, file] : files_) {
            if (file.pending.size() != 1 || !file.pending[0].grows || !is_store(file.first_name)) continue;
            confirm(file);
            settle(inode, file);
          }
        }
        if (op.name == "inbox") {
          for (auto& push : meaning_.pushes) push.durable = true;
          if (durable_names_.contains("inbox/rollback")) meaning_.wants_rollback = true;
        }
        rare_ = matters_ = true;
        break;
      }
      case IoKind::write: {
        File& file = file_of(op);
        if (!file.loaded) return;
        const std::uint64_t end = op.offset + op.payload.size();
        if (end > size_now(file)) file.pending.push_back({op.inode, end, {}, true});
        for (std::uint64_t at = op.offset; at < end;) {
          const std::uint64_t next = std::min(end, (at / sector + 1) * sector);
          file.pending.push_back({op.inode, at, op.payload.subspan(at - op.offset, next - at), false});
          at = next;
        }
        if (!is_store(file.first_name)) file.now.write(op.offset, op.payload);
        note_write(op, file);
        matters_ = true;
        rare_ = !is_store(file.first_name) && file.first_name.compare(0, 4, "log/") != 0;
        break;
      }
      case IoKind::truncate:
      case IoKind::allocate: {
        File& file = file_of(op);
        if (!file.loaded) return;
        file.pending.push_back({op.inode, op.offset, {}, op.kind == IoKind::allocate});
        if (op.kind == IoKind::truncate && !is_store(file.first_name)) {
          file.now.resize(static_cast<std::size_t>(op.offset));
        }
        rare_ = matters_ = true;
        break;
      }
      case IoKind::failed: excused_ = true; return;
      case IoKind::failed_sync:
        excused_ = true;
        for (Cell& cell : file_of(op).pending) cell.dropped = true;
        return;
      case IoKind::sync_file: {
        File& file = file_of(op);
        if (!file.loaded) return;
        confirm(file);
        settle(op.inode, file);
        note_sync(op.inode);
        matters_ = true;
        break;
      }
    }
  }

  /// A sync that returned: all that was not dropped is durable, and so is every dropped byte that was written again.
  static void confirm(File& file) {
    std::vector<Cell> doubtful;
    for (std::size_t i = 0; i < file.pending.size(); ++i) {
      const Cell& cell = file.pending[i];
      if (!cell.dropped) {
        put(file.durable, cell);
        continue;
      }
      std::vector<bool> again(std::max<std::size_t>(cell.bytes.size(), 1), false);
      for (std::size_t j = i + 1; j < file.pending.size(); ++j) {
        const Cell& later = file.pending[j];
        if (later.dropped || later.bytes.empty() != cell.bytes.empty()) continue;
        if (cell.bytes.empty()) again[0] = true;
        for (std::size_t k = 0; k < cell.bytes.size(); ++k) {
          const std::uint64_t at = cell.offset + k;
          if (at >= later.offset && at < later.offset + later.bytes.size()) again[k] = true;
        }
      }
      if (std::find(again.begin(), again.end(), false) != again.end()) doubtful.push_back(cell);
    }
    file.pending = doubtful;
  }

  File& file_of(const Trace::Op& op) {
    const auto found = files_.find(op.inode);
    if (found == files_.end()) throw std::runtime_error("the record changes a file that it never saw made");
    return found->second;
  }

  static std::uint64_t size_now(const File& file) {
    std::uint64_t size = file.durable.bytes.size();
    for (const Cell& cell : file.pending) size = size_after(size, cell);
    return size;
  }
  static std::uint64_t size_after(std::uint64_t size, const Cell& cell) {
    if (cell.bytes.empty()) return cell.grows ? std::max(size, cell.offset) : cell.offset;
    return std::max(size, cell.offset + cell.bytes.size());
  }
  static void put(Content& content, const Cell& cell, std::size_t bytes = ~std::size_t{0}) {
    if (!cell.bytes.empty()) {
      content.write(cell.offset, cell.bytes.first(std::min(bytes, cell.bytes.size())));
    } else if (const auto size = static_cast<std::size_t>(cell.offset); !cell.grows || size > content.bytes.size()) {
      content.resize(size);
    }
  }

  /// Brings `work` and the pool's file to `durable`.
  void settle(Inode inode, File& file) {
    const int fd = fd_.at(inode);
    const std::size_t old = file.work.bytes.size(), size = file.durable.bytes.size();
    if (old != size && ::ftruncate(fd, static_cast<off_t>(size)) != 0) throw std::runtime_error("ftruncate");
    file.work.resize(size);
    for (std::size_t i = 0; i < file.durable.hash.size();) {
      if (file.work.hash[i] == file.durable.hash[i]) {
        ++i;
        continue;
      }
      std::size_t to = i + 1;
      while (to < file.durable.hash.size() && file.work.hash[to] != file.durable.hash[to]) ++to;
      const std::size_t from = i * sector, end = std::min(size, to * sector);
      file.work.write(from, std::span(file.durable.bytes).subspan(from, end - from));
      write_pool(fd, file.work, from, end);
      i = to;
    }
  }
  static void write_pool(int fd, const Content& content, std::size_t from, std::size_t to) {
    const auto done = ::pwrite(fd, content.bytes.data() + from, to - from, static_cast<off_t>(from));
    if (done != static_cast<ssize_t>(to - from)) throw std::runtime_error("pwrite");
  }

  void note_write(const Trace::Op& op, const File& file) {
    const std::string& name = file.first_name;
    if (name.compare(0, 13, "state/replay.") == 0) {
      const std::size_t stride = sizeof(hal::JournalEntry) + (layout_.transition_bytes + 7) / 8 * 8;
      const std::uint64_t odd = name.back() == 'b' ? 1 : 0;
      for (std::size_t at = 0; at + stride <= op.payload.size(); at += stride) {
        hal::JournalEntry entry;
        std::memcpy(&entry, op.payload.data() + at, sizeof entry);
        // The epoch is not in the entry but in its digest: one of the two that are near.
        const auto bytes = op.payload.subspan(at + sizeof entry, layout_.transition_bytes);
        for (std::uint64_t epoch = odd; epoch < odd + 64; epoch += 2) {
          if (entry.digest != hal::digest64(bytes, entry.number ^ (epoch << 40))) continue;
          auto& numbers = meaning_.replay[epoch];
          if (numbers.size() <= entry.number) numbers.resize(static_cast<std::size_t>(entry.number) + 1);
          numbers[static_cast<std::size_t>(entry.number)] = bytes;
          break;
        }
      }
      return;
    }
    if (!is_store(name)) return;
    const bool is_row = name.compare(0, 10, "state/row.") == 0;
    if (op.offset == 0) {
      hal::RecordHeader header;
      if (op.payload.size() < sizeof header) return;  // a kill cut it short
      std::memcpy(&header, op.payload.data(), sizeof header);
      meaning_.front[op.inode] = header;
      if (is_row) {
        meaning_.row_in.erase(op.inode);
        if (!meaning_.in_flight.empty() && !excused_) report("a row record was never forced to the medium");
        excused_ = false;
        meaning_.in_flight.push_back(header.generation);
        meaning_.rows[header.generation] = {header, {}, {}, {}};
      } else {
        meaning_.learning_header[header.generation] = header;
      }
      return;
    }
    if (op.offset != hal::payload_offset) return;  // the learning record's copy of the row
    const hal::RecordHeader& header = meaning_.front.at(op.inode);
    if (!is_row) {
      if (op.payload.size() == layout_.learning_bytes) meaning_.learning[header.generation] = op.payload;
      return;
    }
    if (op.payload.size() != layout_.row_bytes) return;
    Generation& generation = meaning_.rows.at(header.generation);
    generation.row = op.payload;
    generation.learning = meaning_.learning[header.learning_generation];
    generation.record = facts_of(op.payload, shared_.options.scripted);
    meaning_.row_in[op.inode] = header.generation;
  }

  void note_sync(Inode inode) {
    const auto found = meaning_.row_in.find(inode);
    if (found == meaning_.row_in.end() || found->second <= meaning_.committed) return;
    const std::uint64_t before = meaning_.committed;
    meaning_.committed = found->second;
    std::erase_if(meaning_.in_flight, [&](std::uint64_t g) { return g <= meaning_.committed; });
    const RowFacts& record = meaning_.rows.at(meaning_.committed).record;
    if (record.rolled_back) meaning_.wants_rollback = false;
    std::erase_if(meaning_.rows, [&](const auto& pair) { return pair.first < before; });
    // What the generations in play do not name is not looked for any more.
    if (meaning_.replay.size() > 3) meaning_.replay.erase(meaning_.replay.begin());
    while (meaning_.learning.size() > 4) meaning_.learning.erase(meaning_.learning.begin());
  }

  void note_push(const Trace::Op& op) {
    // The name's inode as the process saw it: made just before.
    for (auto at = pending_names_.rbegin(); at != pending_names_.rend(); ++at) {
      if ((*at)->kind != IoKind::create || (*at)->name != op.name) continue;
      const File& file = files_.at((*at)->inode);
      meaning_.pushes.push_back({crc32c(file.now.bytes), false});
      return;
    }
    const auto found = durable_names_.find(op.name);
    if (found != durable_names_.end()) {
      meaning_.pushes.push_back({crc32c(files_.at(found->second).now.bytes), false});
    }
  }

  // ---- the states of one crash point

  void cut_here(const Trace::Op& op) {
    cells_.clear();
    for (auto& [inode, file] : files_) {
      if (file.loaded) cells_.insert(cells_.end(), file.pending.begin(), file.pending.end());
    }
    const std::size_t n = cells_.size(), d = pending_names_.size();
    std::vector<bool> none_c(n, false), all_c(n, true), all_d(d, true);
    const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(shared_.options.most_of_point, 1'000'000));
    if (round_ == 0) {
      make_state(none_c, std::vector<bool>(d, false), none_torn, 0);
      make_state(all_c, all_d, none_torn, 0);
      // Torn at every byte: everything before is there, and of this operation's cells all before the torn one.
      if (op.kind == IoKind::write && n > 0) {
        std::vector<bool> chosen = all_c;
        std::size_t first = n;
        for (std::size_t i = 0; i < n; ++i) {
          if (cells_[i].inode == op.inode && !cells_[i].bytes.empty() && cells_[i].bytes.data() >= op.payload.data() &&
              cells_[i].bytes.data() < op.payload.data() + op.payload.size()) {
            first = std::min(first, i);
            chosen[i] = false;
          }
        }
        const bool every_byte = op.payload.size() <= 8192;
        for (std::size_t i = first; i < n && cells_[i].inode == op.inode; ++i) {
          chosen[i] = true;
          const std::size_t size = cells_[i].bytes.size();
          if (every_byte) {
            const std::size_t step = 1 + op.payload.size() / most;
            for (std::size_t bytes = step; bytes < size; bytes += step) make_state(chosen, all_d, i, bytes);
          } else if (random_.below(16) == 0) {
            make_state(chosen, all_d, i, 1 + random_.below(static_cast<std::uint32_t>(size)));
          }
          make_state(chosen, all_d, none_torn, 0);
          if (enough()) return;
        }
      }
      if (n + d <= 10) {
        const std::size_t masks = std::size_t{1} << (n + d);
        for (std::size_t turn = 0; turn < std::min(masks, most); ++turn) {
          const std::size_t mask = masks <= most ? turn : random_.below(static_cast<std::uint32_t>(masks));
          std::vector<bool> c(n), names(d);
          for (std::size_t i = 0; i < n; ++i) c[i] = (mask >> i & 1) != 0;
          for (std::size_t i = 0; i < d; ++i) names[i] = (mask >> (n + i) & 1) != 0;
          make_state(c, names, none_torn, 0);
        }
        return;
      }
    }
    if (n + d == 0) return;
    const bool rests = op.kind == IoKind::sync_file || op.kind == IoKind::sync_dir;
    const std::uint64_t samples = rests ? 2 : std::min<std::uint64_t>(shared_.options.samples, most);
    for (std::uint64_t i = 0; i < samples && !enough(); ++i) sample(n, d);
  }

  void sample(std::size_t n, std::size_t d) {
    std::vector<bool> c(n), names(d);
    const std::uint32_t density = random_.below(4);  // few, half, half, most
    const bool in_order = random_.below(2) == 0;
    const std::size_t cut = d == 0 ? 0 : random_.below(static_cast<std::uint32_t>(d) + 1);
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t r = random_.below(16);
      c[i] = density == 0 ? r == 0 : density == 3 ? r != 0 : r < 8;
    }
    for (std::size_t i = 0; i < d; ++i) names[i] = in_order ? i < cut : random_.below(2) == 0;
    std::size_t torn = none_torn, bytes = 0;
    if (n > 0) {
      torn = random_.below(static_cast<std::uint32_t>(n));
      if (cells_[torn].bytes.size() < 2) {
        torn = none_torn;
      } else {
        c[torn] = true;
        bytes = 1 + random_.below(static_cast<std::uint32_t>(cells_[torn].bytes.size() - 1));
      }
    }
    make_state(c, names, torn, bytes);
  }

  /// One state: these cells, the one at `torn` only up to `bytes`, and these changes of names.
  void make_state(const std::vector<bool>& chosen, const std::vector<bool>& names, std::size_t torn,
                  std::size_t bytes) {
    ++counts_.made;
    touched_.clear();
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (!chosen[i]) continue;
      File& file = files_.at(cells_[i].inode);
      put(file.work, cells_[i], i == torn ? bytes : ~std::size_t{0});
      if (touched_.empty() || touched_.back() != cells_[i].inode) touched_.push_back(cells_[i].inode);
    }
    Names wanted = durable_names_;
    for (std::size_t i = 0; i < pending_names_.size(); ++i) {
      if (names[i]) change(wanted, *pending_names_[i]);
    }
    std::uint64_t store = 17, box = 0;
    for (const auto& [name, inode] : wanted) {
      const std::uint64_t digest = mixed(hash_of(name), files_.at(inode).work.digest());
      if (is_store(name)) store += digest;
      box += digest;
    }
    if (shared_.seen.insert(box)) {
      const auto known = results_.find(store);
      if (known == results_.end()) shared_.seen_store.insert(store);
      look(wanted, store, box);
    }
    for (const Inode inode : touched_) unwind(inode);
  }

  /// Takes a file's chosen cells back, and what the loading code did to it.
  void unwind(Inode inode) {
    File& file = files_.at(inode);
    const std::size_t size = file.durable.bytes.size();
    if (on_disk_) {
      settle_from_disk(inode, file);
      return;
    }
    if (file.work.bytes.size() != size) file.work.resize(size);
    for (std::size_t i = 0; i < file.durable.hash.size(); ++i) {
      if (file.work.hash[i] == file.durable.hash[i]) continue;
      const std::size_t from = i * sector, to = std::min(size, from + sector);
      std::copy(file.durable.bytes.begin() + static_cast<std::ptrdiff_t>(from),
                file.durable.bytes.begin() + static_cast<std::ptrdiff_t>(to),
                file.work.bytes.begin() + static_cast<std::ptrdiff_t>(from));
      file.work.sum += file.durable.hash[i] - file.work.hash[i];
      file.work.hash[i] = file.durable.hash[i];
    }
  }
  void settle_from_disk(Inode inode, File& file) {
    // The pool's file equals `work`, but for its size.
    struct stat status {};
    if (::fstat(fd_.at(inode), &status) != 0) throw std::runtime_error("fstat");
    if (static_cast<std::size_t>(status.st_size) < file.work.bytes.size()) {
      file.work.resize(static_cast<std::size_t>(status.st_size));
    } else if (static_cast<std::size_t>(status.st_size) > file.work.bytes.size()) {
      file.work.resize(static_cast<std::size_t>(status.st_size));
    }
    settle(inode, file);
  }

  /// Puts the state on the disk, loads it, judges it, and takes the loading code's changes back.
  void look(const Names& wanted, std::uint64_t store, std::uint64_t box) {
    const auto known = results_.find(store);
    const bool fresh = known == results_.end();
    looked_at_log_ = false;
    on_disk_ = true;
    for (const Inode inode : touched_) {
      const File& file = files_.at(inode);
      if (!fresh && is_store(file.first_name)) continue;
      show(inode, file);
    }
    link_names(wanted);
    std::string finding;
    if (fresh && results_.size() > 200'000) results_.clear();
    Loaded loaded = fresh ? load_store() : known->second;
    if (fresh) results_[store] = loaded;
    finding = loaded.finding;
    if (finding.empty()) finding = judge(loaded, wanted, box);
    if (!finding.empty()) report(finding);
    // Whatever open(), load() and resume() did to names and sizes is undone.
    const bool lacks_files =
        fresh && std::count_if(wanted.begin(), wanted.end(), [](const auto& pair) { return is_store(pair.first); }) < 6;
    if (looked_at_log_ || lacks_files) read_names();
    for (const auto& [name, inode] : wanted) {
      if (!looked_at_log_ && !(fresh && is_store(name))) continue;
      if (std::find(touched_.begin(), touched_.end(), inode) != touched_.end()) continue;
      if (is_store(name) && !fresh) continue;
      File& file = files_.at(inode);
      struct stat status {};
      if (::fstat(fd_.at(inode), &status) != 0) throw std::runtime_error("fstat");
      if (static_cast<std::size_t>(status.st_size) == file.durable.bytes.size()) continue;
      file.work.resize(static_cast<std::size_t>(status.st_size));
      settle(inode, file);
    }
    for (const Inode inode : touched_) {
      File& file = files_.at(inode);
      if (!fresh && is_store(file.first_name)) {
        on_disk_ = false;
        unwind(inode);
        on_disk_ = true;
      } else {
        settle_from_disk(inode, file);
      }
    }
    on_disk_ = false;
  }

  void show(Inode inode, const File& file) {
    const int fd = fd_.at(inode);
    const std::size_t size = file.work.bytes.size();
    if (size != file.durable.bytes.size() && ::ftruncate(fd, static_cast<off_t>(size)) != 0) {
      throw std::runtime_error("ftruncate");
    }
    const auto differs = [&](std::size_t i) {
      if (i >= file.durable.hash.size()) return file.work.hash[i] != Content::hash_of_zeros(i);
      return file.work.hash[i] != file.durable.hash[i];
    };
    for (std::size_t i = 0; i < file.work.hash.size();) {
      if (!differs(i)) {
        ++i;
        continue;
      }
      std::size_t to = i + 1;
      while (to < file.work.hash.size() && differs(to)) ++to;
      write_pool(fd, file.work, i * sector, std::min(size, to * sector));
      i = to;
    }
  }

  void link_names(const Names& wanted) {
    if (actual_ == wanted) return;
    for (const auto& [name, inode] : actual_) {
      const auto found = wanted.find(name);
      if (found == wanted.end() || found->second != inode) ::unlinkat(box_, name.c_str(), 0);
    }
    for (const auto& [name, inode] : wanted) {
      const auto found = actual_.find(name);
      if (found != actual_.end() && found->second == inode) continue;
      if (::linkat(pool_, std::to_string(inode).c_str(), box_, name.c_str(), 0) != 0) {
        throw std::runtime_error("cannot link " + name);
      }
    }
    actual_ = wanted;
  }
  /// What stands in the box now; files that the loading code made go.
  void read_names() {
    Names kept;
    for (const auto& [name, inode] : actual_) {
      if (::faccessat(box_, name.c_str(), F_OK, 0) == 0) kept[name] = inode;
    }
    for (const char* part : {"state", "log", "inbox"}) {
      const int fd = ::openat(box_, part, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      std::vector<std::string> strange;
      hal::for_each_name(fd, [&](const char* name) {
        if (name[0] != '.' && !kept.contains(std::string(part) + "/" + name)) strange.emplace_back(name);
        return true;
      });
      for (const std::string& name : strange) ::unlinkat(fd, name.c_str(), 0);
      ::close(fd);
    }
    actual_ = kept;
  }

  // ---- the daemon's own loading code

  Loaded load_store() {
    Loaded result;
    auto store = hal::DurableStore::open(state_dir_.c_str(), layout_);
    if (!store || !store->ready()) {
      result.finding = "the store does not open";
      return result;
    }
    const auto loaded = store->load({learning_, row_, replay_});
    if (!loaded) {
      result.finding = "load: " + hal::describe(loaded.error());
      return result;
    }
    if (loaded->outcome == hal::LoadOutcome::none) {
      if (meaning_.committed > 0) result.finding = "a committed generation is lost";
      return result;
    }
    result.some = true;
    result.generation = loaded->generation;
    result.log = loaded->log;
    result.record = facts_of(row_, shared_.options.scripted);
    const bool in_flight =
        std::find(meaning_.in_flight.begin(), meaning_.in_flight.end(), loaded->generation) != meaning_.in_flight.end();
    if (meaning_.committed == 0 && !in_flight) return first_learning(*loaded, result);
    if (loaded->generation != meaning_.committed && !in_flight) {
      result.finding = "generation " + std::to_string(loaded->generation) + " is neither the committed one, " +
                       std::to_string(meaning_.committed) + ", nor one being written";
      return result;
    }
    if (meaning_.committed > 0 && loaded->outcome != hal::LoadOutcome::newest) {
      result.finding = std::string("outcome: ") + text_of(loaded->outcome);
      return result;
    }
    const Generation& want = meaning_.rows.at(loaded->generation);
    if (meaning_.committed == 0 && want.row.empty()) return first_learning(*loaded, result);
    const auto same = [](std::span<const std::byte> a, std::span<const std::byte> b) {
      return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size()) == 0;
    };
    if (!same(row_, want.row)) result.finding = "the row is a mixture";
    if (!same(learning_, want.learning)) result.finding = "the learning state is a mixture";
    const hal::LogPosition log{want.header.log_day, want.header.log_part, want.header.log_bytes};
    if (loaded->log != log) result.finding = "the log's position is another generation's";
    if (loaded->replay_count != want.header.replay_count) result.finding = "the replay's count is another generation's";
    const auto& numbers = meaning_.replay[want.header.epoch];
    const std::uint64_t end = loaded->replay_count;
    for (std::uint64_t k = end > layout_.ring_capacity ? end - layout_.ring_capacity : 0; k < end; ++k) {
      const auto slot = static_cast<std::size_t>(k % layout_.ring_capacity) * layout_.transition_bytes;
      if (k >= numbers.size() || !same(std::span(replay_).subspan(slot, layout_.transition_bytes), numbers[k])) {
        result.finding = "transition " + std::to_string(k) + " is not the generation's";
        break;
      }
    }
    return result;
  }

  /// Before any row record was written: the learning record with its own copy of the row is the new generation.
  Loaded first_learning(const hal::LoadedState& loaded, Loaded result) const {
    const auto found = meaning_.learning.find(loaded.learning_generation);
    if (found == meaning_.learning.end() || found->second.size() != learning_.size() ||
        std::memcmp(found->second.data(), learning_.data(), learning_.size()) != 0) {
      result.finding = "the first learning record is a mixture";
    }
    return result;
  }

  std::string judge(const Loaded& loaded, const Names& wanted, std::uint64_t box) {
    if (!loaded.some) {
      ++counts_.before_first;
      return meaning_.committed > 0 ? "a committed generation is lost" : "";
    }
    ++(loaded.generation == meaning_.committed ? counts_.old_generation : counts_.new_generation);
    if (loaded.generation < meaning_.committed) return "an old generation came back";
    if (std::string finding = judge_log(loaded, wanted, box); !finding.empty()) return finding;
    return judge_weights(loaded, wanted);
  }

  std::string judge_log(const Loaded& loaded, const Names& wanted, std::uint64_t box) {
    // The log's fate depends on its files and on the position that is resumed alone: what was judged well is known.
    std::uint64_t key = mixed(static_cast<std::uint64_t>(loaded.log.day) * 100 + loaded.log.part, loaded.log.bytes);
    key = mixed(key, static_cast<std::uint64_t>(loaded.record.row_time.seconds));
    for (auto at = wanted.lower_bound("log/"); at != wanted.end() && at->first.compare(0, 4, "log/") == 0; ++at) {
      key += mixed(hash_of(at->first), files_.at(at->second).work.digest());
    }
    if (good_logs_.contains(key)) return {};
    looked_at_log_ = true;
    if (std::string finding = judge_log_now(loaded, wanted, box); !finding.empty()) return finding;
    if (good_logs_.size() > 1'000'000) good_logs_.clear();
    good_logs_.insert(key);
    return {};
  }
  std::string judge_log_now(const Loaded& loaded, const Names& wanted, std::uint64_t box) {
    ++counts_.logs;
    auto log = hal::RowLog::open(log_dir_.c_str(), counts_of_log_, limits_);
    if (!log) return "the log does not open: " + hal::describe(log.error());
    if (loaded.log.bytes == 0) return {};
    if (const auto done = log->resume(loaded.log); !done) return "the log: " + hal::describe(done.error());
    if (log->position() != loaded.log) return "the log ends elsewhere than committed";
    if (log->last_time() != loaded.record.row_time) return "the log's last row is not the generation's";
    // The committed part is what the process wrote, byte for byte; it only ever grew.
    std::string name;
    for (const auto& [path, inode] : wanted) {
      if (path.compare(0, 4, "log/") == 0 && name < path &&
          position_of(path) == std::pair(loaded.log.day, loaded.log.part)) {
        name = path;
      }
    }
    if (name.empty()) return "the committed log file has no name";
    const File& file = files_.at(wanted.at(name));
    const auto size = static_cast<std::size_t>(loaded.log.bytes);
    if (file.now.bytes.size() < size || file.work.bytes.size() < size ||
        std::memcmp(file.now.bytes.data(), file.work.bytes.data(), size) != 0) {
      return "a committed row of the log is not what was written";
    }
    for (const auto& [path, inode] : durable_names_) {
      if (path.compare(0, 4, "log/") == 0 && position_of(path) < std::pair(loaded.log.day, loaded.log.part) &&
          !is_pending_unlink(path) && ::faccessat(box_, path.c_str(), F_OK, 0) != 0 && log->files() < max_files) {
        return "an older log file is gone";
      }
    }
    if (box % 64 != 0) return {};
    hal::LogRow row = hal::make_log_row(counts_of_log_);
    row.time = {loaded.record.row_time.seconds + row_s};
    const bool goes_on = log->append(row).has_value() && log->sync().has_value();
    spoil(wanted, name);
    return goes_on ? "" : "the log does not go on";
  }
  /// The trial append changed bytes behind the back of `work`.
  void spoil(const Names& wanted, const std::string& name) {
    for (const auto& [path, inode] : wanted) {
      if (path.compare(0, 4, "log/") != 0 || path < name) continue;
      File& file = files_.at(inode);
      if (::ftruncate(fd_.at(inode), static_cast<off_t>(file.work.bytes.size())) != 0) {
        throw std::runtime_error("ftruncate");
      }
      write_pool(fd_.at(inode), file.work, 0, file.work.bytes.size());
    }
  }
  static std::pair<std::int64_t, std::uint32_t> position_of(const std::string& path) {
    const std::string text = path.substr(path.rfind('/') + 1);
    const auto time = hal::parse_civil_text(text.substr(8, 10) + "T00:00:00");
    if (!time) return {0, 0};
    const std::uint32_t part = text.size() > 22 ? static_cast<std::uint32_t>(std::stoul(text.substr(19, 2))) : 0;
    return {time->day(), part};
  }
  bool is_pending_unlink(const std::string& path) const {
    return std::any_of(pending_names_.begin(), pending_names_.end(),
                       [&](const Trace::Op* op) { return op->kind == IoKind::unlink && op->name == path; });
  }

  std::string judge_weights(const Loaded& loaded, const Names& wanted) {
    const RowFacts& trial = loaded.record;
    if (meaning_.committed > 0 && loaded.generation != meaning_.committed) {
      const RowFacts& old = meaning_.rows.at(meaning_.committed).record;
      if (trial.counter < old.counter) return "an old counter came back";
    }
    // The last push lies in the inbox until a generation holds it.
    if (!meaning_.pushes.empty() && meaning_.pushes.back().durable) {
      const std::uint32_t crc = meaning_.pushes.back().crc;
      const bool consumed = trial.blob_crc == crc;
      const bool lies = std::any_of(wanted.begin(), wanted.end(), [](const auto& pair) {
        return pair.first.compare(0, 6, "inbox/") == 0 && pair.first.ends_with(".blob");
      });
      if (!consumed && !lies) return "a push is neither taken nor in the inbox";
    }
    if (meaning_.wants_rollback && !trial.rolled_back && !wanted.contains("inbox/rollback")) {
      return "an operator's wish is neither done nor in the inbox";
    }
    if (trial.previous_digest == 0) return {};
    // Whatever is on trial can go back to the weights that were before.
    std::uint64_t key = trial.previous_digest;
    for (const char* name : {"state/previous", "state/previous.new"}) {
      const auto found = wanted.find(name);
      key = mixed(key, found == wanted.end() ? 0 : files_.at(found->second).work.digest());
    }
    if (!whole_copies_.contains(key)) {
      ++counts_.copies;
      const hal::StateCopy copy(state_dir_, layout_.meaning);
      const auto read = copy.load(copy_, trial.previous_digest);
      if (!read) return "the weights before the push: " + hal::describe(read.error());
      whole_copies_.insert(key);
    }
    return {};
  }

  void report(const std::string& finding) {
    const std::scoped_lock lock(shared_.mutex);
    ++shared_.counts.all_findings;
    if (shared_.counts.findings.size() >= 20) return;
    shared_.counts.findings.push_back("operation " + std::to_string(crash_point_) + " of " +
                                      std::to_string(shared_.trace.ops.size()) + ": " + finding);
  }

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
  std::set<std::uint64_t> whole_copies_;
  std::unordered_set<std::uint64_t> good_logs_;
  bool looked_at_log_ = false;
  Bytes learning_, row_, replay_, copy_;
  CutCounts counts_;
  std::size_t crash_point_ = 0;
  bool excused_ = false;  ///< a kill or a failure since the last row record
  bool matters_ = false, rare_ = false, on_disk_ = false;
};

}  // namespace

std::shared_ptr<const Trace> Trace::read(const std::string& path) {
  auto trace = std::make_shared<Trace>();
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto bytes = std::as_bytes(std::span(text));
  trace->file.assign(bytes.begin(), bytes.end());
  for (std::size_t at = 0; at < trace->file.size();) {
    IoEntry entry;
    if (trace->file.size() - at < sizeof entry) throw std::runtime_error(path + ": ends within an entry");
    std::memcpy(&entry, trace->file.data() + at, sizeof entry);
    at += sizeof entry;
    if (entry.magic != IoEntry::mark || trace->file.size() - at < entry.name_bytes + entry.payload_bytes) {
      throw std::runtime_error(path + ": not a write log");
    }
    Op op;
    op.kind = entry.kind;
    op.inode = entry.inode;
    op.offset = entry.offset;
    const std::string name = text.substr(at, entry.name_bytes);
    op.name = name.substr(0, name.find('\0'));
    if (op.name.size() < name.size()) op.to = name.substr(op.name.size() + 1);
    at += entry.name_bytes;
    op.payload = std::span(trace->file).subspan(at, static_cast<std::size_t>(entry.payload_bytes));
    at += static_cast<std::size_t>(entry.payload_bytes);
    trace->ops.push_back(std::move(op));
  }
  return trace;
}

CutCounts cut_power(const Trace& trace, const CutOptions& options) {
  Shared shared(trace, options);
  std::vector<std::unique_ptr<Cutter>> cutters;
  for (int job = 0; job < options.jobs; ++job) cutters.push_back(std::make_unique<Cutter>(shared, job));
  for (int round = 0; round < 1000; ++round) {
    const std::uint64_t before = shared.seen.count();
    std::vector<std::thread> threads;
    std::vector<std::string> failed(cutters.size());
    for (std::size_t job = 0; job < cutters.size(); ++job) {
      threads.emplace_back([&, job] {
        try {
          cutters[job]->follow(round);
        } catch (const std::exception& e) {
          failed[job] = e.what();
        }
        cutters[job]->give_counts();
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (const std::string& text : failed) {
      if (!text.empty()) throw std::runtime_error(text);
    }
    if (round == 0) shared.counts.exhaustive = shared.seen.count();
    const bool enough = shared.seen.count() >= std::min(options.states, options.most_states) ||
                        shared.seconds() > options.seconds || shared.seen.full();
    if (enough || shared.seen.count() == before) break;
  }
  shared.counts.distinct = shared.seen.count();
  shared.counts.distinct_store = shared.seen_store.count();
  shared.counts.seconds = shared.seconds();
  return shared.counts;
}

}  // namespace airside::power_loss
