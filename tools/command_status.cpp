#include "tools/command.hpp"

namespace airside::tools {

void add_status(CLI::App&) {}

}  // namespace airside::tools
