#include "hal/text/text_file.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "hal/text/input_error.hpp"

namespace airside::hal {

std::string read_text_file(const std::string& path, const std::string& expected) {
  std::error_code ignored;
  const bool directory = std::filesystem::is_directory(path, ignored);
  std::ifstream file(path, std::ios::binary);
  if (!file || directory) {
    throw InputError(path, directory ? "a directory" : "no file that can be read", expected,
                     directory ? "give the path of the file in it" : "check the path and its permissions");
  }
  std::ostringstream text;
  text << file.rdbuf();
  return std::move(text).str();
}

}  // namespace airside::hal
