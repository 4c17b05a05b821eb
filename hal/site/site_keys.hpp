#pragma once
// Where the keys of a site file belong.

#include <string>
#include <string_view>

namespace airside::hal {

/// The tables of a site file that have a key of this name, such as "[setpoint]" or "[state] or [log]"; empty where
/// none has.
std::string sections_of_site_key(std::string_view key);

}  // namespace airside::hal
