#pragma once
// EnergyPlus weather files (EPW): checked before the engine sees them, and changed for counterpart rooms.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/energyplus/options.hpp"
#include "sim/weather/epw.hpp"

namespace airside::sim {

/// A weather file as text: eight header lines, then one record of comma-separated fields an interval.
struct EpwFile {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> records;
};

/// Reads a file as the engine will, after read_epw_text() has found nothing wrong with it: the engine itself takes a
/// dry bulb of 85 degC or a humidity of -3 % without a word, and ends over the rest in words of its own.
/// Errors: hal::InputError as of read_epw(); also for a header that is not of eight lines, and for text in a column
///   that the engine alone reads.
/// Cost: a year by the hour, about 40 ms.
EpwFile read_epw_file(const std::filesystem::path& file, const EpwDemand& demand);

/// The weather with offset, sun and storms of `change`; storm days are drawn from the seed.
EpwFile changed_epw(EpwFile weather, const WeatherChange& change, std::uint64_t seed);

void write_epw(const EpwFile& weather, const std::filesystem::path& file);

}  // namespace airside::sim
