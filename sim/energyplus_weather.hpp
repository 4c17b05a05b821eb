#pragma once
// EnergyPlus weather files (EPW): checked before the engine sees them, and changed for counterpart rooms.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/energyplus_options.hpp"

namespace airside::sim {

/// A weather file as text: eight header lines, then one record of comma-separated fields an interval.
struct EpwFile {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> records;
};

/// Reads a whole file.
/// Errors: hal::InputError for a file that is absent or no EPW, naming the line.
EpwFile read_epw(const std::filesystem::path& file);

/// The weather with offset, sun and storms of `change`; storm days are drawn from the seed.
EpwFile changed_epw(EpwFile weather, const WeatherChange& change, std::uint64_t seed);

void write_epw(const EpwFile& weather, const std::filesystem::path& file);

}  // namespace airside::sim
