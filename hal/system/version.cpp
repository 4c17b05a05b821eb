#include "hal/system/version.hpp"

namespace airside::hal {

const char* version() { return AIRSIDE_VERSION; }

std::string version_line(const char* program) { return std::string(program) + " " + version(); }

}  // namespace airside::hal
