#pragma once
// EnergyPlus weather files (EPW): read with every line checked, written from a measured or made-up table.

#include <memory>
#include <optional>
#include <string>

#include "sim/weather/weather.hpp"

namespace airside::sim {

/// What a caller needs of a file.
struct EpwDemand {
  bool whole_year = true;             ///< false: a file of some days will do
  std::optional<CivilTime> from, to;  ///< must be covered, the year does not matter
};

/// Weather of an EPW file. The years in the records are ignored (typical years mix them); 29 February is left out.
/// Missing values (99.9, 999, 9999 ... as the format defines) are bridged linearly over at most 6 h; radiation that
/// is missing throughout is an error. Rain: a rain or drizzle code in present weather, or precipitation > 0.
/// With several records an hour, radiation is the interval's mean in W/m2, as EnergyPlus takes it.
/// Errors: hal::InputError with file:line and field: missing file or LOCATION, wrong column count, no number, outside
///   physical range, hours out of order or absent, period not covered.
/// Cost: 8760 lines, about 15 ms.
std::shared_ptr<const Weather> read_epw(const std::string& path, const EpwDemand& demand = {});

/// The same for text already in memory; `path` stands in messages.
std::shared_ptr<const Weather> read_epw_text(const std::string& text, const std::string& path,
                                             const EpwDemand& demand = {});

/// Writes a table as EPW; `year` is written into the records and gives the weekday of the period's start.
/// Any number of records an hour that divides 60 min is written as the format's header allows.
/// Errors: hal::InputError if the file cannot be written.
void write_epw(const std::string& path, const Weather& weather, int year);

}  // namespace airside::sim
