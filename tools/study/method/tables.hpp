#pragma once
// The tables of the studies of the published method: mean ± sd of ours, and the published figure beside it.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/study/method/results.hpp"

namespace airside::tools {

/// One array entry a table: its name and title, columns (key, title, decimals), lines with `figures` (key: mean, sd,
/// count) and `published` (key: number). Lines without a run are left out, and tables without a line.
nlohmann::json method_tables_of(const MethodResults& results);

/// One of these tables as Markdown, its title first.
std::string method_table_markdown(const nlohmann::json& table);

}  // namespace airside::tools
