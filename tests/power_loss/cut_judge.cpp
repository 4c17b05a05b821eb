// What the daemon's own loading code makes of a state, and whether that is the old generation or the new one.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "hal/storage/state_copy.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/weights/counter_ledger.hpp"
#include "power_loss/cutter.hpp"

namespace airside::power_loss {

Loaded Cutter::load_store() {
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
  // Where a killed process and its successor wrote into one slot, the former's row may become whole by bytes that the
  // latter wrote alike, after its learning record is gone: the committed generation is then told to be older.
  const bool half_row_is_whole = loaded->outcome == hal::LoadOutcome::older && meaning_.in_flight.size() > 1;
  if (meaning_.committed > 0 && loaded->outcome != hal::LoadOutcome::newest && !half_row_is_whole) {
    result.finding = "generation " + std::to_string(loaded->generation) + ", committed " +
                     std::to_string(meaning_.committed) + ": " + text_of(loaded->outcome) + " (" +
                     std::to_string(loaded->damaged_records) + " damaged)";
    return result;
  }
  const Generation& want = meaning_.rows.at(loaded->generation);
  if (meaning_.committed == 0 && want.row.empty()) return first_learning(*loaded, result);
  const auto same = [](std::span<const std::byte> a, std::span<const std::byte> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size()) == 0;
  };
  // Of a row that a kill cut short the record has a part; that the rest is right is known by the header's digest.
  if (!want.row.empty() && !same(row_, want.row)) result.finding = "the row is a mixture";
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

Loaded Cutter::first_learning(const hal::LoadedState& loaded, Loaded result) const {
  const auto found = meaning_.learning.find(loaded.learning_generation);
  if (found == meaning_.learning.end() || found->second.size() != learning_.size() ||
      std::memcmp(found->second.data(), learning_.data(), learning_.size()) != 0) {
    result.finding = "the first learning record is a mixture";
  }
  return result;
}

std::string Cutter::judge(const Loaded& loaded, const Names& wanted, std::uint64_t box) {
  if (!loaded.some) {
    ++counts_.before_first;
    return meaning_.committed > 0 ? "a committed generation is lost" : "";
  }
  ++(loaded.generation == meaning_.committed ? counts_.old_generation : counts_.new_generation);
  if (loaded.generation < meaning_.committed) return "an old generation came back";
  if (std::string finding = judge_log(loaded, wanted, box); !finding.empty()) return finding;
  return judge_weights(loaded, wanted);
}

std::string Cutter::judge_log(const Loaded& loaded, const Names& wanted, std::uint64_t box) {
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

std::string Cutter::judge_log_now(const Loaded& loaded, const Names& wanted, std::uint64_t box) {
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

void Cutter::spoil(const Names& wanted, const std::string& name) {
  for (const auto& [path, inode] : wanted) {
    if (path.compare(0, 4, "log/") != 0 || path < name) continue;
    File& file = files_.at(inode);
    if (::ftruncate(fd_.at(inode), static_cast<off_t>(file.work.bytes.size())) != 0) {
      throw std::runtime_error("ftruncate");
    }
    write_pool(fd_.at(inode), file.work, 0, file.work.bytes.size());
  }
}

std::pair<std::int64_t, std::uint32_t> Cutter::position_of(const std::string& path) {
  const std::string text = path.substr(path.rfind('/') + 1);
  const auto time = hal::parse_civil_text(text.substr(8, 10) + "T00:00:00");
  if (!time) return {0, 0};
  const std::uint32_t part = text.size() > 22 ? static_cast<std::uint32_t>(std::stoul(text.substr(19, 2))) : 0;
  return {time->day(), part};
}

bool Cutter::is_pending_unlink(const std::string& path) const {
  return std::any_of(pending_names_.begin(), pending_names_.end(),
                     [&](const Trace::Op* op) { return op->kind == IoKind::unlink && op->name == path; });
}

std::string Cutter::judge_weights(const Loaded& loaded, const Names& wanted) {
  const RowFacts& trial = loaded.record;
  if (meaning_.committed > 0 && loaded.generation != meaning_.committed) {
    const RowFacts& old = meaning_.rows.at(meaning_.committed).record;
    if (trial.counter < old.counter) return "an old counter came back";
  }
  if (trial.counter > 0) {
    std::uint64_t counters = mixed(trial.counter, trial.blob_crc);
    for (const char* name : {"state/push_counters", "log/push_counters"}) {
      const auto found = wanted.find(name);
      counters = mixed(counters, found == wanted.end() ? 0 : files_.at(found->second).work.digest());
    }
    if (!good_counters_.contains(counters)) {
      hal::CounterLedger apart(state_dir_, log_dir_);
      apart.read();
      if (apart.highest(trial.key) < trial.counter) return "the counter that lies apart is behind the weights";
      good_counters_.insert(counters);
    }
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

void Cutter::report(const std::string& finding) {
  const std::scoped_lock lock(shared_.mutex);
  ++shared_.counts.all_findings;
  shared_.found = true;
  if (shared_.counts.findings.size() >= 20) return;
  shared_.counts.findings.push_back("operation " + std::to_string(crash_point_) + " of " +
                                    std::to_string(shared_.trace.ops.size()) + ": " + finding);
}

}  // namespace airside::power_loss
