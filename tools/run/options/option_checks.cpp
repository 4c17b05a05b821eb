#include "tools/run/options/option_checks.hpp"

#include <charconv>
#include <cstdint>

#include "hal/text/input_error.hpp"

namespace airside::tools {

CLI::Validator seed_check() {
  return {[](const std::string& text) -> std::string {
            std::int64_t seed = -1;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
            if (error == std::errc{} && end == text.data() + text.size() && seed >= 0) return "";
            return "found " + text + "; expected a whole number from 0 to 9223372036854775807; give another seed";
          },
          ""};
}

void refuse_given(const CLI::App& command, std::initializer_list<const char*> options, const std::string& beside,
                  const char* expected, const char* remedy) {
  for (const char* option : options)
    if (command.count(option) > 0) throw hal::InputError(option, "given beside " + beside, expected, remedy);
}

}  // namespace airside::tools
