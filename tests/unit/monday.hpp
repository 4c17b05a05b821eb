#pragma once

#include "airside/civil_time.hpp"

namespace airside {

constexpr CivilTime monday{1'627'862'400};  ///< 2021-08-02 00:00

}  // namespace airside
