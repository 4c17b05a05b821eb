#pragma once
// The lines of a log of somebody's own, as times of the model's clock and numbers of a mapping's columns.

#include <string>
#include <vector>

#include "tools/gap/clean_up/clean_up.hpp"
#include "tools/gap/map/mapping.hpp"

namespace airside::tools::gap {

/// One row a time, in order, each time once. Numbers are as the log has them.
struct MappedTable {
  std::vector<CivilTime> time;                ///< as it is stamped, by the model's clock
  std::vector<std::vector<double>> channels;  ///< as Mapping::channels, a number a row; NaN: missing
  std::vector<std::vector<double>> commands;  ///< as Mapping::commands
  std::vector<Remark> remarks;                ///< what could not be read
};

/// The time of one field in s since 1970 of standard time `zone_h` hours east of UTC; nothing where it is none.
/// `before`: the row before, which decides in the hour that a clock with daylight saving shows twice.
std::optional<CivilTime> mapped_time(const std::string& field, const MappedLog& log, double zone_h,
                                     std::optional<CivilTime> before);

/// `zone_h`: of the model's clock.
/// Errors: hal::InputError for a column that is not there, and for texts without one row that can be read.
MappedTable read_mapped_table(const std::vector<std::string>& texts, const Mapping& mapping, double zone_h,
                              const std::string& place);

}  // namespace airside::tools::gap
