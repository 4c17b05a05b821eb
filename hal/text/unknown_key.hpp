#pragma once
// A key of a TOML file that nobody reads.

#include <string>
#include <utility>

#include "hal/text/input_error.hpp"

namespace airside::hal {

/// Thrown by TomlSection::refuse_unknown_keys(), so that who knows more of the file can say where the key belongs.
class UnknownKey : public InputError {
 public:
  UnknownKey(std::string place, std::string section, std::string key, std::string expected, std::string remedy)
      : InputError(std::move(place), "an unknown key `" + key + "`", std::move(expected), std::move(remedy)),
        section_(std::move(section)),
        key_(std::move(key)) {}

  const std::string& section() const { return section_; }
  const std::string& key() const { return key_; }

 private:
  std::string section_, key_;
};

}  // namespace airside::hal
