#pragma once
// JSON files as people write them: read with a complaint that names line and column.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace airside::sim {

constexpr int deepest_json = 100;  ///< an EnergyPlus model has 5

/// What parse_json() complains about, for readers with a parser of their own.
void refuse_deep_json(int depth, const std::string& place);
[[noreturn]] void refuse_json_number(const nlohmann::json::out_of_range& error, const std::string& place);

/// Reads one JSON text; `place` names it in complaints.
/// Errors: hal::InputError with line and column for a syntax error, a key that occurs twice in one object, a number
/// that no double holds, or brackets more than deepest_json deep (what reads a value later calls itself once a level).
nlohmann::json parse_json(const std::string& text, const std::string& place);

/// The bytes of a file. Errors: hal::InputError when it cannot be read.
std::string json_text(const std::filesystem::path& file);

/// parse_json() of a file.
/// Errors: hal::InputError also when the file cannot be read.
nlohmann::json read_json(const std::filesystem::path& file);

}  // namespace airside::sim
