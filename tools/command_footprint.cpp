#include "tools/command.hpp"

namespace airside::tools {

void add_footprint(CLI::App&) {}

}  // namespace airside::tools
