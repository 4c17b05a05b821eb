#pragma once
// A log of other columns, units, times and steps, read by a mapping file as rows of 6 min.

#include "tools/gap/clean_up/clean_up.hpp"
#include "tools/gap/map/mapping.hpp"

namespace airside::tools::gap {

/// Reads a log, or all `*.csv` of a folder in order of name, and cleans it up. Values of an instant are taken between
/// the two nearest rows, means by the time that they share with a row of 6 min, commands as they were last given; a
/// value holds for 1.5 steps of the log at most. Behind a row's sides stand the further commands.
/// `context`: its station's clock is the model's; its counts are counts_of(mapping).
/// Errors: hal::InputError for a file that is none, a column that the log has not, with the nearest names, and a log
///   without one row whose time can be read.
/// Cost: 2 weeks of 5 columns about 50 ms.
CleanLog read_mapped_log(const std::string& path, const Mapping& mapping, const CleanUpContext& context);

/// The same of the texts of files; context.place stands in messages.
CleanLog read_mapped_texts(const std::vector<std::string>& texts, const Mapping& mapping,
                           const CleanUpContext& context);

}  // namespace airside::tools::gap
