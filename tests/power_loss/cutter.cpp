#include "power_loss/cutter.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "airside/crc32c.hpp"
#include "hal/storage/folder_names.hpp"

namespace airside::power_loss {

Cutter::Cutter(Shared& shared, int job)
    : layout_(shared.options.scripted ? script_layout() : box_layout()),
      counts_of_log_(shared.options.scripted ? hal::counts_of<ThreeVav>() : hal::counts_of<FiveZone>()),
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

Cutter::~Cutter() {
  for (const auto& [inode, fd] : fd_) ::close(fd);
  ::close(pool_);
  ::close(box_);
}

void Cutter::follow(int round) {
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

bool Cutter::enough() const {
  const std::uint64_t distinct = shared_.seen.count();
  if (distinct >= shared_.options.most_states || shared_.ends()) return true;
  return round_ > 0 && distinct >= shared_.options.states;
}

void Cutter::give_counts() {
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

void Cutter::start_over() {
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

void Cutter::take(const Trace::Op& op) {
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

void Cutter::confirm(File& file) {
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

Cutter::File& Cutter::file_of(const Trace::Op& op) {
  const auto found = files_.find(op.inode);
  if (found == files_.end()) throw std::runtime_error("the record changes a file that it never saw made");
  return found->second;
}

std::uint64_t Cutter::size_now(const File& file) {
  std::uint64_t size = file.durable.bytes.size();
  for (const Cell& cell : file.pending) size = size_after(size, cell);
  return size;
}

std::uint64_t Cutter::size_after(std::uint64_t size, const Cell& cell) {
  if (cell.bytes.empty()) return cell.grows ? std::max(size, cell.offset) : cell.offset;
  return std::max(size, cell.offset + cell.bytes.size());
}

void Cutter::put(Content& content, const Cell& cell, std::size_t bytes) {
  if (!cell.bytes.empty()) {
    content.write(cell.offset, cell.bytes.first(std::min(bytes, cell.bytes.size())));
  } else if (const auto size = static_cast<std::size_t>(cell.offset); !cell.grows || size > content.bytes.size()) {
    content.resize(size);
  }
}

void Cutter::settle(Inode inode, File& file) {
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

void Cutter::write_pool(int fd, const Content& content, std::size_t from, std::size_t to) {
  const auto done = ::pwrite(fd, content.bytes.data() + from, to - from, static_cast<off_t>(from));
  if (done != static_cast<ssize_t>(to - from)) throw std::runtime_error("pwrite");
}

void Cutter::note_write(const Trace::Op& op, const File& file) {
  const std::string& name = file.first_name;
  if (name.compare(0, 13, "state/replay.") == 0) {
    const std::size_t stride = sizeof(hal::JournalEntry) + (layout_.transition_bytes + 7) / 8 * 8;
    const std::uint64_t odd = name.back() == 'b' ? 1 : 0;
    for (std::size_t at = 0; at + stride <= op.payload.size(); at += stride) {
      hal::JournalEntry entry;
      std::memcpy(&entry, op.payload.data() + at, sizeof entry);
      // The epoch is not in the entry but in its digest: one near the newest that a record has named.
      const auto bytes = op.payload.subspan(at + sizeof entry, layout_.transition_bytes);
      const std::uint64_t near = meaning_.newest_epoch < 4 ? 0 : (meaning_.newest_epoch - 4) / 2 * 2;
      for (std::uint64_t epoch = near + odd; epoch < near + 12; epoch += 2) {
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
    meaning_.newest_epoch = std::max(meaning_.newest_epoch, header.epoch);
    meaning_.front[op.inode] = header;
    if (is_row) {
      meaning_.row_in.erase(op.inode);
      const auto known = meaning_.rows.find(header.generation);
      if (known != meaning_.rows.end() && known->second.header.header_digest == header.header_digest) {
        return;  // a start writes what it has loaded again, as it is
      }
      if (!meaning_.in_flight.empty() && !excused_) report("a row record was never forced to the medium");
      excused_ = false;
      meaning_.in_flight.push_back(header.generation);
      meaning_.rows[header.generation] = {header, {}, meaning_.learning[header.learning_generation], {}};
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
  generation.record = facts_of(op.payload, shared_.options.scripted);
  meaning_.row_in[op.inode] = header.generation;
}

void Cutter::note_sync(Inode inode) {
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

void Cutter::note_push(const Trace::Op& op) {
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

void Cutter::cut_here(const Trace::Op& op) {
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

void Cutter::sample(std::size_t n, std::size_t d) {
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

void Cutter::make_state(const std::vector<bool>& chosen, const std::vector<bool>& names, std::size_t torn,
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

void Cutter::unwind(Inode inode) {
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

void Cutter::settle_from_disk(Inode inode, File& file) {
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

void Cutter::look(const Names& wanted, std::uint64_t store, std::uint64_t box) {
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

void Cutter::show(Inode inode, const File& file) {
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

void Cutter::link_names(const Names& wanted) {
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

void Cutter::read_names() {
  Names kept;
  for (const auto& [name, inode] : actual_) {
    struct stat of_name {
    }, of_file{};
    if (::fstatat(box_, name.c_str(), &of_name, 0) != 0) continue;
    // A file that the loading code removed may have been made anew by the trial row.
    const bool is_it = ::fstat(fd_.at(inode), &of_file) == 0 && of_name.st_ino == of_file.st_ino;
    if (is_it) kept[name] = inode;
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

}  // namespace airside::power_loss
