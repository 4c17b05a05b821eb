#pragma once
// The series that an EnergyPlus run reports (eplusout.eso): one value a time step, with all its digits.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace airside::sim {

class EsoFile {
 public:
  /// How many periods the file may hold. Models whose plant is sized by coincident loads simulate design days first,
  /// and the engine reports these, too; of several the last is kept.
  enum class Periods : std::uint8_t { one, last };

  /// Reads the whole file.
  /// Errors: hal::InputError for a file that is absent, cut short, or of more than one run period (Periods::one).
  /// Cost: 25 ms for 200,000 values.
  explicit EsoFile(const std::filesystem::path& file, Periods periods = Periods::one);

  /// The values of "KEY,Variable" or of a meter, "Electricity:HVAC", in the order of the steps. Units: the engine's
  /// (degC, J). Upper and lower case are the same.
  /// Errors: hal::InputError naming what the file lacks.
  const std::vector<double>& of(const std::string& name) const;

  /// Every series, by its name in upper case.
  const std::map<std::string, std::vector<double>>& series() const { return series_; }

 private:
  std::string file_;
  std::map<std::string, std::vector<double>> series_;
};

}  // namespace airside::sim
