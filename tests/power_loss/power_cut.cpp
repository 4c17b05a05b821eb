#include "power_loss/power_cut.hpp"

#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

#include "power_loss/cutter.hpp"

namespace airside::power_loss {

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
    const bool enough =
        shared.seen.count() >= std::min(options.states, options.most_states) || shared.ends() || shared.seen.full();
    if (enough || shared.seen.count() == before) break;
  }
  shared.counts.distinct = shared.seen.count();
  shared.counts.distinct_store = shared.seen_store.count();
  shared.counts.seconds = shared.seconds();
  return shared.counts;
}

}  // namespace airside::power_loss
