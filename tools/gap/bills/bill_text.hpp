#pragma once
// A verdict on bills as JSON and in words.

#include <nlohmann/json.hpp>
#include <string>

#include "tools/gap/bills/bill_verdict.hpp"

namespace airside::tools::gap {

/// Format: docs/formats.md, "Verdicts on bills".
nlohmann::json json_of(const BillVerdict& verdict, const BillTable& bills);

/// For a terminal: the sentence, meters, probabilities, and what these bills could show.
std::string text_of(const BillVerdict& verdict);

}  // namespace airside::tools::gap
