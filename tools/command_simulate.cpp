#include "tools/command.hpp"

namespace airside::tools {

void add_simulate(CLI::App&) {}

}  // namespace airside::tools
