#include "hal/system/version.hpp"

namespace airside::hal {

const char* version() { return AIRSIDE_VERSION; }

}  // namespace airside::hal
