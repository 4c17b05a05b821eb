#pragma once
// Reading a whole file that a person wrote.

#include <string>

namespace airside::hal {

/// The bytes of a file.
/// Errors: InputError when there is none, it is a directory, or it may not be read; `expected` says what should
/// stand at `path`, such as "a site file in TOML".
std::string read_text_file(const std::string& path, const std::string& expected);

}  // namespace airside::hal
