#pragma once
// Bills: energy by meter and period, as a table that a person copied from paper.

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "airside/civil_time.hpp"

namespace airside::tools::gap {

struct BillPeriod {
  CivilTime from, to;  ///< midnights; `to` is the one after the last day
  double days() const { return static_cast<double>(to.seconds - from.seconds) / seconds_per_day; }
};

struct BillTable {
  std::string place;  ///< of the file, for complaints
  std::vector<std::string> meters;
  std::vector<BillPeriod> periods;  ///< in order, apart
  Eigen::MatrixXd kwh;              ///< periods x meters; NaN: no bill
};

/// Reads a CSV file with the columns `from`, `to` (dates, the last day is part of the bill) and one of each meter, kWh.
/// Shape: as BillTable; those of `meters` that have a column, in their order. Other columns are passed over.
/// Errors: hal::InputError with file, line and column: no meter with a column, a date or number that is none, a
/// period
///   that ends before it begins, goes over New Year or shares days with the one before, no number at all.
BillTable read_bills(const std::string& path, std::span<const std::string> meters);

/// The same of text; `path` stands in messages.
BillTable parse_bills(std::string_view text, const std::string& path, std::span<const std::string> meters);

}  // namespace airside::tools::gap
