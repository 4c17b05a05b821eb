#include "sim/energyplus/words.hpp"

#include <sys/wait.h>

#include <cstring>
#include <fstream>
#include <vector>

namespace airside::sim {
namespace {

constexpr std::size_t most_lines = 8;  // of the engine's words in one message

/// Severe and Fatal lines with the lines that continue them.
std::vector<std::string> grave_lines(const std::filesystem::path& file) {
  std::vector<std::string> lines;
  std::ifstream in(file);
  bool grave = false;
  for (std::string line; std::getline(in, line) && lines.size() < most_lines;) {
    const auto has = [&line](const char* text) { return line.find(text) != std::string::npos; };
    if (!has("**   ~~~   **")) grave = has("** Severe") || has("**  Fatal") || has("** Fatal");
    if (!grave) continue;
    const auto first = line.find_first_not_of(' ');
    lines.push_back(first == std::string::npos ? line : line.substr(first));
  }
  return lines;
}

std::vector<std::string> all_lines(const std::filesystem::path& file) {
  std::vector<std::string> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line) && lines.size() < most_lines;) lines.push_back(line);
  return lines;
}

}  // namespace

std::string ending_text(int wait_status) {
  if (WIFSIGNALED(wait_status)) {
    const int number = WTERMSIG(wait_status);
    return "was ended by signal " + std::to_string(number) + " (" + strsignal(number) + ")";
  }
  return "ended with code " + std::to_string(WEXITSTATUS(wait_status));
}

std::string engine_words(const std::filesystem::path& error_file, const std::filesystem::path& log_file) {
  auto lines = grave_lines(error_file);
  if (lines.empty()) lines = grave_lines(log_file);
  if (lines.empty()) lines = all_lines(log_file);
  if (lines.empty()) return "; the engine left no message";
  std::string text = "; the engine says:";
  for (const auto& line : lines) text += "\n  " + line;
  return text;
}

}  // namespace airside::sim
