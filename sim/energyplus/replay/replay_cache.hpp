#pragma once
// Finished replays by what went into them: a study asks for the same run again and again.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "sim/weather/recording.hpp"

namespace airside::sim {

/// 128 bits of everything that a replay depends on.
struct ReplayKey {
  std::uint64_t high = 0, low = 0;

  /// Joins another part.  The same parts in the same order give the same key.
  void add(std::string_view part);
  std::string hex() const;
  bool operator==(const ReplayKey&) const = default;
};

class ReplayCache {
 public:
  /// An empty folder name: a cache that holds nothing.
  /// Errors: hal::InputError if the folder cannot be made.
  explicit ReplayCache(std::filesystem::path folder);

  /// The table of the key; none if it is not there, damaged, or of another shape.
  std::optional<ChannelTable> find(const ReplayKey& key, Eigen::Index rows, Eigen::Index columns) const;

  /// Writes a table under its key: whole or not at all, whoever else writes it.
  /// Errors: hal::InputError if it cannot be written.
  void put(const ReplayKey& key, const ChannelTable& table) const;

  /// The file of a key.
  std::filesystem::path file_of(const ReplayKey& key) const;

 private:
  std::filesystem::path folder_;
};

/// The tables that a process asked for last.  Thread-safe: who asks for a table that another thread is making waits
/// for it.
class ReplayMemory {
 public:
  /// Cost: 0.5 MB a table of two weeks.
  explicit ReplayMemory(std::size_t most_tables = 32) : most_(most_tables) {}

  /// The key's table, by make() unless it is known.
  /// Errors: what make() throws, to all that wait for it; whoever asks later tries again.
  std::shared_ptr<const ChannelTable> get(const ReplayKey& key, const std::function<ChannelTable()>& make);

 private:
  using Table = std::shared_future<std::shared_ptr<const ChannelTable>>;
  struct Entry {
    ReplayKey key;
    Table table;
  };

  std::mutex mutex_;
  std::list<Entry> entries_;  ///< the last asked for comes first
  std::size_t most_;
};

}  // namespace airside::sim
