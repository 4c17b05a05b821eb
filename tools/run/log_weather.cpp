#include "tools/run/log_weather.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "hal/text/input_error.hpp"

namespace airside::tools {

namespace fs = std::filesystem;

namespace {

std::string content_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

std::string weather_beside(const std::string& log) { return fs::path(log).replace_extension(".epw").string(); }

std::string weather_of_logs(const std::vector<std::string>& logs) {
  std::string found;
  for (const std::string& log : logs) {
    std::error_code ignored;
    if (log.empty() || !fs::is_regular_file(log, ignored)) continue;
    const std::string weather = weather_beside(log);
    if (!fs::is_regular_file(weather, ignored)) continue;
    if (!found.empty() && content_of(found) != content_of(weather)) {
      throw hal::InputError(weather, "other weather than in " + found, "logs of one room, which have one weather",
                            "simulate both on the same --room and --seed, or name one file with --weather");
    }
    if (found.empty()) found = weather;
  }
  return found;
}

}  // namespace airside::tools
