#include "tools/command.hpp"

namespace airside::tools {

void add_init(CLI::App&) {}

}  // namespace airside::tools
