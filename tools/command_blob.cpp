#include "tools/command.hpp"

namespace airside::tools {

void add_blob(CLI::App&) {}

}  // namespace airside::tools
