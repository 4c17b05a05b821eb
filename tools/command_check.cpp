#include "tools/command.hpp"

namespace airside::tools {

void add_check(CLI::App&) {}

}  // namespace airside::tools
