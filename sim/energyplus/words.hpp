#pragma once
// What is said of an engine's process that failed: how it ended, and the engine's own words.

#include <filesystem>
#include <string>

namespace airside::sim {

/// "ended with code 1", "was ended by signal 11 (Segmentation fault)": of a status of waitpid().
std::string ending_text(int wait_status);

/// The Severe and Fatal lines of the engine's error file, else those of the process's log, else the log's first
/// lines: "; the engine says:" and one line each, or "; the engine left no message".
std::string engine_words(const std::filesystem::path& error_file, const std::filesystem::path& log_file);

}  // namespace airside::sim
