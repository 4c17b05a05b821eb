#pragma once
// What a finding costs: energy with it less energy without it, under the same commands.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/gap/verdict/verdict.hpp"

namespace airside::tools::gap {

/// A tariff, the same for every meter.
struct Price {
  double per_kwh = 0;    ///< 0: none is known
  std::string currency;  ///< "EUR"
};

/// Of the model with all findings less the same without one of them, commands as recorded, mean over the days that
/// count.  kWh a day.
struct FindingEnergy {
  std::vector<double> by_meter;  ///< of each power channel
  double total = 0;              ///< their sum
  double low = 0, high = 0;      ///< of the sum, where the finding's 95 % interval ends; low <= high
  double without = 0;            ///< energy of all meters without the finding

  /// Whether the interval has one sign.
  bool is_sure() const { return low > 0 || high < 0; }
};

/// Of the curves `with` all findings and `without` this one.  With f the change that the finding makes, its magnitude m
/// and its null n, the interval's end e gives f (e - n) / (m - n).
/// Shape: bins x channels, half-hour means.  Units: kW in, kWh a day out.
FindingEnergy energy_of(const Finding& finding, const Eigen::MatrixXd& with, const Eigen::MatrixXd& without,
                        const sim::Channels& channels);

/// "it takes 3.2 kWh a day more (1.1 to 5.3), 0.48 EUR"; "" where there is no meter or the sign is not sure.
std::string sentence_of(const FindingEnergy& energy, const Price& price);

/// Format: docs/formats.md.
nlohmann::json json_of(const FindingEnergy& energy, const Finding& finding, const sim::Channels& channels,
                       const Price& price);

}  // namespace airside::tools::gap
