#pragma once
// Finished replays by what went into them: a study asks for the same run again and again.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "sim/recording.hpp"

namespace airside::sim {

/// 128 bits of everything that a replay depends on.
struct ReplayKey {
  std::uint64_t high = 0, low = 0;

  /// Joins another part.  The same parts in the same order give the same key.
  void add(std::string_view part);
  std::string hex() const;
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

}  // namespace airside::sim
