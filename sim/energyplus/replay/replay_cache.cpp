#include "sim/energyplus/replay/replay_cache.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <vector>

#include "hal/storage/digest64.hpp"
#include "hal/text/input_error.hpp"

namespace airside::sim {
namespace {

/// The file: this header, the table column by column, and the digest of both.
struct CacheHeader {
  std::uint64_t magic = 0x3159414C50455241;  // "AREPLAY1"
  ReplayKey key;
  std::int64_t rows = 0, columns = 0;
};

std::span<const std::byte> bytes_of(const std::vector<char>& content, std::size_t size) {
  return std::as_bytes(std::span(content.data(), size));
}

}  // namespace

void ReplayKey::add(std::string_view part) {
  const auto bytes = std::as_bytes(std::span(part));
  high = hal::digest64(bytes, high ^ 0x9E3779B97F4A7C15u);
  low = hal::digest64(bytes, low ^ 0xC2B2AE3D27D4EB4Fu);
}

std::string ReplayKey::hex() const { return fmt::format("{:016x}{:016x}", high, low); }

ReplayCache::ReplayCache(std::filesystem::path folder) : folder_(std::move(folder)) {
  if (folder_.empty()) return;
  std::error_code failed;
  std::filesystem::create_directories(folder_, failed);
  if (!std::filesystem::is_directory(folder_, failed))
    throw hal::InputError(folder_.string(), "no folder, and none can be made", "a folder for finished replays",
                          "name another, or leave it out");
}

std::filesystem::path ReplayCache::file_of(const ReplayKey& key) const { return folder_ / (key.hex() + ".replay"); }

std::optional<ChannelTable> ReplayCache::find(const ReplayKey& key, Eigen::Index rows, Eigen::Index columns) const {
  if (folder_.empty()) return std::nullopt;
  std::ifstream in(file_of(key), std::ios::binary);
  const std::size_t values = static_cast<std::size_t>(rows * columns) * sizeof(double);
  const std::size_t signed_size = sizeof(CacheHeader) + values;
  std::vector<char> content(signed_size + sizeof(std::uint64_t) + 1);
  in.read(content.data(), static_cast<std::streamsize>(content.size()));
  if (static_cast<std::size_t>(in.gcount()) != content.size() - 1) return std::nullopt;

  CacheHeader header;
  const CacheHeader expected{CacheHeader{}.magic, key, rows, columns};
  std::uint64_t digest = 0;
  std::memcpy(&header, content.data(), sizeof header);
  std::memcpy(&digest, content.data() + signed_size, sizeof digest);
  if (std::memcmp(&header, &expected, sizeof header) != 0 || digest != hal::digest64(bytes_of(content, signed_size)))
    return std::nullopt;
  ChannelTable table(rows, columns);
  std::memcpy(table.data(), content.data() + sizeof header, values);
  return table;
}

void ReplayCache::put(const ReplayKey& key, const ChannelTable& table) const {
  if (folder_.empty()) return;
  static std::atomic<unsigned> written{0};
  const CacheHeader header{CacheHeader{}.magic, key, table.rows(), table.cols()};
  const std::size_t values = static_cast<std::size_t>(table.size()) * sizeof(double);
  std::vector<char> content(sizeof header + values);
  std::memcpy(content.data(), &header, sizeof header);
  std::memcpy(content.data() + sizeof header, table.data(), values);
  const std::uint64_t digest = hal::digest64(bytes_of(content, content.size()));

  const std::filesystem::path file = file_of(key);
  const std::filesystem::path staged = fmt::format("{}.{}-{}.new", file.string(), getpid(), written++);
  std::ofstream out(staged, std::ios::binary);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.write(reinterpret_cast<const char*>(&digest), sizeof digest);
  out.close();
  std::error_code failed;
  if (out) std::filesystem::rename(staged, file, failed);
  if (!out || failed) {
    std::error_code ignored;
    std::filesystem::remove(staged, ignored);
    throw hal::InputError(file.string(), "a file that cannot be written", "room for a finished replay",
                          "check folder, rights and space, or run without the cache");
  }
}

std::shared_ptr<const ChannelTable> ReplayMemory::get(const ReplayKey& key, const std::function<ChannelTable()>& make) {
  const auto place_of = [&] {
    return std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.key == key; });
  };
  std::promise<std::shared_ptr<const ChannelTable>> promise;
  {
    std::unique_lock lock(mutex_);
    if (const auto known = place_of(); known != entries_.end()) {
      entries_.splice(entries_.begin(), entries_, known);
      const Table table = known->table;
      lock.unlock();
      return table.get();
    }
    entries_.push_front({key, promise.get_future().share()});
    if (entries_.size() > most_) entries_.pop_back();
  }
  try {
    auto table = std::make_shared<const ChannelTable>(make());
    promise.set_value(table);
    return table;
  } catch (...) {
    promise.set_exception(std::current_exception());
    const std::lock_guard lock(mutex_);
    if (const auto failed = place_of(); failed != entries_.end()) entries_.erase(failed);
    throw;
  }
}

}  // namespace airside::sim
