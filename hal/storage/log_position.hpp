#pragma once
// Where the log ends, as the durable record remembers it.

#include <cstdint>

namespace airside::hal {

/// File (day and part) and length of the row log after the last committed row. bytes 0: nothing was logged.
struct LogPosition {
  std::int64_t day = 0;    ///< CivilTime::day() of the file
  std::uint32_t part = 0;  ///< 0, or the number of the day's further file
  std::uint64_t bytes = 0;

  bool operator==(const LogPosition&) const = default;
};

}  // namespace airside::hal
