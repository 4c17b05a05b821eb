#include "tools/command.hpp"

namespace airside::tools {

void add_study(CLI::App&) {}

}  // namespace airside::tools
